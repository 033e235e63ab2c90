//! Faults of the transducers: kinds and sizes, each on every grade of transducers in every sea.

mod claim;
mod figures;
mod row;
mod trial;

pub use claim::{Claim, Judged};
pub use figures::{Figures, IncidentFigures, Moved, RowResult};
pub use row::{Row, RowGroup, rows};

use super::extent::{Extent, StudyName};
use super::outcome::Outcome;
use super::random::random;
use super::stand::{Stand, StandError};
use super::study::Study;
use super::tried::{TURNS, Try};
use std::collections::BTreeMap;

/// Time that a sequential detector takes to its baseline, and half of it again, s.
const BASELINE: f64 = 7.5;

/// Numbers of machines that a stream has room for: more than any row has.
const NUMBERS: u64 = 1 << 21;

/// What is tried.
#[derive(Clone, Debug, PartialEq)]
pub struct RowStudy {
    pub rows: Vec<Row>,
    /// Number of faults in a row, rounded up to whole machines; a row of the loop has a quarter.
    pub trials: u32,
    pub seed: u64,
    /// Number of cylinders that are monitored.
    pub cylinders: u8,
    /// Whether the monitor's sequential detectors were taught: see [`Extent::taught`].
    pub taught: bool,
}

/// The machine of this number in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowJob {
    pub row: usize,
    pub number: u32,
}

/// What became of the faults of a machine.
#[derive(Clone, Debug, PartialEq)]
pub struct RowProduct {
    pub job: RowJob,
    pub outcomes: Vec<Outcome>,
}

/// A row that is being tried; it becomes figures as soon as it is complete, because the outcomes of all rows at once may
/// not fit into memory.
#[derive(Clone, Debug, Default)]
pub struct RowProgress {
    /// Outcomes by the machine's number.
    machines: BTreeMap<u32, Vec<Outcome>>,
    result: Option<RowResult>,
}

impl RowStudy {
    /// The number of machines of a row.
    pub fn machines(&self, row: &Row) -> u32 {
        if row.is_alone() {
            self.trials.div_ceil(4)
        } else {
            self.trials.div_ceil(u32::from(self.cylinders).div_ceil(self.turns()))
        }
    }

    /// Number of machines of a row on which all cylinders together have their faults.
    fn turns(&self) -> u32 {
        if self.taught { TURNS.min(self.cylinders.into()) } else { 1 }
    }
}

impl Study for RowStudy {
    const NAMES: &'static [StudyName] = &RowGroup::STUDIES;
    type Job = RowJob;
    type Taught = ();
    type Product = RowProduct;
    type Gathered = BTreeMap<usize, RowProgress>;
    type Figures = Vec<RowResult>;

    /// The rows of the groups that are asked for; a list without rows stands in the result, too.
    fn planned(seed: u64, extent: &Extent) -> Option<Self> {
        let taught = extent.taught.is_some();
        let mut rows = rows(&extent.cells(), taught);
        rows.retain(|row| extent.asks(row.group.study()));
        Some(Self { rows, trials: extent.trials, seed, cylinders: extent.cylinders, taught })
    }

    fn teach(&self, _: &Stand, _: usize) -> Result<(), StandError> {
        Ok(())
    }

    fn jobs(&self) -> Vec<RowJob> {
        let of_row = |(row, it): (usize, &Row)| {
            (0..self.machines(it)).map(move |number| RowJob { row, number })
        };
        self.rows.iter().enumerate().flat_map(of_row).collect()
    }

    fn run(&self, stand: &Stand, _: &[()], job: RowJob) -> Result<RowProduct, StandError> {
        let RowJob { row, number } = job;
        let row = &self.rows[row];
        let mut rng = random(self.seed, row.stream * NUMBERS + u64::from(number));
        let begin = stand.settings.observer.settle + if self.taught { BASELINE } else { 0.0 };
        let alone = row.is_alone().then_some(number);
        let mut one = Try::draw(row.wanted, alone, self.cylinders, begin, &mut rng);
        if !row.is_alone() {
            let turns = self.turns();
            one.faults.retain(|fault| u32::from(fault.cylinder) % turns == number % turns);
        }
        Ok(RowProduct { job, outcomes: stand.trial(row, &one)? })
    }

    fn gather(&self, stand: &Stand, gathered: &mut Self::Gathered, product: RowProduct) {
        let RowProduct { job: RowJob { row: index, number }, outcomes } = product;
        let (row, progress) = (&self.rows[index], gathered.entry(index).or_default());
        progress.machines.insert(number, outcomes);
        if progress.machines.len() == self.machines(row) as usize {
            let all = std::mem::take(&mut progress.machines);
            let outcomes: Vec<Outcome> = all.into_values().flatten().collect();
            let sample_time = stand.settings.machine.sample_time;
            progress.result = Some(RowResult::new(row, &outcomes, sample_time));
        }
    }

    fn figures(&self, _: &Stand, _: &[()], gathered: Self::Gathered) -> Vec<RowResult> {
        gathered.into_values().filter_map(|progress| progress.result).collect()
    }
}
