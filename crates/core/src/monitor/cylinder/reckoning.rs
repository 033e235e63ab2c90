//! When the readings of a cylinder are compared with dead reckoning, and what becomes of a departure.

use super::dead_reckoning::WaySource;
use super::{Cycle, Cylinder};
use crate::process::Process;
use crate::sequential::{Pair, Sequential};

impl Cylinder {
    fn reckons_by(&self, source: WaySource) -> bool {
        self.reckoning.as_ref().is_some_and(|it| it.goes_by(source))
    }

    /// Takes a cycle until which the oil has given the velocity.
    #[inline]
    pub(super) fn reckon_by_oil(&mut self, cycle: &Cycle) {
        if !self.reckons_by(WaySource::Oil) {
            return;
        }
        let velocity = self.process.as_deref().and_then(Process::speed);
        let Some(reckoning) = &mut self.reckoning else { return };
        reckoning.go(velocity);
        if reckoning.begin() {
            self.judge_reckoning(cycle);
        }
    }

    /// Takes a cycle in which the drive has given the velocity.
    #[inline]
    pub(super) fn reckon_by_drive(&mut self, cycle: &Cycle) {
        if !self.reckons_by(WaySource::Drive) {
            return;
        }
        let sequential = self.sequential.as_deref();
        self.reckon(cycle, sequential.and_then(Sequential::pair).and_then(Pair::velocity));
    }

    /// The same of a cylinder with one transducer, by the model alone.
    pub(super) fn reckon_by_model(&mut self, cycle: &Cycle) {
        if !self.reckons_by(WaySource::Model) {
            return;
        }
        let is_open = cycle.is_monitored() && !self.command.is_stale();
        let Some(reckoning) = &mut self.reckoning else { return };
        let by = &self.design.observers[0];
        let length = cycle.good[0].or(cycle.good[1]).map(|it| it.position);
        let velocity = reckoning.free_velocity(is_open, by, length, cycle.command);
        self.reckon(cycle, velocity);
    }

    #[inline(always)]
    fn reckon(&mut self, cycle: &Cycle, velocity: Option<f64>) {
        if self.reckoning.as_mut().is_some_and(|it| it.begin()) {
            self.judge_reckoning(cycle);
        }
        if let Some(reckoning) = &mut self.reckoning {
            reckoning.go(velocity);
        }
    }

    /// Judges the readings at a tick, and latches what departs from dead reckoning.
    #[inline(never)]
    fn judge_reckoning(&mut self, cycle: &Cycle) {
        // A stretch that began with a wild reading would be off for good.
        let lengths = cycle.lengths();
        let readings = [0, 1].map(|i| lengths[i].filter(|_| !self.fde.bank.is_open(i)));
        let is_explained = self.process.as_deref().is_some_and(|it| it.alarm().is_some());
        // The curve of a drive was not learnt beyond its lesson: in a sea of 3 m it was off by three times the most of
        // one of 2 m. And a stop holds the rod, however it is commanded: by whichever reading it is near one.
        let is_elsewhere = self.command.watch.is_beyond()
            || readings.into_iter().flatten().any(|it| self.design.is_near_end(it))
            || self.readings.has_idle_valve();
        let (compared, is_calm) = (self.compared(readings), !self.finds_anything());
        let Some(reckoning) = &mut self.reckoning else { return };
        if is_explained {
            reckoning.forget();
            self.last.shared = self.last.shared.filter(|it| it.is_jump);
        } else if is_elsewhere {
            reckoning.pause();
        } else if let Some(error) = reckoning.judge(readings, compared, is_calm) {
            // It would be found again at the next tick, and its end as another one.
            reckoning.forget();
            self.take_course_error(compared, error, cycle.now.opened);
        }
    }
}
