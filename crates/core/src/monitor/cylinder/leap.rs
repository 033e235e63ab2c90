//! A leap of C1 − C2 from one cycle to the next, further than the machine's own limit of the difference.

use crate::alarm::{Finding, Level};
use crate::verdict::{Fault, Suspect};

/// The detector of leaps of one cylinder, an example of a detector.
#[derive(Clone, Copy, Debug)]
pub struct Leap {
    /// Longest leap that is none, m.
    limit: f64,
    /// Newest C1 − C2, m.
    newest: Option<f64>,
    /// The leap to it, m, if there was one.
    leap: Option<f64>,
}

impl Leap {
    /// A detector of leaps beyond `limit`, m.
    pub const fn new(limit: f64) -> Self {
        Self { limit, newest: None, leap: None }
    }

    /// Takes C1 − C2 of a cycle, m; `None` where one of them was not good.
    pub fn step(&mut self, difference: Option<f64>) {
        let leap = difference.zip(self.newest).map(|(now, before)| now - before);
        self.leap = leap.filter(|leap| leap.abs() > self.limit);
        self.newest = difference.or(self.newest);
    }

    pub const fn is_found(&self) -> bool {
        self.leap.is_some()
    }

    /// The leap of the newest cycle as a finding of this level.
    pub fn finding(&self, level: Level) -> Option<Finding> {
        Some(Finding {
            fault: Fault::Abrupt,
            suspect: Suspect::Undecided,
            level,
            residual: Some(self.leap?),
            threshold: Some(self.limit),
            evidence: None,
        })
    }
}
