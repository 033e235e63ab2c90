//! What the deck's attitude says of the cylinders.

use super::Monitor;
use super::cylinder::Cylinder;
use super::gate::Opening;
use crate::decode::Value;
use crate::hexapod::{Inclination, Tilt, TiltChange, TiltLeg};
use crate::time::Timestamp;

impl Monitor {
    /// The comparison of the deck's attitude with a sensor on it, if there is one.
    pub fn tilt(&self) -> Option<&Tilt> {
        self.tilt.as_deref()
    }

    /// Compares the deck's attitude at the end of a cycle, and tells the cylinders whose readings have parted, or whose only one
    /// is off.
    #[inline]
    pub(super) fn follow_tilt(&mut self, at: Timestamp) {
        if self.tilt.is_some() {
            self.compare_tilt(at);
        }
    }

    #[inline(never)]
    fn compare_tilt(&mut self, at: Timestamp) {
        let is_open = self.gate.look(at).0 == Opening::Open;
        let Self { tilt: Some(tilt), cylinders, .. } = self else { return };
        if !is_open {
            // On its stops the deck stands otherwise: what is usual there is another tilt.
            tilt.forget();
            return;
        }
        let leg = |leg: usize| cylinders.get(leg).map_or(TiltLeg::default(), Cylinder::tilt_leg);
        let judgement = tilt.step(&core::array::from_fn(leg));
        for (cylinder, nats) in cylinders.iter_mut().zip(judgement.parted) {
            if let Some(nats) = nats {
                cylinder.take_attitude_evidence(nats);
            }
        }
        let Some(change) = judgement.change else { return };
        // A machine may monitor fewer cylinders than it has legs.
        let Some(cylinder) = cylinders.get_mut(change.leg()) else { return };
        match change {
            TiltChange::Moved(error) => cylinder.take_tilt_error(at, &error),
            TiltChange::Returned(_) => cylinder.end_tilt_error(),
        }
    }
}

/// Puts an angle where it is compared; returns 1 if no machine stands like that, or else 0.
pub(super) fn put(tilt: Option<&mut Tilt>, which: Inclination, value: Value) -> u64 {
    u64::from(!tilt.is_none_or(|it| it.put(which, value.physical)))
}
