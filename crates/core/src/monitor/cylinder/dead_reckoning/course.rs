//! What transducers are off by against dead reckoning.

use super::parameters::LONGEST_WINDOW_TICKS;
use crate::state::{state, whole};

/// The readings of one transducer less dead reckoning.
#[derive(Clone, Debug)]
pub struct ReckonedCourse {
    /// The reading less the way and the error, m, where the present stretch began, in which the way is known.
    pub origin: Option<f64>,
    /// Error of dead reckoning so far, m.
    pub error: f64,
    /// The same at the newest ticks, a ring.
    pub errors: [f64; LONGEST_WINDOW_TICKS],
    /// Windows, one bit each, in which the error was beyond its limit at the newest tick: to either side.
    pub beyond: [u8; 2],
}

state! { ReckonedCourse { origin, error, errors, beyond } }

impl ReckonedCourse {
    pub const NONE: Self =
        Self { origin: None, error: 0.0, errors: [0.0; LONGEST_WINDOW_TICKS], beyond: [0; 2] };

    /// Takes the reading of a tick after this `way`, m; the first one of a stretch adds no error. Returns whether it goes on.
    pub fn follow(&mut self, reading: Option<f64>, way: f64) -> bool {
        let Some(apart) = reading.map(|reading| reading - way) else { return false };
        let goes_on = self.origin.is_some();
        self.error = apart - *self.origin.get_or_insert(apart - self.error);
        goes_on
    }
}

/// What a reading has departed by from dead reckoning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CourseError {
    /// m, signed.
    pub error: f64,
    /// What it was compared with, m.
    pub limit: f64,
    /// Window in which it has come about, s.
    pub seconds: f64,
}

/// What readings are off by since a moment ago.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CourseJump {
    /// m, signed.
    pub error: f64,
    /// What it is compared with, m.
    pub limit: f64,
}

whole! { CourseJump { error, limit } }

/// What is compared with dead reckoning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compared {
    /// The only transducer that is left.
    Alone(usize),
    /// Both, which agree.
    Together,
    /// Neither: they differ, or one has no reading.
    Neither,
}

/// What two errors have in common, m: the lesser of the two, if both have the same sign.
pub fn common([one, other]: [f64; 2]) -> f64 {
    match one * other > 0.0 {
        true if one.abs() < other.abs() => one,
        true => other,
        false => 0.0,
    }
}
