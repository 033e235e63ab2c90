//! What a sequential detector has found.

use super::scale::Scale;
use super::statistic::Peak;
use crate::time::Timestamp;
use crate::verdict::{Fault, Suspect};

/// Why there is an alarm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    Mean,
    Variance,
    /// The mean of a minute, without the baseline.
    Slow,
    /// A reading on the stop that has moved since the first ones.
    Dwell,
}

/// An alarm that stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alarm {
    pub cause: Cause,
    /// The statistic as it rose.
    pub peak: Peak,
    /// Cycles that the window of it went back.
    pub back: usize,
    pub fault: Fault,
    pub suspect: Suspect,
    /// For C1 if positive, for C2 if negative, nats; `None` where nothing was compared.
    pub evidence: Option<f64>,
    /// m; of noise its root mean square.
    pub size: f64,
    /// It is a gain that is off, whatever `fault` took its first samples for.
    pub scale: Option<Scale>,
    /// When it began, as far as the residuals show it.
    pub onset: Timestamp,
    /// Cycles since the alarm.
    pub age: u32,
    /// Cycles without evidence.
    pub calm: u32,
    /// When it had just risen, all cylinders were found to be sampled otherwise: it is of no transducer.
    pub of_timing: bool,
}

impl Alarm {
    /// An alarm that has just risen, and of which nobody is suspected.
    pub const fn new(cause: Cause, fault: Fault, size: f64, onset: Timestamp) -> Self {
        Self {
            cause,
            peak: Peak { nats: 0.0, width: 0 },
            back: 0,
            fault,
            suspect: Suspect::Undecided,
            evidence: None,
            size,
            scale: None,
            onset,
            age: 0,
            calm: 0,
            of_timing: false,
        }
    }

    /// Nobody is suspected any more, and what spoke for it is void.
    pub const fn clear_suspect(&mut self) {
        (self.suspect, self.evidence) = (Suspect::Undecided, None);
    }

    /// It began with a change of the sampling, and blames nobody.
    pub const fn lay_to_timing(&mut self) {
        self.of_timing = true;
        self.clear_suspect();
    }

    /// How far back one looks whether it is over, in samples: as far as it took to find it, and `least`.
    pub fn watched(&self, least: usize) -> usize {
        self.peak.width.max(least)
    }
}
