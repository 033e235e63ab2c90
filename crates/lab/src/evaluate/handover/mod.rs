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
pub use figures::{HandoverFigures, HandoverResult, IN_TIME, PolicyFigures, WrongFigures};
pub use trial::{HandoverOutcome, LEAD, SENSORS, Way};

use super::extent::{Extent, Lessons, StudyName};
use super::grade::Grade;
use super::random::random;
use super::stand::{Stand, StandError};
use super::study::Study;
use rand::RngExt;
use std::collections::BTreeMap;
use tertius_core::monitor::MonitorDesign;

/// First stream of random numbers, apart from those of all other jobs.
const STREAMS: u64 = 9 << 40;
const NUMBERS: u64 = 1 << 20;

/// The most hours in each sea that are learnt from.
const MOST: Lessons = Lessons { calibration: 0.25, level: 0.25 };

/// The study of the hand-over.
const HANDOVER: StudyName = StudyName::slow(
    "handover",
    "A machine whose controller hears who is blamed: code blacks with and without",
);

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
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct HandoverJob {
    /// Index of the study's grade.
    pub grade: usize,
    pub number: u32,
}

impl Study for HandoverStudy {
    const NAMES: &'static [StudyName] = &[HANDOVER];
    type Job = HandoverJob;
    /// The monitor of a grade, which sends estimates: the controller reads its frames.
    type Taught = MonitorDesign;
    type Product = (HandoverJob, Vec<HandoverOutcome>);
    type Gathered = BTreeMap<HandoverJob, Vec<HandoverOutcome>>;
    type Figures = HandoverResult;

    /// The study of every grade; no more than a few hours are learnt from.
    fn planned(seed: u64, extent: &Extent) -> Option<Self> {
        extent.asks(HANDOVER).then(|| Self {
            grades: Grade::ALL.to_vec(),
            seas: extent.seas.clone(),
            trials: extent.trials.div_ceil(4),
            cases: CASES.to_vec(),
            lessons: Lessons {
                calibration: extent.lessons.calibration.min(MOST.calibration),
                level: extent.lessons.level.min(MOST.level),
            },
            seed,
        })
    }

    fn lessons(&self) -> usize {
        self.grades.len()
    }

    fn teach(&self, stand: &Stand, lesson: usize) -> Result<MonitorDesign, StandError> {
        let mut settings = stand.settings.clone();
        settings.estimate.send = true;
        let mut stand = stand.clone();
        stand.settings = &settings;
        let seeds = [0, 1].map(|which| random(self.seed, STREAMS + which).random());
        Ok(stand.learn(self.grades[lesson], &self.seas, seeds, self.lessons)?.design)
    }

    fn jobs(&self) -> Vec<HandoverJob> {
        let numbered = |grade| (0..self.trials).map(move |number| HandoverJob { grade, number });
        (0..self.grades.len()).flat_map(numbered).collect()
    }

    fn run(
        &self,
        stand: &Stand,
        taught: &[MonitorDesign],
        job: HandoverJob,
    ) -> Result<Self::Product, StandError> {
        let HandoverJob { grade, number } = job;
        // Both grades have the same machines, and the same faults at the same times.
        let mut rng = random(self.seed, STREAMS + NUMBERS + u64::from(number));
        let sea = self.seas[number as usize % self.seas.len()];
        let leg = number / self.seas.len() as u32;
        let of = (self.grades[grade], &taught[grade]);
        Ok((job, stand.handed_over(of, sea, leg, &self.cases, &mut rng)?))
    }

    fn gather(&self, _: &Stand, gathered: &mut Self::Gathered, (job, outcomes): Self::Product) {
        gathered.insert(job, outcomes);
    }

    fn figures(&self, _: &Stand, _: &[MonitorDesign], gathered: Self::Gathered) -> HandoverResult {
        let mut result = HandoverResult::default();
        for (index, grade) in self.grades.iter().enumerate() {
            let own = gathered.iter().filter(|(job, _)| job.grade == index);
            let outcomes: Vec<_> = own.flat_map(|(_, outcomes)| outcomes).copied().collect();
            result.add(*grade, &self.cases, &outcomes);
        }
        result
    }
}
