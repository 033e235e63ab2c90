//! Alarms of a sequential detector.

use super::scale::Scale;
use super::statistic::Peak;
use crate::state::{choice, whole};
use crate::time::Timestamp;
use crate::verdict::{Fault, Suspect, Testimony};

/// More cycles than any alarm lasts, or is calm, which are fewer than can be counted.
const MOST_CYCLES: u32 = u32::MAX - 1000;

/// Cause of an alarm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    Mean,
    Variance,
    /// The mean over a minute, without the baseline.
    Slow,
    /// A reading on the stop that differs from the first ones.
    Dwell,
}

choice! { Cause { Mean, Variance, Slow, Dwell } }

/// A standing alarm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alarm {
    pub cause: Cause,
    /// Statistic when the alarm was raised.
    pub peak: Peak,
    /// Length of that statistic's window, cycles.
    pub back: usize,
    pub fault: Fault,
    pub suspect: Suspect,
    /// Evidence for the location, nats: positive for C1, negative for C2; `None` where nothing was
    /// compared.
    pub evidence: Option<f64>,
    /// What has told the suspect.
    pub by: Option<Testimony>,
    /// Size of the fault, m; the root mean square of a noise.
    pub size: f64,
    /// Gain error, if the fault is one, whatever `fault` its first samples looked like.
    pub scale: Option<Scale>,
    /// Onset of the fault, as far as the residuals show it.
    pub onset: Timestamp,
    /// Cycles since the alarm that were judged.
    pub age: u32,
    /// Cycles since the alarm, whether judged or not.
    pub stood: u32,
    /// Cycles without evidence.
    pub calm: u32,
    /// Whether all cylinders were found to be sampled differently when the alarm had just been
    /// raised: it is then no transducer's.
    pub of_timing: bool,
}

whole! {
    Alarm { cause, peak, back, fault, suspect, evidence, by, size, scale, onset, age, stood, calm, of_timing }
    sound |it| it.age < MOST_CYCLES && it.calm < MOST_CYCLES
}

impl Alarm {
    /// A new alarm that suspects nobody.
    pub const fn new(cause: Cause, fault: Fault, size: f64, onset: Timestamp) -> Self {
        Self {
            cause,
            peak: Peak { nats: 0.0, width: 0 },
            back: 0,
            fault,
            suspect: Suspect::Undecided,
            evidence: None,
            by: None,
            size,
            scale: None,
            onset,
            age: 0,
            stood: 0,
            calm: 0,
            of_timing: false,
        }
    }

    /// Takes another cycle of it.
    pub(super) const fn stand(&mut self) {
        self.stood = self.stood.saturating_add(1);
    }

    /// Clears the suspect and the evidence for it.
    pub const fn clear_suspect(&mut self) {
        (self.suspect, self.evidence, self.by) = (Suspect::Undecided, None, None);
    }

    /// Attributes the alarm to a change of the sampling, which blames nobody.
    pub const fn lay_to_timing(&mut self) {
        self.of_timing = true;
        self.clear_suspect();
    }

    /// Number of samples in which the end of the alarm is sought: as many as it took to find it.
    pub fn watched(&self, least: usize) -> usize {
        self.peak.width.max(least)
    }
}

/// Blames whom the evidence is against, where it is enough: the log-likelihood of C1 less that of C2, nats.
pub(super) fn decide(alarm: &mut Alarm, by: Testimony, evidence: Option<f64>, enough: f64) {
    alarm.evidence = evidence;
    alarm.suspect = match evidence {
        Some(nats) if nats > enough => Suspect::C1,
        Some(nats) if nats < -enough => Suspect::C2,
        _ => Suspect::Undecided,
    };
    alarm.by = (alarm.suspect != Suspect::Undecided).then_some(by);
}
