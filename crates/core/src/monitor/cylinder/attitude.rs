//! What the deck's attitude is compared by, and what it says of the cylinder.

use super::Cylinder;
use super::tilted::Tilted;
use crate::blame::Accuser;
use crate::hexapod::{TiltError, TiltLeg};
use crate::sample::Transducer;
use crate::sequential::Sequential;
use crate::time::{Span, Timestamp};
use crate::verdict::{Fault, Testimony};

impl Cylinder {
    /// What the deck's attitude is compared by in the newest cycle.
    pub fn tilt_leg(&self) -> TiltLeg {
        let parted = || self.sequential.as_deref().and_then(Sequential::residual);
        let (is_doubted, has_parted) = self.doubts();
        let is_single = !self.has(Transducer::C2);
        // Nothing else shows that a single reading is wild, and its mean would be wrong for seconds.
        let is_wild = is_single && self.fde.bank.is_open(Transducer::ALL[0] as usize);
        TiltLeg {
            length: self.length.filter(|_| !is_wild),
            is_healthy: !is_doubted,
            is_single,
            parted: has_parted.then(parted),
        }
    }

    /// Takes the evidence of whose reading has moved that the deck's attitude gives, nats.
    pub fn take_attitude_evidence(&mut self, nats: f64) {
        if let Some(sequential) = &mut self.sequential {
            sequential.take_evidence(Testimony::Attitude, nats);
        }
    }

    /// Takes at `at` that the only transducer is off.
    pub fn take_tilt_error(&mut self, at: Timestamp, error: &TiltError) {
        let (size, nats) = (error.size, [error.nats, error.apart]);
        let (fault, onset) = match &self.tilted {
            Some(before) => (before.fault, before.onset),
            None => (self.kind_of_tilt(), at.after(Span::from_seconds(-error.since))),
        };
        self.tilted = Some(Tilted { fault, size, nats, onset });
        self.is_busy = true;
    }

    /// Takes that the deck is again where the only transducer has it.
    pub const fn end_tilt_error(&mut self) {
        self.tilted = None;
    }

    /// The kind of an error that tilts the deck: a step of that size is seen by the observer, so that what it has not seen
    /// has grown slowly.
    fn kind_of_tilt(&self) -> Fault {
        let latched = self.last.names(0).then(|| self.observer_finding(Accuser::Fde1)).flatten();
        let of_observer = latched.map(|it| it.fault);
        let unseen = if self.design.observes { Fault::Incipient } else { Fault::Unclassified };
        of_observer.unwrap_or(unseen)
    }
}
