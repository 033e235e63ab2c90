//! What a warning is worth: a machine whose controller reads the gateway's frames, beside the same machine whose
//! controller does not.
//!
//! ```text
//! machine ─ frames ─→ monitor ─ Fd_Warning, Fd_Estimate ─→ reader ─→ policy ─┐
//!    ↑                                   which measurement, which cylinder   │
//!    └────────────── out of the 5 cm rule ───────────────────────────────────┘
//! ```
//!
//! The machine supervises itself: where C1 and C2 differ by more than 5 cm it goes black, into the safe state within 5 s.
//! The monitor is taught by healthy runs of the same kind of machine, as in the [`contest`](super::contest). Machines
//! of all policies are the same until a transducer is blamed.

mod cases;
mod figures;
mod installation;
mod reader;
#[cfg(test)]
mod tests;
mod trial;

pub use cases::{CASES, HandoverCase, Policy};
pub use figures::{
    HandoverFigures, HandoverGathering, HandoverResult, IN_TIME, PolicyFigures, WrongFigures,
};
pub use trial::{HandoverOutcome, SENSORS, Way};

use super::grade::Grade;
use super::learning::Lessons;
use super::stand::{Stand, StandError};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tertius_core::monitor::MonitorDesign;

/// Time for which a machine is healthy before its faults, s.
pub const LEAD: f64 = 330.0;

/// Time within which the faults begin, s.
const SPREAD: f64 = 8.0;

/// First stream of random numbers, apart from those of all other jobs.
const STREAMS: u64 = 9 << 40;
const NUMBERS: u64 = 1 << 20;

/// The most hours in each sea that are learnt from.
const MOST: Lessons = Lessons { calibration: 0.25, level: 0.25 };

/// What is tried.
#[derive(Clone, Debug, PartialEq)]
pub struct HandoverStudy {
    pub grades: Vec<Grade>,
    /// Significant wave height, m, and peak period, s; the seas take turns.
    pub seas: Vec<[f64; 2]>,
    /// Number of machines of each grade; each has every fault.
    pub trials: u32,
    pub cases: Vec<HandoverCase>,
    pub lessons: Lessons,
    pub seed: u64,
}

/// A machine of a grade.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HandoverJob {
    pub grade: Grade,
    pub number: u32,
}

impl HandoverStudy {
    /// The study of every grade; no more than `lessons` is learnt from.
    pub fn new(seed: u64, seas: Vec<[f64; 2]>, trials: u32, lessons: Lessons) -> Self {
        let lessons = Lessons {
            calibration: lessons.calibration.min(MOST.calibration),
            level: lessons.level.min(MOST.level),
        };
        let (grades, cases) = (Grade::ALL.to_vec(), CASES.to_vec());
        Self { grades, seas, trials, cases, lessons, seed }
    }

    /// All jobs.
    pub fn jobs(&self) -> Vec<HandoverJob> {
        let numbered = |grade: &Grade| {
            let grade = *grade;
            (0..self.trials).map(move |number| HandoverJob { grade, number })
        };
        self.grades.iter().flat_map(numbered).collect()
    }

    /// The monitor of `grade`, which sends estimates.
    ///
    /// # Errors
    /// There is no such machine, or it teaches nothing.
    pub fn design(&self, stand: &Stand, grade: Grade) -> Result<MonitorDesign, StandError> {
        let mut settings = stand.settings.clone();
        settings.estimate.send = true;
        let mut stand = stand.clone();
        stand.settings = &settings;
        let seeds = [0, 1].map(|which| self.random(STREAMS + which).random());
        Ok(stand.learn(grade, &self.seas, seeds, self.lessons)?.design)
    }

    /// Does one job on `stand`.
    ///
    /// # Errors
    /// There is no such machine, or no place for such a fault on it.
    pub fn run(&self, stand: &Stand, job: HandoverJob) -> Result<Vec<HandoverOutcome>, StandError> {
        let HandoverJob { grade, number } = job;
        // Both grades have the same machines, and the same faults at the same times.
        let mut rng = self.random(STREAMS + NUMBERS + u64::from(number));
        let sea = self.seas[number as usize % self.seas.len()];
        let leg = number / self.seas.len() as u32;
        stand.handed_over(grade, sea, leg, &self.cases, &mut rng)
    }

    fn random(&self, stream: u64) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(stream);
        rng
    }
}
