//! Departures from dead reckoning: of the last transducer, or of both alike.

use super::displacement::{Displacement, Latch, Limits, Watched};
use crate::alarm::{Evidence, Finding};
use crate::blame::{Accuser, Blamed, Rule};
use crate::monitor::cylinder::dead_reckoning::{Compared, CourseError, CourseJump};
use crate::monitor::cylinder::{Cycle, Cylinder};
use crate::state::whole;
use crate::time::{Span, Timestamp};
use crate::verdict::{Fault, Suspect, Testimony, Verdict, bank::Detection};

/// What both transducers are off by alike. Their difference is zero and both observers follow, so that it stands until the
/// readings return, or rest on the stop as before.
#[derive(Clone, Copy, Debug)]
pub struct SharedDeparture {
    /// m, signed.
    off: f64,
    /// What its newest part was compared with, m.
    limit: f64,
    since: Timestamp,
    /// Whether both have jumped, as no rod does. Otherwise the cylinder may not follow its valve, which a process detector may
    /// explain.
    is_jump: bool,
}

whole! { SharedDeparture { off, limit, since, is_jump } }

impl SharedDeparture {
    /// Takes another error. `None`: what is left would not have been found.
    fn and(self, error: f64, limit: f64) -> Option<Self> {
        let off = self.off + error;
        (off.abs() > limit).then_some(Self { off, limit, ..self })
    }

    /// m.
    pub const fn size(&self) -> f64 {
        self.off.abs()
    }

    pub const fn is_jump(&self) -> bool {
        self.is_jump
    }
}

/// What two errors have in common, m: the lesser of the two, if both have the same sign.
pub fn common([one, other]: [f64; 2]) -> f64 {
    match one * other > 0.0 {
        true if one.abs() < other.abs() => one,
        true => other,
        false => 0.0,
    }
}

impl Cylinder {
    /// What is compared with dead reckoning.
    pub(in super::super) fn compared(&self, readings: [Option<f64>; 2]) -> Compared {
        let is_apart = || self.doubts().0 || self.last.any_latched();
        match self.alone() {
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
                last.of[i].latch = Some(Latch { fault, residual, threshold, off: None, departs });
            }
            (_, None) => {
                let (off, limit) = (residual, threshold);
                last.shared = Some(SharedDeparture { off, limit, since, is_jump: false });
            }
        }
    }

    /// The finding of an observer, or what is latched of its transducer.
    pub(in super::super) fn observer_finding(&self, accuser: Accuser) -> Option<Finding> {
        let i = accuser.observed()? as usize;
        let blamed = self.blame(accuser, |_, _| {})?;
        let found = self.fde.bank.detections()[i];
        let Some(latch) = self.last.of[i].latch else {
            return found.map(|found| self.found(found, blamed));
        };
        let Latch { fault, residual, threshold, departs, .. } = latch;
        let latched = Detection { fault, residual, threshold };
        let found = found.filter(|_| departs.is_none()).unwrap_or(latched);
        let evidence = departs.map(|onset| self.departure_evidence([residual, threshold], onset));
        let level = self.design.levels.both;
        Some(Finding { level, evidence, ..self.found(found, blamed) })
    }

    /// The finding of both transducers, which depart alike.
    pub(in super::super) fn shared_finding(&self) -> Option<Finding> {
        let SharedDeparture { off: residual, limit: threshold, since, is_jump } =
            self.last.shared?;
        let (fault, rule) = match is_jump {
            true => (Fault::Abrupt, Rule::BothJump),
            false => (Fault::Incipient, Rule::BothDepart),
        };
        let found = Detection { fault, residual, threshold };
        let evidence = self.departure_evidence([residual, threshold], since);
        let by = if is_jump { Testimony::Innovations } else { Testimony::Way };
        // That it is latched is news where FDE1 stands already.
        let evidence = Some(Evidence { by: Some(by), size: Some(residual), ..evidence });
        Some(Finding { evidence, ..self.found(found, Blamed::new(Suspect::Process, rule)) })
    }

    /// As improbable as a Gaussian error of so many deviations.
    fn departure_evidence(&self, [error, limit]: [f64; 2], onset: Timestamp) -> Evidence {
        let deviations = self.design.reckoning.deviations * error / limit;
        Evidence {
            fault: 0.5 * deviations * deviations,
            location: None,
            by: Some(Testimony::Way),
            onset,
            gain: None,
            size: None,
        }
    }
}
