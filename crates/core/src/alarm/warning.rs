//! A warning as it leaves the monitor.

use super::level::Level;
use crate::time::Timestamp;
use crate::verdict::{Fault, Suspect};

/// Who warns. The numbers are those of Fd_Warning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Detector {
    /// The observer on C1.
    Fde1 = 1,
    /// The observer on C2.
    Fde2 = 2,
    /// The comparator of C1 and the corrected C2.
    Fde3 = 3,
    /// The checks before any model.
    Plausibility = 4,
    Sequential = 5,
    Hexapod = 6,
}

impl Detector {
    pub const ALL: [Self; 6] =
        [Self::Fde1, Self::Fde2, Self::Fde3, Self::Plausibility, Self::Sequential, Self::Hexapod];

    /// The name in files and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fde1 => "fde1",
            Self::Fde2 => "fde2",
            Self::Fde3 => "fde3",
            Self::Plausibility => "plausibility",
            Self::Sequential => "sequential",
            Self::Hexapod => "hexapod",
        }
    }
}

/// What happened to a warning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    Raised,
    /// Its fault, suspect or level is another one now.
    Changed,
    Cleared,
}

impl State {
    pub const fn name(self) -> &'static str {
        match self {
            Self::Raised => "raised",
            Self::Changed => "changed",
            Self::Cleared => "cleared",
        }
    }
}

/// What a detector has found, as long as it finds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finding {
    pub fault: Fault,
    pub suspect: Suspect,
    pub level: Level,
    /// m, signed; `None` where the detector has no residual (a reading that is not there).
    pub residual: Option<f64>,
    /// m; `None` like the residual.
    pub threshold: Option<f64>,
    /// What a detector that weighs evidence has; `None` of the others.
    pub evidence: Option<Evidence>,
}

/// How sure a finding is, and since when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// That something is faulty, nats: it was by exp(this) too much for a healthy cylinder.
    pub fault: f64,
    /// For C1 if positive, for C2 if negative, nats; `None` where they were not compared.
    pub location: Option<f64>,
    /// When the fault began, as far as it shows.
    pub onset: Timestamp,
    /// Where the fault is a gain that is off: by how much more C1 grows with the length than C2 does,
    /// m per m. Fd_Warning has no code for it, and the fault is unclassified.
    pub gain: Option<f64>,
}

impl Finding {
    /// The [`Evidence::gain`] of a fault that is one.
    pub fn gain(&self) -> Option<f64> {
        self.evidence?.gain
    }

    /// Whether `other` says the same to a person; the residual moves all the time.
    pub fn says_as(&self, other: &Self) -> bool {
        (self.fault, self.suspect, self.level, self.gain().is_some())
            == (other.fault, other.suspect, other.level, other.gain().is_some())
    }
}

/// A warning that is raised, changed or cleared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Warning {
    pub timestamp: Timestamp,
    /// From 1.
    pub cylinder: u8,
    pub detector: Detector,
    /// Which of the cylinder's warnings it is, see [`super::register::DETECTORS`].
    pub place: usize,
    pub state: State,
    pub finding: Finding,
}
