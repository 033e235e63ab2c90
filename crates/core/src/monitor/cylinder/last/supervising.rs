//! Supervision of the last transducer: when its observer is evidence, what confirms a displacement, and what ends a latch.

use super::displacement::{Displacement, Latch, Limits};
use super::usual::MotionRange;
use crate::monitor::cylinder::findings::standing;
use crate::monitor::cylinder::{Cycle, Cylinder};
use crate::sample::plausibility::NOWHERE;
use crate::sample::{Quality, Transducer};
use crate::verdict::{Fault, Suspect, Verdict};

/// Names of the two transducers.
const NAMES: [Suspect; 2] = [Suspect::C1, Suspect::C2];

/// While nothing is found, one innovation of this many cycles is taken, and counts for all of them: nearly as good, and
/// cheaper.
const COUNTED_CYCLES: u32 = 4;

impl Cylinder {
    /// Supervises the last transducer in a cycle, after all detectors have judged it. Returns whether any finds anything.
    #[inline(always)]
    pub(in super::super) fn judge_last(&mut self, cycle: &Cycle) -> bool {
        if cycle.is_odd | self.last.is_attended | cycle.now.at_stop || self.detects_anything() {
            return self.attend_last(cycle);
        }
        self.follow_usual(cycle);
        self.last.difference = cycle.residuals.r[2];
        false
    }

    /// Takes a cycle in which nothing was found.
    #[inline(always)]
    fn follow_usual(&mut self, cycle: &Cycle) {
        let Some(reading) = cycle.good[0].or(cycle.good[1]) else { return };
        self.last.usual.extend(reading.position, cycle.command);
        if self.last.usual.calm.is_multiple_of(COUNTED_CYCLES) {
            for i in 0..2 {
                self.last.measure(i, cycle.residuals.r[i], COUNTED_CYCLES, &self.design);
            }
        }
    }

    /// [`Self::judge_last`] where anything is found, or was in the cycle before, or the rod stands on its stop.
    #[inline(never)]
    fn attend_last(&mut self, cycle: &Cycle) -> bool {
        if !self.has(Transducer::C2) {
            self.reckon_by_model(cycle);
        }
        let finds = self.finds_anything();
        if finds {
            self.judge_jump(cycle);
            self.doubt_last(cycle);
            self.try_motion(cycle);
            let beside = [0, 1].map(|i| !self.last.is_last(i, &self.design));
            for i in (0..2).filter(|i| beside[*i]) {
                self.last.measure(i, cycle.residuals.r[i], 1, &self.design);
            }
        } else if cycle.good.iter().any(Option::is_some) {
            self.last.forget();
            self.follow_usual(cycle);
        }
        self.last.difference = cycle.residuals.r[2];
        if cycle.now.at_stop {
            self.rest_last(cycle);
        } else {
            self.leave_stop();
        }
        let is_out = self.last.of.iter().any(|it| it.out != 0);
        self.last.is_attended = finds || is_out || cycle.now.at_stop;
        finds && self.finds_anything()
    }

    #[cold]
    fn doubt_last(&mut self, cycle: &Cycle) {
        // One of them has moved again.
        let high = self.design.bank.difference.high;
        self.last.has_joined &= cycle.residuals.r[2].is_none_or(|it| it.abs() <= high);
        let findings = self.findings();
        let blamed = |i: usize| standing(&findings).any(|it| it.suspect == NAMES[i]);
        for i in 0..2 {
            let is_doubtful = self.readings.quality(i) == Quality::Doubtful;
            let is_out = self.readings.is_implausible(i)
                || is_doubtful
                || self.last.is_latched(i)
                || blamed(i);
            let watched = &mut self.last.of[i];
            watched.out = if is_out { watched.out.saturating_add(1) } else { 0 };
        }
        for (i, transducer) in Transducer::ALL.into_iter().enumerate() {
            if self.has(transducer) {
                self.judge_alone(i, cycle);
            }
        }
        self.release_last();
    }

    fn judge_alone(&mut self, i: usize, cycle: &Cycle) {
        let residual = cycle.residuals.r[i];
        let found = self.fde.bank.detections()[i];
        let is_evidence = self.design.observes
            && self.last.is_last(i, &self.design)
            && self.last.usual.unusual == 0
            && !self.last.is_elsewhere(cycle, &self.design)
            && self.is_seen_by_difference(i, cycle)
            && self.process.as_ref().is_none_or(|it| it.alarm().is_none());
        let high = self.design.bank.observer.high;
        let usual = self.last.usual_step(i, &self.design);
        let least = self.last.least_step(i, &self.design);
        let limits = Limits { least, ..Limits::of(&self.design, i) };
        let is_apart = !self.readings.is_implausible(1 - i) && !self.last.is_latched(1 - i);
        let watched = &mut self.last.of[i];
        let exceeds =
            residual.is_some_and(|it| it.abs() > high.max(self.design.last.named * usual));
        watched.is_named = found.is_some() && (watched.is_named || is_evidence && exceeds);
        // The cycle after a displacement is judged by what is left of it, whatever the controller makes of it.
        if !is_evidence && watched.tried.is_none() {
            watched.beyond = 0;
            return;
        }
        let was_tried = watched.tried.is_some();
        if !was_tried {
            self.last.was_apart = is_apart;
        }
        let confirmed = watched.confirm(residual, &limits);
        if !was_tried && watched.tried.is_some() {
            let shown = self.reckoning.as_ref().and_then(|it| it.jump([i; 2], cycle.lengths()));
            watched.compare(shown, limits.stays);
        }
        if let (Some(latch), Some(found)) = (&mut watched.latch, found) {
            latch.fault = found.fault;
        }
        let Some(displacement) = confirmed else { return };
        if watched.latch.is_some() {
            self.take_return(i, displacement);
        } else {
            let fault = found.map_or(Fault::Unclassified, |found| found.fault);
            let (residual, off) = (displacement.innovation(), displacement.step());
            watched.latch = Some(Latch {
                fault,
                residual,
                threshold: high,
                off,
                is_back: false,
                departs: None,
            });
        }
        if self.last.was_apart {
            self.join(i, cycle);
        }
    }

    /// Takes another displacement of transducer `i`, which is latched. The reading is right again where it steps back by as much
    /// as it had stepped, and the rod's way shows that step, too: a rod that catches up looks the same to the observer.
    fn take_return(&mut self, i: usize, displacement: Displacement) {
        let watched = &mut self.last.of[i];
        let Some(latch) = &mut watched.latch else { return };
        latch.off = latch.off.zip(displacement.step()).map(|(off, step)| off + step);
        let is_small = latch.off.is_some_and(|off| off.abs() <= latch.threshold);
        latch.is_back = is_small && watched.jump.is_some();
    }

    /// Takes that transducer `i` was displaced while the other one stood off: where they agree since, neither can be relied
    /// on.
    fn join(&mut self, i: usize, cycle: &Cycle) {
        let agree =
            cycle.residuals.r[2].is_some_and(|it| it.abs() <= self.design.bank.difference.high);
        if !agree || !self.has(Transducer::ALL[1 - i]) {
            return;
        }
        let latch = self.last.of[i].latch;
        self.last.of[1 - i].latch = latch.map(|it| Latch { residual: -it.residual, ..it });
        self.last.has_joined = true;
    }

    /// Follows in which motion the observer of the last transducer is quiet.
    fn try_motion(&mut self, cycle: &Cycle) {
        let is_elsewhere = self.last.is_elsewhere(cycle, &self.design);
        let detections = self.fde.bank.detections();
        let is_watched =
            |i: &usize| self.has(Transducer::ALL[*i]) && self.last.is_last(*i, &self.design);
        let last = (0..2).find(|i| is_watched(i) && cycle.good[*i].is_some());
        let is_quiet = last
            .is_some_and(|i| detections[i].is_none() && cycle.residuals.r[i].is_some())
            && !self.last.any_latched();
        let length = last.and_then(|i| cycle.good[i]).map(|it| it.position);
        let settle = self.design.observers[0].settle;
        let usual = &mut self.last.usual;
        let motion = usual.motion(length.unwrap_or_default(), cycle.command);
        let motion = MotionRange { been: length.map_or(NOWHERE, |it| [it; 2]), ..motion };
        usual.try_out(&motion, is_elsewhere, is_quiet, settle, self.design.last);
    }

    /// Whether C1 − C2, where it is still known, has jumped as the innovation of transducer `i` says: an error of the model
    /// is not in it.
    fn is_seen_by_difference(&self, i: usize, cycle: &Cycle) -> bool {
        let jump = cycle.residuals.r[2].zip(self.last.difference).map(|(now, before)| now - before);
        let own = cycle.residuals.r[i].unwrap_or_default();
        jump.is_none_or(|jump| jump.abs() >= self.design.last.stays * own.abs())
    }

    /// Ends the latches. Dead reckoning has seen the step as well: 4 s after one that had gone back it found a departure by as
    /// much, and latched the sound transducer again.
    fn release_latches(&mut self) {
        self.last.release();
        if let Some(reckoning) = &mut self.reckoning {
            reckoning.forget();
        }
    }

    /// Ends the latch when the other transducer is back, and both agree, or when the last one has stepped back.
    fn release_last(&mut self) {
        // Until its observer is quiet the step back is the transducer's, as the step was: released at once, the incident of a
        // step of C2 became one of *C1 or C2* in its last second.
        let detections = self.fde.bank.detections();
        let has_returned = |i: usize| {
            detections[i].is_none()
                && !self.last.is_latched(1 - i)
                && self.last.of[i].latch.is_some_and(|it| it.is_back)
        };
        if has_returned(0) || has_returned(1) {
            return self.release_latches();
        }
        let is_back = |i: usize| {
            self.has(Transducer::ALL[i])
                && !self.readings.is_implausible(i)
                && self.readings.quality(i) == Quality::Good
        };
        let agree = self.fde.bank.verdicts()[2] == Verdict::Healthy;
        let differ =
            self.last.has_joined || self.sequential.as_ref().is_some_and(|it| it.alarm().is_some());
        if self.last.any_latched() && is_back(0) && is_back(1) && agree && !differ {
            self.release_latches();
        }
    }

    /// Takes the readings on the mechanical stop.
    #[cold]
    fn rest_last(&mut self, cycle: &Cycle) {
        let stands = self.design.observers[0].settle.max(1);
        for (rest, reading) in self.last.rests.iter_mut().zip(cycle.lengths()) {
            let Some(reading) = reading else { continue };
            rest.take(reading, self.design.bank.observer.high, stands);
        }
        let high = self.design.bank.observer.high;
        let agrees = |i: usize| self.last.rests[i].agrees(high, stands);
        // The deck's attitude finds an error of C1.
        let is_out = |i: usize| {
            self.last.is_latched(i) || self.last.shared.is_some() || i == 0 && self.tilted.is_some()
        };
        if (0..2).any(is_out) && (0..2).all(|i| !is_out(i) || agrees(i)) {
            self.release_latches();
            (self.last.shared, self.tilted) = (None, None);
        }
    }

    /// Keeps what was read on the stop that the rod has left, if nothing was found.
    #[cold]
    fn leave_stop(&mut self) {
        let is_healthy = !self.finds_anything();
        self.last.rests.iter_mut().for_each(|rest| rest.leave(is_healthy));
    }
}
