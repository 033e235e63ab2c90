//! The extent of an evaluation.

use super::grade::{Cell, Grade};
use tertius_learn::tune::Weights;

/// A name by which a study, or a part of it, is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StudyName {
    pub name: &'static str,
    /// What it is about, for the help of a command.
    pub about: &'static str,
    /// Whether it takes seconds with few faults; studies that learn first, or simulate long, do not.
    pub is_quick: bool,
}

impl StudyName {
    pub(super) const fn quick(name: &'static str, about: &'static str) -> Self {
        Self { name, about, is_quick: true }
    }

    pub(super) const fn slow(name: &'static str, about: &'static str) -> Self {
        Self { name, about, is_quick: false }
    }
}

/// Hours in each sea to learn from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lessons {
    /// Hours for the calibration, half of them to fit and half to validate.
    pub calibration: f64,
    /// Hours for the level.
    pub level: f64,
}

/// Extent of the evaluation.
#[derive(Clone, Debug, PartialEq)]
pub struct Extent {
    /// Number of faults in a row, rounded up to whole machines; the rows of the loop and of the hand-over, which need a
    /// machine or more for each fault, have a quarter.
    pub trials: u32,
    /// Hours of a healthy machine, for each study that has any, of each grade in each sea, rounded up to whole stretches.
    pub hours: f64,
    /// Significant wave height, m, and peak period, s, of each sea. The loop is studied in the
    /// first.
    pub seas: Vec<[f64; 2]>,
    /// Names of the studies that are asked for.
    pub studies: Vec<&'static str>,
    /// Hours that the detectors of the contest and of the hand-over learn from.
    pub lessons: Lessons,
    /// Sets of weights that are tried.
    pub weights: Vec<Weights>,
    /// Number of cylinders that are monitored; every one of a machine has its fault.
    pub cylinders: u8,
    /// Transducers that the monitor's sequential detectors were taught; `None` where it has none. They judge once they have a baseline,
    /// and take what half of the cylinders show at once for something shared, so that fewer have a fault, and later.
    pub taught: Option<Grade>,
    /// Time constant of the spools of the plant, s, for the studies that try another one, too.
    pub lag: f64,
}

/// Why there is no plan.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    #[error("{given} faults a row, expected 1 to {MOST_TRIALS}")]
    Trials { given: u32 },
    #[error("{given} hours without a fault, expected 0 to {MOST_HOURS}")]
    Hours { given: f64 },
    #[error("there is no study {name:?}")]
    Study { name: &'static str },
}

/// The most faults in a row, so that a row fits into memory.
const MOST_TRIALS: u32 = 100_000;

/// The most hours of healthy machines in a cell.
const MOST_HOURS: f64 = 100_000.0;

impl Extent {
    /// Whether `study` is asked for.
    pub fn asks(&self, study: StudyName) -> bool {
        self.studies.contains(&study.name)
    }

    /// Every grade in every sea; only the grade that was taught, where one was.
    pub fn cells(&self) -> Vec<Cell> {
        let in_seas = |grade| self.seas.iter().map(move |sea| Cell { grade, sea: *sea });
        let grades = Grade::ALL.into_iter().filter(|it| self.taught.is_none_or(|own| own == *it));
        grades.flat_map(in_seas).collect()
    }

    /// Refuses what exceeds a limit, and studies that are not `known`.
    pub(super) fn check(&self, known: &[StudyName]) -> Result<(), PlanError> {
        if !(1..=MOST_TRIALS).contains(&self.trials) {
            return Err(PlanError::Trials { given: self.trials });
        }
        if !(0.0..=MOST_HOURS).contains(&self.hours) {
            return Err(PlanError::Hours { given: self.hours });
        }
        let unknown = self.studies.iter().find(|name| known.iter().all(|it| it.name != **name));
        unknown.map_or(Ok(()), |name| Err(PlanError::Study { name }))
    }
}
