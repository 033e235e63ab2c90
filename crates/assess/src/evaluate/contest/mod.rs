//! The detectors against each other: the thesis's thresholds and the sequential detector, on the same
//! faults, in the controller's loop, and in the same hours without one.
//!
//! The sequential detector has been calibrated to the machine, and its level found, on runs of their
//! own ([`Learnt`]); so every fault and every hour is new to it. Faults begin when the
//! windows of its statistics are full. The transducers do not fluctuate as in Figure 5-9: a calibration
//! on fluctuations takes them for healthy, and then asks for a level that hides what is as large.

mod figures;
mod hours;
mod ladder;
mod lorden;
mod quiet;
mod row;
mod stop;
mod trial;

pub use figures::{Point, RowFigures};
pub use hours::Hours;
pub use ladder::{LEVELS, Ladder, Rival};
pub use quiet::Quiet;
pub use row::{Course, rows};
pub use trial::Entry;

use super::grade::Grade;
use super::learning::Learnt;
use super::row::Row;
use super::stand::{Stand, StandError};
use super::trial::Try;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use std::collections::BTreeMap;
use tertius_machine::plant::CYLINDERS;

/// From when the observers have settled until the faults begin: longer than the widest window, s.
const LEAD: f64 = 37.0;

/// Cylinders of a machine that have their fault at once. What half of them show is no transducer's to the
/// detectors, but something that all of them share.
const AT_ONCE: u32 = 2;

/// Streams of random numbers of their own, apart from all other jobs.
const STREAMS: u64 = 3 << 40;
const NUMBERS: u64 = 1 << 20;

/// What is tried.
#[derive(Clone, Debug, PartialEq)]
pub struct Contest {
    pub grades: Vec<Grade>,
    pub rows: Vec<(Row, Course)>,
    pub seas: Vec<[f64; 2]>,
    /// Faults in a row.
    pub trials: u32,
    /// Hours of a healthy machine of each grade, in whole stretches, the seas in turn.
    pub hours: f64,
    pub seed: u64,
}

/// One simulated machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Job {
    /// The machine of that number of a row.
    Faulty { row: usize, number: u32 },
    /// A stretch without faults.
    Quiet { grade: Grade, number: u32 },
}

/// What a job brings.
#[derive(Clone, Debug, PartialEq)]
pub enum Product {
    Faulty(Vec<Entry>),
    Quiet(Box<Quiet>),
}

impl Contest {
    /// Of every grade in `seas`.
    pub fn new(seed: u64, seas: &[[f64; 2]], trials: u32, hours: f64) -> Self {
        let grades = Grade::ALL.to_vec();
        let rows = grades.iter().flat_map(|grade| rows(*grade, seas)).collect();
        Self { grades, rows, seas: seas.to_vec(), trials, hours, seed }
    }

    /// The machines of a row.
    pub const fn machines(&self) -> u32 {
        self.trials.div_ceil(AT_ONCE)
    }

    /// All jobs, the longest first.
    pub fn jobs(&self) -> Vec<Job> {
        let stretches = (self.hours * 3600.0 / quiet::STRETCH).ceil() as u32;
        let quiet = self
            .grades
            .iter()
            .flat_map(|grade| (0..stretches).map(|number| Job::Quiet { grade: *grade, number }));
        let faulty = (0..self.rows.len())
            .flat_map(|row| (0..self.machines()).map(move |number| Job::Faulty { row, number }));
        quiet.chain(faulty).collect()
    }

    /// Does one job on `stand`, which has learnt the job's grade.
    ///
    /// # Errors
    /// If the stand has no such machine.
    pub fn run(&self, stand: &Stand, job: Job) -> Result<Product, StandError> {
        let sea = |number: u32| self.seas[number as usize % self.seas.len()];
        Ok(match job {
            Job::Faulty { row: index, number } => {
                let (row, course) = &self.rows[index];
                let learnt = stand.learnt(row.cell.grade)?;
                let mut rng = self.random(1 + index as u64, number);
                let one = |begin: f64, rng: &mut ChaCha8Rng| few(row, number, begin, rng);
                let settle = stand.settings.observer.settle;
                Product::Faulty(match course {
                    Course::Engaged => {
                        let one = one(settle + LEAD, &mut rng);
                        stand.contest(learnt, &one, sea(number), row.watch)?
                    }
                    Course::Stop => {
                        let one = one(stop::BEGIN, &mut rng);
                        stand.stop(learnt, &one, sea(number))?
                    }
                })
            }
            Job::Quiet { grade, number } => {
                // Not of the grades: both have the same seas and machines.
                let seed = self.random(0, number).random();
                Product::Quiet(Box::new(stand.quiet(stand.learnt(grade)?, sea(number), seed)?))
            }
        })
    }

    fn random(&self, stream: u64, number: u32) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(STREAMS + stream * NUMBERS + u64::from(number));
        rng
    }

    /// Seeds of the runs that `grade` is learnt from: of the calibration, and of the level.
    pub fn lessons(&self) -> [u64; 2] {
        [0, 1].map(|which| self.random(NUMBERS - 1, which).random())
    }
}

/// Draws a trial of which only a few cylinders have their fault.
fn few(row: &Row, number: u32, begin: f64, rng: &mut ChaCha8Rng) -> Try {
    let mut one = Try::draw(row, number, begin, rng);
    let turns = CYLINDERS as u32 / AT_ONCE;
    // Each of them in each sea.
    let turn = number / turns % turns;
    one.faults.retain(|fault| u32::from(fault.cylinder) % turns == turn);
    one
}

/// What it came to on one grade.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GradeResult {
    #[serde(skip)]
    pub of: Grade,
    pub grade: &'static str,
    /// h, nats.
    pub level: f64,
    /// What it was made from: the largest evidence, nats, and the time of cylinders, h; `None` where
    /// it is configured.
    pub level_from: Option<[f64; 2]>,
    pub hours: Hours,
    pub rows: Vec<RowFigures>,
}

/// Puts together what the jobs bring, in whatever order.
#[derive(Clone, Debug)]
pub struct Gathering<'a> {
    contest: &'a Contest,
    entries: Vec<BTreeMap<u32, Vec<Entry>>>,
    hours: BTreeMap<Grade, hours::Adding>,
}

impl<'a> Gathering<'a> {
    pub fn new(contest: &'a Contest) -> Self {
        let entries = vec![BTreeMap::new(); contest.rows.len()];
        Self { contest, entries, hours: BTreeMap::new() }
    }

    /// Takes what a job brought; each job once.
    pub fn take(&mut self, job: Job, product: Product) {
        match (job, product) {
            (Job::Faulty { row, number }, Product::Faulty(entries)) => {
                self.entries[row].insert(number, entries);
            }
            (Job::Quiet { grade, .. }, Product::Quiet(quiet)) => {
                self.hours.entry(grade).or_default().add(&quiet);
            }
            // A job brings what it is.
            (Job::Faulty { .. } | Job::Quiet { .. }, _) => {}
        }
    }

    /// The result for every grade that was learnt; `sample_time` in s.
    pub fn finish(mut self, learnt: &[Learnt], sample_time: f64) -> Vec<GradeResult> {
        let entries: Vec<Vec<Entry>> = self
            .entries
            .iter_mut()
            .map(|it| std::mem::take(it).into_values().flatten().collect())
            .collect();
        let result = |learnt: &Learnt| {
            let hours = self.hours.remove(&learnt.grade).unwrap_or_default();
            let hours = hours.finish(learnt.nats, sample_time);
            let own = self.contest.rows.iter().zip(&entries);
            let own = own.filter(|((row, _), entries)| {
                row.cell.grade == learnt.grade && !entries.is_empty()
            });
            GradeResult {
                of: learnt.grade,
                grade: learnt.grade.name(),
                level: learnt.nats,
                level_from: learnt.level.map(|level| [level.worst, level.hours]),
                rows: own
                    .map(|((row, course), entries)| {
                        RowFigures::of(row, *course, entries, &hours, sample_time)
                    })
                    .collect(),
                hours,
            }
        };
        learnt.iter().map(result).collect()
    }
}
