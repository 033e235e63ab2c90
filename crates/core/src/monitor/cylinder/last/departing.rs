//! Departures from dead reckoning: of the last transducer, or of both alike.

use super::displacement::{Displacement, Latch, Limits, Watched};
use super::shared::SharedDeparture;
use crate::monitor::cylinder::dead_reckoning::{Compared, CourseError, CourseJump, common};
use crate::monitor::cylinder::{Cycle, Cylinder};
use crate::time::{Span, Timestamp};
use crate::verdict::{Fault, Verdict};

impl Cylinder {
    /// What is compared with dead reckoning.
    pub(in super::super) fn compared(&self, readings: [Option<f64>; 2]) -> Compared {
        let is_apart = || self.doubts().0 || self.last.any_latched();
        match self.last.alone(&self.design) {
            Some(i) => Compared::Alone(i),
            None if readings.iter().all(Option::is_some) && !is_apart() => Compared::Together,
            None => Compared::Neither,
        }
    }

    /// Takes innovations that jump together while C1 − C2 stays, and go on doing so. By a model that fits badly a rod at work
    /// has such innovations, too, so that dead reckoning has to show the same jump.
    #[cold]
    pub(super) fn judge_jump(&mut self, cycle: &Cycle) {
        let Some(reckoning) = &mut self.reckoning else { return };
        let [fde1, fde2, _] = self.fde.bank.detections().map(|it| it.map(|it| it.residual));
        let [r1, r2, _] = cycle.residuals.r;
        let last = &mut self.last;
        let raised = fde1.zip(fde2);
        let was_raised = core::mem::replace(&mut last.are_raised, raised.is_some());
        // Beside a sequential detector the observers have followed by the time that a jump is known not to be wild.
        let both = raised.filter(|_| !was_raised).or(r1.zip(r2));
        let innovation = both.map(|(one, other)| common([one, other]));
        if self.fde.bank.verdicts()[2] == Verdict::Faulty {
            last.together = Watched::default();
            return;
        }
        let stays = self.design.last.stays;
        let limits = Limits { noise: u32::MAX, ..Limits::of(&self.design, 0) };
        let was_tried = last.together.tried.is_some();
        let confirmed = last.together.confirm(innovation, &limits);
        if !was_tried && last.together.tried.is_some() {
            last.together.compare(reckoning.jump([0, 1], cycle.lengths()), stays);
        }
        let Some(jump) = confirmed.and_then(Displacement::step) else { return };
        let lasted = f64::from(limits.confirm) * self.design.bank.sample_time;
        let since = cycle.now.at.after(Span::from_seconds(-lasted));
        last.shared = match (last.shared, last.together.jump) {
            (None, Some(CourseJump { error: off, limit })) => {
                Some(SharedDeparture { off, limit, since, is_jump: true })
            }
            (Some(shared), Some(CourseJump { error, limit })) => shared.and(error, limit),
            // Back by as much, where the way is not known just then.
            (Some(shared), None) if jump / shared.off < -stays => shared.and(jump, shared.limit),
            (_, None) => return,
        };
        // Or it would be found once more.
        reckoning.forget();
    }

    /// Takes a departure from dead reckoning: latches the last transducer, or what both are off by. So does a cylinder that
    /// does not follow its command, unless a process detector has found why; either way nothing is left to rely on.
    #[cold]
    pub(in super::super) fn take_course_error(
        &mut self,
        compared: Compared,
        error: CourseError,
        at: Timestamp,
    ) {
        let CourseError { error: residual, limit: threshold, seconds } = error;
        let since = at.after(Span::from_seconds(-seconds));
        self.last.is_attended = true;
        let last = &mut self.last;
        match (compared, last.shared) {
            (_, Some(shared)) => last.shared = shared.and(residual, threshold),
            (Compared::Alone(i), None) => {
                let fault = Fault::Incipient;
                let departs = Some(since);
                last.of[i].latch =
                    Some(Latch { fault, residual, threshold, off: None, is_back: false, departs });
            }
            (_, None) => {
                let (off, limit) = (residual, threshold);
                last.shared = Some(SharedDeparture { off, limit, since, is_jump: false });
            }
        }
    }
}
