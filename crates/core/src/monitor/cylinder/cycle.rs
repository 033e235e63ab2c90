//! A cycle of one cylinder, which goes through the monitor: each stage adds what it has found.

use crate::frame::Buses;
use crate::monitor::gate::Opening;
use crate::observe::observer::{Innovation, Measurement};
use crate::sample::Reading;
use crate::time::Timestamp;
use crate::verdict::Residuals;

/// When a cylinder is evaluated, and in which state of the machine.
#[derive(Clone, Copy, Debug)]
pub struct Evaluation {
    /// Time of the evaluation: the last frame of the cycle, or its deadline.
    pub at: Timestamp,
    pub cycle: u64,
    pub opened: Timestamp,
    /// Buses that were heard, see [`crate::sample::plausibility::Moment::live`].
    pub heard: Buses,
    pub gate: Opening,
    /// Whether the rods stand on their mechanical stops.
    pub at_stop: bool,
}

/// A cycle of one cylinder.
#[derive(Clone, Copy, Debug)]
pub struct Cycle {
    pub now: Evaluation,
    /// The command, less that at which the cylinder rests, m/s.
    pub command: Option<f64>,
    /// As they came.
    pub readings: [Option<Reading>; 2],
    /// Those that passed the plausibility checks.
    pub good: [Option<Measurement>; 2],
    /// Whether a reading is not good, or a warning of its plausibility stands.
    pub is_odd: bool,
    /// Of the observers; those of a wild reading are replaced.
    pub innovations: [Option<Innovation>; 2],
    /// C1 less the corrected C2, m.
    pub difference: Option<f64>,
    /// R1, R2 and R3 where they are judged, m.
    pub residuals: Residuals,
}

impl Cycle {
    /// A cycle of which nothing is known but when it is evaluated.
    #[inline(always)]
    pub const fn new(now: Evaluation) -> Self {
        Self {
            now,
            command: None,
            readings: [None; 2],
            good: [None; 2],
            is_odd: false,
            innovations: [None; 2],
            difference: None,
            residuals: Residuals { r: [None; 3] },
        }
    }

    /// C1, m, if it is good.
    pub fn length(&self) -> Option<f64> {
        self.good[0].map(|reading| reading.position)
    }

    /// Positions of C1 and C2 that are good, m.
    pub fn lengths(&self) -> [Option<f64>; 2] {
        self.good.map(|reading| reading.map(|it| it.position))
    }

    pub fn is_monitored(&self) -> bool {
        self.now.gate == Opening::Open
    }
}
