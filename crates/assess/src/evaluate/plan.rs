//! What is to be tried, as jobs that do not depend on each other.

use super::accommodate::{AccommodateJob, AccommodateProduct, AccommodateStudy};
use super::contest::{self, Contest};
use super::estimate::{CASES, Errors};
use super::grade::Grade;
use super::handover::{HandoverJob, HandoverOutcome, HandoverStudy};
use super::healthy::{Healthy, STRETCH};
use super::hexapod::{HexapodJob, HexapodProduct, HexapodStudy};
use super::last::{LastJob, LastProduct, LastStudy};
use super::learning::Lessons;
use super::outcome::Outcome;
use super::process::{ProcessJob, ProcessProduct, ProcessStudy};
use super::row::{Row, Study, rows};
use super::side::{SideJob, SideProduct, SideStudy};
use super::stand::{Stand, StandError};
use super::trial::Try;
use super::weights::{self, TransducerKind, Weighing};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tertius_learn::tune::Weights;

/// Transducers in one sea.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    pub grade: Grade,
    /// Significant wave height, m, and peak period, s.
    pub sea: [f64; 2],
}

/// Extent of the evaluation.
#[derive(Clone, Debug, PartialEq)]
pub struct Extent {
    /// Number of faults in a row, rounded up to whole machines; the rows of [`Study::Loop`] and [`Study::Handover`],
    /// which need a machine or more for each fault, have a quarter.
    pub trials: u32,
    /// Hours of a healthy machine in each cell, rounded up to whole stretches.
    pub hours: f64,
    /// Significant wave height, m, and peak period, s, of each sea. The loop is studied in the
    /// first.
    pub seas: Vec<[f64; 2]>,
    pub studies: Vec<Study>,
    /// Hours of a healthy machine of each grade in each sea for the contest.
    pub contest_hours: f64,
    /// Hours that the detectors of the contest learn from.
    pub lessons: Lessons,
    /// Hours of a healthy machine of each grade in each sea for the weights.
    pub weights_hours: f64,
    /// Sets of weights that are tried.
    pub weights: Vec<Weights>,
    /// Hours of each healthy machine for the process detectors, and for the drifts in the loop.
    pub process_hours: f64,
    pub side_hours: f64,
    /// Hours of each healthy machine with a sensor on its deck.
    pub hexapod_hours: f64,
    /// Hours of each machine on which one transducer of a cylinder is left.
    pub last_hours: f64,
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
}

/// The most faults in a row, so that a row fits into memory.
const MOST_TRIALS: u32 = 100_000;

/// The most hours of healthy machines in a cell.
const MOST_HOURS: f64 = 100_000.0;

/// One simulated machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Job {
    /// The machine of this number in a row.
    Trial { row: usize, number: u32 },
    /// A fault-free stretch of a cell.
    Healthy { cell: usize, number: u32 },
    /// A job of the contest.
    Contest(contest::ContestJob),
    /// A job of the weights.
    Weights(weights::WeightsJob),
    /// A job of the process detectors.
    Process(ProcessJob),
    /// A machine of the hand-over.
    Handover(HandoverJob),
    /// A job of the drifts in the loop.
    Side(SideJob),
    /// A job of the drifts that the deck's attitude names.
    Hexapod(HexapodJob),
    /// A job of the last transducers.
    Last(LastJob),
    /// A machine of the accommodation.
    Accommodate(AccommodateJob),
    /// The machine of this number in a cell and one of [`CASES`].
    Estimate { cell: usize, case: usize, number: u32 },
}

/// Result of a job.
#[derive(Clone, Debug, PartialEq)]
pub enum Product {
    Trial(Vec<Outcome>),
    Healthy(Box<Healthy>),
    Contest(contest::ContestProduct),
    Weights(weights::WeightsProduct),
    Process(ProcessProduct),
    Handover(Vec<HandoverOutcome>),
    Side(SideProduct),
    Hexapod(HexapodProduct),
    Last(LastProduct),
    Accommodate(AccommodateProduct),
    Estimate(Errors),
}

/// Everything that is to be tried.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    pub seed: u64,
    pub extent: Extent,
    pub rows: Vec<Row>,
    pub cells: Vec<Cell>,
    /// Comparison of the detectors, if requested.
    pub contest: Option<Contest>,
    /// Comparison of the observers' weights, if requested.
    pub weighing: Option<Weighing>,
    /// The process detectors, if requested.
    pub process: Option<ProcessStudy>,
    /// The hand-over, if requested.
    pub handover: Option<HandoverStudy>,
    /// The drifts in the loop, if requested.
    pub side: Option<SideStudy>,
    /// The drifts that the deck's attitude names, if requested.
    pub hexapod: Option<HexapodStudy>,
    /// The last transducers, if requested.
    pub last: Option<LastStudy>,
    /// Accommodation, if requested.
    pub accommodate: Option<AccommodateStudy>,
}

/// First stream of healthy machines, above every stream of a row.
const HEALTHY_STREAMS: u64 = 1 << 62;

/// First stream of estimates, above [`HEALTHY_STREAMS`]. All cases of a cell are tried on the same
/// machines at the same times.
const ESTIMATE_STREAMS: u64 = 1 << 63;

/// Time that a sequential detector takes to its baseline, and half of it again, s.
const BASELINE: f64 = 7.5;

/// Numbers of machines that a stream has room for: more than any row or cell has.
const NUMBERS: u64 = 1 << 21;

impl Plan {
    /// The plan for every grade in every sea of `extent`.
    ///
    /// # Errors
    /// The extent exceeds a limit.
    pub fn new(seed: u64, extent: Extent) -> Result<Self, PlanError> {
        if !(1..=MOST_TRIALS).contains(&extent.trials) {
            return Err(PlanError::Trials { given: extent.trials });
        }
        let Extent { hours, contest_hours, weights_hours, .. } = extent;
        let Extent { process_hours, side_hours, hexapod_hours, last_hours, .. } = extent;
        let own = [process_hours, side_hours, hexapod_hours, last_hours];
        for given in [hours, contest_hours, weights_hours].into_iter().chain(own) {
            if !(0.0..=MOST_HOURS).contains(&given) {
                return Err(PlanError::Hours { given });
            }
        }
        let in_seas = |grade| extent.seas.iter().map(move |sea| Cell { grade, sea: *sea });
        let grades = Grade::ALL.into_iter().filter(|it| extent.taught.is_none_or(|own| own == *it));
        let cells: Vec<Cell> = grades.flat_map(in_seas).collect();
        let mut rows = rows(&cells, extent.taught.is_some());
        rows.retain(|row| extent.studies.contains(&row.study));
        let asked = |study: Study| extent.studies.contains(&study);
        let contest = asked(Study::Contest).then(|| Contest::new(seed, &extent));
        let weighing = asked(Study::Weights).then(|| Weighing {
            kinds: TransducerKind::ALL.to_vec(),
            sets: extent.weights.clone(),
            seas: extent.seas.clone(),
            trials: extent.trials,
            hours: extent.weights_hours * extent.seas.len() as f64,
            seed,
            cylinders: extent.cylinders,
        });
        let process = asked(Study::Process).then(|| ProcessStudy::new(seed, &extent));
        let machines = extent.trials.div_ceil(4);
        let handover = asked(Study::Handover)
            .then(|| HandoverStudy::new(seed, extent.seas.clone(), machines, extent.lessons));
        let side = asked(Study::Side).then(|| SideStudy::new(seed, &extent));
        let hexapod = asked(Study::Hexapod).then(|| {
            HexapodStudy::new(seed, extent.seas.clone(), extent.trials, extent.hexapod_hours)
        });
        let last =
            (asked(Study::Last) || asked(Study::Single)).then(|| LastStudy::new(seed, &extent));
        let accommodate = asked(Study::Accommodate).then(|| AccommodateStudy::new(seed, &extent));
        Ok(Self {
            seed,
            extent,
            rows,
            cells,
            contest,
            weighing,
            process,
            handover,
            side,
            hexapod,
            last,
            accommodate,
        })
    }

    /// The number of machines of a row.
    pub fn machines(&self, row: &Row) -> u32 {
        let trials = self.extent.trials;
        if row.is_alone() {
            trials.div_ceil(4)
        } else {
            trials.div_ceil(u32::from(self.extent.cylinders).div_ceil(self.turns()))
        }
    }

    /// Number of machines of a row on which all cylinders together have their faults.
    fn turns(&self) -> u32 {
        if self.extent.taught.is_some() {
            contest::TURNS.min(self.extent.cylinders.into())
        } else {
            1
        }
    }

    /// The number of healthy machines of a cell.
    pub fn stretches(&self) -> u32 {
        (self.extent.hours * 3600.0 / STRETCH).ceil() as u32
    }

    /// All jobs, which may be done in any order.
    pub fn jobs(&self) -> Vec<Job> {
        let trials = self.rows.iter().enumerate().flat_map(|(row, it)| {
            (0..self.machines(it)).map(move |number| Job::Trial { row, number })
        });
        let healthy = (0..self.cells.len()).flat_map(|cell| {
            (0..self.stretches()).map(move |number| Job::Healthy { cell, number })
        });
        let contest = self.contest.iter().flat_map(Contest::jobs).map(Job::Contest);
        let estimates = (0..self.cells.len()).flat_map(|cell| {
            (0..CASES.len()).flat_map(move |case| {
                let numbers = 0..self.extent.estimated();
                numbers.map(move |number| Job::Estimate { cell, case, number })
            })
        });
        let weights = self.weighing.iter().flat_map(Weighing::jobs).map(Job::Weights);
        let process = self.process.iter().flat_map(ProcessStudy::jobs).map(Job::Process);
        let handover = self.handover.iter().flat_map(HandoverStudy::jobs).map(Job::Handover);
        let side = self.side.iter().flat_map(SideStudy::jobs).map(Job::Side);
        let hexapod = self.hexapod.iter().flat_map(HexapodStudy::jobs).map(Job::Hexapod);
        let last = self.last.iter().flat_map(LastStudy::jobs).map(Job::Last);
        let accommodate = self.accommodate.iter().flat_map(AccommodateStudy::jobs);
        contest
            .chain(weights)
            .chain(process)
            .chain(handover)
            .chain(side)
            .chain(hexapod)
            .chain(last)
            .chain(accommodate.map(Job::Accommodate))
            .chain(trials)
            .chain(healthy)
            .chain(estimates)
            .collect()
    }

    /// Does one job on `stand`.
    ///
    /// # Errors
    /// If the stand has no such machine.
    pub fn run(&self, stand: &Stand, job: Job) -> Result<Product, StandError> {
        Ok(match job {
            Job::Trial { row, number } => {
                let row = &self.rows[row];
                let mut rng = self.random(row.stream * NUMBERS + u64::from(number));
                let settle = stand.settings.observer.settle;
                let begin = settle + if self.extent.taught.is_some() { BASELINE } else { 0.0 };
                let mut one = Try::draw(row, number, self.extent.cylinders, begin, &mut rng);
                if !row.is_alone() {
                    let turns = self.turns();
                    one.faults.retain(|fault| u32::from(fault.cylinder) % turns == number % turns);
                }
                Product::Trial(stand.trial(row, &one)?)
            }
            Job::Contest(job) => {
                let contest = self.contest.as_ref().expect("its jobs are of its own plan");
                Product::Contest(contest.run(stand, job)?)
            }
            Job::Weights(job) => {
                let weighing = self.weighing.as_ref().expect("its jobs are of its own plan");
                Product::Weights(weighing.run(stand, job)?)
            }
            Job::Process(job) => {
                let process = self.process.as_ref().expect("its jobs are of its own plan");
                Product::Process(process.run(stand, job)?)
            }
            Job::Handover(job) => {
                let handover = self.handover.as_ref().expect("its jobs are of its own plan");
                Product::Handover(handover.run(stand, job)?)
            }
            Job::Side(job) => {
                let side = self.side.as_ref().expect("its jobs are of its own plan");
                Product::Side(side.run(stand, job)?)
            }
            Job::Hexapod(job) => {
                let hexapod = self.hexapod.as_ref().expect("its jobs are of its own plan");
                Product::Hexapod(hexapod.run(stand, job)?)
            }
            Job::Last(job) => {
                let last = self.last.as_ref().expect("its jobs are of its own plan");
                Product::Last(last.run(stand, job)?)
            }
            Job::Accommodate(job) => {
                let study = self.accommodate.as_ref().expect("its jobs are of its own plan");
                Product::Accommodate(study.run(stand, job)?)
            }
            Job::Healthy { cell, number } => {
                let stream = HEALTHY_STREAMS + cell as u64 * NUMBERS + u64::from(number);
                let seed = self.random(stream).random();
                Product::Healthy(Box::new(stand.healthy(self.cells[cell], seed)?))
            }
            Job::Estimate { cell, case, number } => {
                let stream = ESTIMATE_STREAMS + cell as u64 * NUMBERS + u64::from(number);
                let mut rng = self.random(stream);
                Product::Estimate(stand.estimate(self.cells[cell], &CASES[case], &mut rng)?)
            }
        })
    }

    fn random(&self, stream: u64) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(stream);
        rng
    }
}
