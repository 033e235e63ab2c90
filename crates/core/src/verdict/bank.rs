//! The bank of fault detection estimators of one cylinder (Figure 5-17), which judges its
//! residuals.

use super::Verdict;
use super::fault::{Fault, Signatures, classify_difference};
use super::history::ResidualHistory;
use super::jump::Jump;
use super::parameters::{LONGEST_DIFFERENCES, LONGEST_WINDOW, VerdictCycles, VerdictParameters};
use super::persistence::{Persistence, ResidualSample};
use super::trigger::{FdeState, Raise, Thresholds, Trigger};
use super::unaligned::Unaligned;
use crate::state::{state, whole};
use crate::time::Timestamp;

/// Residuals of one cycle, m, signed; `None` where there is nothing to judge.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residuals {
    /// R1, R2 and R3.
    pub r: [Option<f64>; 3],
}

/// Parameters of the bank of one cylinder.
#[derive(Clone, Debug)]
pub struct BankDesign {
    /// Thresholds of R1 and R2.
    pub observer: Thresholds,
    /// R1 or R2 beyond which it is a fault where C1 − C2 shows it, too ([`Jump`]), m; infinite where no such rule holds.
    pub joint: f64,
    /// Thresholds of R3.
    pub difference: Thresholds,
    /// Samples for which a residual has to stay beyond its threshold to be a fault, at least 1.
    pub lasting: u32,
    /// Whether a calibration has told by how much C1 and C2 differ.
    pub calibrated: bool,
    /// Signatures of faults in R1 and R2.
    pub signatures: [Signatures; 2],
    pub parameters: &'static VerdictParameters,
    /// s.
    pub sample_time: f64,
}

/// Detection of a fault by an FDE.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    pub fault: Fault,
    /// Newest residual, m, signed.
    pub residual: f64,
    /// Threshold that it has exceeded, m: δ_h, or that of joint evidence.
    pub threshold: f64,
}

/// Number of FDEs.
pub const FDES: usize = 3;

/// Place of FDE3 among them.
pub const FDE3: usize = 2;

/// The FDEs as whom to blame follows from them.
#[derive(Clone, Copy, Debug)]
pub struct Raised {
    /// States of FDE1, FDE2 and FDE3; on a cylinder without a calibration FDE3's by what the difference has grown by.
    pub fdes: [FdeState; FDES],
    /// When what each of them has found began; `None` where it has found nothing.
    pub found: [Option<Raise>; FDES],
    /// Whether FDE3 has found no more than that C1 and C2 have never been calibrated.
    pub is_not_calibrated: bool,
}

/// FDE1, FDE2 and FDE3 of one cylinder.
#[derive(Clone, Debug)]
pub struct Bank {
    triggers: [Trigger; 3],
    verdicts: [Verdict; 3],
    persistence: [Persistence; 3],
    /// Whether any of them is open.
    is_exceeded: bool,
    newest: [f64; 3],
    observed: [ResidualHistory<LONGEST_WINDOW>; 2],
    difference: ResidualHistory<LONGEST_DIFFERENCES>,
    found: [Option<Found>; 3],
    /// Whether an FDE was raised by joint evidence, and its residual has not exceeded δ_h since; never FDE3.
    by_joint: [bool; 3],
    /// `None` where C1 and C2 are calibrated.
    unaligned: Option<Unaligned>,
    /// Whether any FDE has found a fault.
    any_found: bool,
    /// Signatures of faults in R1 and R2.
    signatures: [Signatures; 2],
    joint: f64,
    /// Residuals up to which no FDE is raised, m.
    calm: [f64; 3],
    parameters: &'static VerdictParameters,
    cycles: VerdictCycles,
}

state! {
    Bank { triggers, verdicts, persistence, is_exceeded, newest, observed, difference, found, by_joint, any_found }
    parts { unaligned }
    but { signatures, joint, calm, parameters, cycles }
}

/// State of a raised FDE.
#[derive(Clone, Copy, Debug)]
struct Found {
    fault: Fault,
    /// Cycles since the residual first exceeded its threshold.
    age: u32,
}

whole! { Found { fault, age } }

impl Bank {
    pub fn new(design: &BankDesign) -> Self {
        let observer = Trigger::new(design.observer);
        let least = design.observer.high.min(design.joint);
        Self {
            triggers: [observer.clone(), observer, Trigger::new(design.difference)],
            verdicts: [Verdict::Unknown; 3],
            persistence: core::array::from_fn(|_| {
                Persistence::new(design.lasting, design.parameters)
            }),
            is_exceeded: false,
            newest: [0.0; 3],
            observed: [ResidualHistory::default(), ResidualHistory::default()],
            difference: ResidualHistory::default(),
            found: [None; 3],
            by_joint: [false; 3],
            unaligned: (!design.calibrated).then(|| {
                let VerdictParameters { stood, gain, .. } = *design.parameters;
                Unaligned::new(design.difference, stood, gain)
            }),
            any_found: false,
            signatures: design.signatures.clone(),
            joint: design.joint,
            calm: [least, least, design.difference.high],
            parameters: design.parameters,
            cycles: design.parameters.cycles(design.sample_time),
        }
    }

    /// Takes residuals that raise nothing while nothing is raised, as nearly all are, as [`Self::judge`] would, but asks
    /// nothing else. Returns `false`, and does nothing, for any others.
    #[inline(always)]
    pub fn take_calm(&mut self, residuals: &Residuals) -> bool {
        let [r1, r2, r3] = residuals.r;
        // Not a number is not calm.
        let is_calm = |i: usize, it: Option<f64>| it.is_none_or(|it| it.abs() <= self.calm[i]);
        // After a cycle has been judged a trigger is raised only where something is found.
        let is_open = self.any_found || self.is_exceeded || self.unaligned.is_some();
        if is_open || !is_calm(0, r1) || !is_calm(1, r2) || !is_calm(FDE3, r3) {
            return false;
        }
        for (i, residual) in [(0, r1), (1, r2)] {
            self.verdicts[i] = Verdict::Unknown;
            if let Some(residual) = residual {
                (self.verdicts[i], self.newest[i]) = (Verdict::Healthy, residual);
                self.observed[i].push(residual);
            }
        }
        self.verdicts[FDE3] = Verdict::Unknown;
        if let Some(residual) = r3 {
            (self.verdicts[FDE3], self.newest[FDE3]) = (Verdict::Healthy, residual);
            self.difference.push(residual);
        }
        true
    }

    /// Takes the residuals of the cycle at `at`, in which C1 read `length`, m, and how C1 − C2 has moved; `aside` are R1 and R2
    /// without the readings that may be wild. [`Self::verdicts`] and [`Self::detections`] then give the results.
    #[inline(never)]
    pub fn judge(
        &mut self,
        at: Timestamp,
        residuals: &Residuals,
        aside: [Option<f64>; 2],
        length: Option<f64>,
        jump: Option<Jump>,
    ) {
        let joint = jump.and_then(|jump| self.joint(residuals, jump));
        for (i, residual) in residuals.r.into_iter().enumerate() {
            if let Some(residual) = residual {
                self.newest[i] = residual;
                match self.observed.get_mut(i) {
                    Some(observed) => observed.push(residual),
                    None => self.difference.push(residual),
                }
            }
            let is_joint = joint == Some(i);
            let other = [residuals.r[1], residuals.r[0], None][i];
            let stands = aside.get(i).copied().flatten();
            let residual = residual.filter(|it| !it.is_nan());
            let sample = residual.map(|residual| ResidualSample { residual, stands, other });
            match self.triggers[i].raised() {
                Some(_) => self.go_on(i, at, sample, is_joint),
                None => self.begin(i, at, sample, is_joint),
            }
            if sample.is_none() {
                self.persistence[i].dismiss();
            }
        }
        self.is_exceeded = self.persistence.iter().any(Persistence::is_open);
        if let Some(unaligned) = &mut self.unaligned {
            unaligned.judge(at, residuals.r[FDE3], length);
        }
        if self.triggers.iter().any(|t| t.raised().is_some()) || self.any_found() {
            self.remember();
        }
    }

    /// Judges the residual of an FDE that is raised.
    fn go_on(&mut self, i: usize, at: Timestamp, sample: Option<ResidualSample>, is_joint: bool) {
        let (trigger, persistence) = (&mut self.triggers[i], &mut self.persistence[i]);
        let (high, residual) = (trigger.thresholds().high, sample.map(|it| it.residual));
        // A single reading that is wild is evidence neither of a fault nor of its end.
        let goes_on = sample.is_none_or(|it| persistence.goes_on(at, it, it.residual.abs() > high));
        self.verdicts[i] =
            trigger.judge(at, residual.filter(|_| goes_on || !persistence.is_open()));
        if is_joint {
            self.by_joint[i] &= residual.is_none_or(|it| it.abs() <= high);
            self.verdicts[i] = trigger.raise(at);
        }
    }

    /// Raises an FDE once its residual has stayed beyond the threshold.
    fn begin(&mut self, i: usize, at: Timestamp, sample: Option<ResidualSample>, is_joint: bool) {
        let (trigger, persistence) = (&mut self.triggers[i], &mut self.persistence[i]);
        let high = trigger.thresholds().high;
        let Some(sample) = sample else { return self.verdicts[i] = trigger.judge(at, None) };
        let exceeds = is_joint || sample.residual.abs() > high;
        self.verdicts[i] = match persistence.take(at, sample, exceeds) {
            Some(lasting) => {
                self.by_joint[i] = lasting.largest.abs() <= high;
                self.newest[i] = lasting.largest;
                trigger.raise_since(lasting.since, at)
            }
            // Not evidence of a fault yet, nor of a healthy reading.
            None if persistence.is_open() => Verdict::Unknown,
            None => Verdict::Healthy,
        };
    }

    /// Whether a residual has exceeded its threshold, and may yet be wild.
    pub const fn is_exceeded(&self) -> bool {
        self.is_exceeded
    }

    /// R1 or R2 of the cycle before, m, where `residual`, m, exceeds the threshold for the first time, and is no fault yet.
    pub fn former_of_new(&self, i: usize, residual: f64) -> Option<f64> {
        let is_new = self.triggers[i].raised().is_none() && !self.persistence[i].is_immediate();
        (is_new && residual.abs() > self.calm[i]).then_some(self.newest[i])
    }

    /// Whether the residual of an observer exceeded its threshold for the first time in the newest cycle, and may be wild.
    pub fn may_be_wild(&self, i: usize) -> bool {
        self.persistence[i].has_begun()
    }

    /// Whether `residual`, m, of an observer is still where the first one beyond the threshold was.
    pub fn stays(&self, i: usize, residual: f64) -> bool {
        self.persistence[i].stays(residual)
    }

    /// Whether the residual of an observer has exceeded its threshold, and may yet be wild.
    pub const fn is_open(&self, i: usize) -> bool {
        self.persistence[i].is_open()
    }

    /// The observer, 0 or 1, that alone exceeds the threshold of joint evidence while C1 − C2 has moved with it.
    #[inline]
    fn joint(&self, residuals: &Residuals, jump: Jump) -> Option<usize> {
        let (r1, r2) = residuals.r[0].zip(residuals.r[1])?;
        let is_of = |own: f64, other: f64, jump: Jump| {
            own.abs() > self.joint && jump.shows(own, other, self.parameters)
        };
        if is_of(r1, r2, jump) { Some(0) } else { is_of(r2, r1, jump.reversed()).then_some(1) }
    }

    /// Restarts the clearing times after a time jump; detections stand.
    pub fn interrupt(&mut self) {
        self.interrupt_of([true; 2]);
    }

    /// As [`Self::interrupt`], where only what one or both of the observers follow was `lost`, C1 first.
    pub fn interrupt_of(&mut self, lost: [bool; 2]) {
        self.unaligned.iter_mut().for_each(Unaligned::interrupt);
        for (i, lost) in [lost[0], lost[1], true].into_iter().enumerate() {
            if lost {
                self.triggers[i].interrupt();
                self.persistence[i].interrupt();
                self.verdicts[i] = Verdict::Unknown;
            }
        }
        self.is_exceeded = self.persistence.iter().any(Persistence::is_open);
        for (observed, _) in self.observed.iter_mut().zip(lost).filter(|(_, lost)| *lost) {
            observed.clear();
        }
        self.difference.clear();
    }

    /// The verdicts of FDE1, FDE2 and FDE3.
    pub const fn verdicts(&self) -> [Verdict; 3] {
        self.verdicts
    }

    /// Present detections of FDE1, FDE2 and FDE3.
    pub fn detections(&self) -> [Option<Detection>; 3] {
        core::array::from_fn(|i| {
            let high = self.triggers[i].thresholds().high;
            self.found[i].map(|found| Detection {
                fault: found.fault,
                residual: self.newest[i],
                threshold: if self.by_joint[i] { self.joint } else { high },
            })
        })
    }

    /// For how many cycles FDE3 has been raised.
    pub fn difference_age(&self) -> Option<u32> {
        self.found[FDE3].map(|found| found.age)
    }

    /// The FDEs as whom to blame follows from them.
    pub fn raised(&self) -> Raised {
        let mut fdes = core::array::from_fn(|i| FdeState {
            verdict: self.verdicts[i],
            raised: self.triggers[i].raised(),
        });
        let unaligned = self.unaligned();
        fdes[FDE3] = unaligned.map_or(fdes[FDE3], Unaligned::fde);
        let began = |i: usize| {
            let grown = unaligned.filter(|_| i == FDE3).and_then(Unaligned::grown);
            grown.or(self.triggers[i].raised())
        };
        Raised {
            fdes,
            found: core::array::from_fn(|i| self.found[i].and_then(|_| began(i))),
            is_not_calibrated: self.found[FDE3].is_some_and(|it| it.fault == Fault::NotCalibrated),
        }
    }

    pub const fn any_found(&self) -> bool {
        self.any_found
    }

    /// Updates the detections of the raised FDEs. Nearly always there are none, so this is kept out
    /// of line.
    #[cold]
    fn remember(&mut self) {
        for i in 0..3 {
            if self.triggers[i].raised().is_none() {
                self.found[i] = None;
                self.by_joint[i] = false;
                continue;
            }
            if let Some(unaligned) = self.unaligned().filter(|_| i == FDE3) {
                let found = self.found[i].filter(|it| it.fault == Fault::NotCalibrated);
                if unaligned.grown().is_none() {
                    let age = found.map_or(0, |found| found.age.saturating_add(1));
                    self.found[i] = Some(Found { fault: Fault::NotCalibrated, age });
                    continue;
                }
                if found.is_some() {
                    self.found[i] = None;
                }
            }
            let found = self.found[i].map(|found| found.age.saturating_add(1));
            let age = found.unwrap_or(self.persistence[i].waited());
            let fault = match self.found[i] {
                Some(found) if !self.cycles.looks.contains(&age) => found.fault,
                _ => self.classify(i),
            };
            self.found[i] = Some(Found { fault, age });
        }
        self.any_found = self.found.iter().any(Option::is_some);
    }

    /// The difference that stands since the start, where it says nothing of a transducer.
    fn unaligned(&self) -> Option<&Unaligned> {
        self.unaligned.as_ref().filter(|it| it.stood())
    }

    fn classify(&self, i: usize) -> Fault {
        let Self { signatures, parameters, cycles, .. } = self;
        match signatures.get(i) {
            Some(of_observer) => {
                of_observer.classify(&self.observed[i].in_order(), parameters, cycles)
            }
            None => {
                let it = &self.difference;
                match classify_difference(&it.in_order(), it.known(), parameters, cycles) {
                    // R3 is not the size of a step of it.
                    Fault::Abrupt if self.unaligned().is_some() => Fault::Incipient,
                    fault => fault,
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
