//! Comparison of the thesis's thresholds with the sequential detector on the same faults, in the
//! controller's loop, and on the same fault-free hours.
//!
//! The sequential detector is calibrated to the machine, and its level found, on separate runs
//! ([`Learnt`]), so every fault and every hour is new to it. Faults begin when the windows of its
//! statistics are full. The transducers do not fluctuate as in Figure 5-9: a calibration on
//! fluctuations takes them for healthy, and then needs a level that hides faults of that size.

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
pub use quiet::QuietHours;
pub use row::{Course, rows};
pub use trial::Entry;

use super::grade::Grade;
use super::learning::Learnt;
use super::plan::Extent;
use super::row::Row;
use super::stand::{Stand, StandError};
use super::trial::Try;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use std::collections::BTreeMap;

/// Time from when the observers have settled until the faults begin, s: longer than the widest
/// window.
const LEAD: f64 = 37.0;

/// Cylinders in each of which one has a fault at once. Where half of the cylinders show a fault, the
/// detectors attribute it to something shared.
pub(super) const TURNS: u32 = 3;

/// First stream of random numbers, apart from those of all other jobs.
const STREAMS: u64 = 3 << 40;
const NUMBERS: u64 = 1 << 20;

/// What the contest tries.
#[derive(Clone, Debug, PartialEq)]
pub struct Contest {
    pub grades: Vec<Grade>,
    pub rows: Vec<(Row, Course)>,
    pub seas: Vec<[f64; 2]>,
    /// Number of faults in a row.
    pub trials: u32,
    /// Hours of a healthy machine of each grade, rounded up to whole stretches; the seas take
    /// turns.
    pub hours: f64,
    pub seed: u64,
    /// Number of cylinders that are monitored.
    pub cylinders: u8,
}

/// One simulated machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContestJob {
    /// The machine of this number in a row.
    Faulty { row: usize, number: u32 },
    /// A stretch without faults.
    Quiet { grade: Grade, number: u32 },
}

/// Result of a job.
#[derive(Clone, Debug, PartialEq)]
pub enum ContestProduct {
    Faulty(Vec<Entry>),
    Quiet(Box<QuietHours>),
}

impl Contest {
    /// Contest of every grade in every sea.
    pub fn new(seed: u64, extent: &Extent) -> Self {
        let (grades, seas) = (Grade::ALL.to_vec(), extent.seas.clone());
        let rows = grades.iter().flat_map(|grade| rows(*grade, &seas)).collect();
        let hours = extent.contest_hours * seas.len() as f64;
        Self { grades, rows, trials: extent.trials, hours, seed, cylinders: extent.cylinders, seas }
    }

    /// The number of machines of a row.
    pub fn machines(&self) -> u32 {
        self.trials.div_ceil(u32::from(self.cylinders) / self.turns())
    }

    /// Number of turns in which all cylinders have their faults.
    fn turns(&self) -> u32 {
        TURNS.min(self.cylinders.into())
    }

    /// All jobs, the longest first.
    pub fn jobs(&self) -> Vec<ContestJob> {
        let stretches = (self.hours * 3600.0 / quiet::STRETCH).ceil() as u32;
        let quiet = self.grades.iter().flat_map(|grade| {
            (0..stretches).map(|number| ContestJob::Quiet { grade: *grade, number })
        });
        let faulty = (0..self.rows.len()).flat_map(|row| {
            (0..self.machines()).map(move |number| ContestJob::Faulty { row, number })
        });
        quiet.chain(faulty).collect()
    }

    /// Does one job on `stand`, which has learnt the job's grade.
    ///
    /// # Errors
    /// If the stand has no such machine.
    pub fn run(&self, stand: &Stand, job: ContestJob) -> Result<ContestProduct, StandError> {
        let sea = |number: u32| self.seas[number as usize % self.seas.len()];
        Ok(match job {
            ContestJob::Faulty { row: index, number } => {
                let (row, course) = &self.rows[index];
                let learnt = stand.learnt(row.cell.grade)?;
                let mut rng = self.random(1 + index as u64, number);
                let one = |begin: f64, rng: &mut ChaCha8Rng| self.few(row, number, begin, rng);
                let settle = stand.settings.observer.settle;
                ContestProduct::Faulty(match course {
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
            ContestJob::Quiet { grade, number } => {
                // Not of the grades: both have the same seas and machines.
                let seed = self.random(0, number).random();
                ContestProduct::Quiet(Box::new(stand.quiet(
                    stand.learnt(grade)?,
                    sea(number),
                    seed,
                )?))
            }
        })
    }

    /// Draws a trial in which only a few cylinders have a fault.
    fn few(&self, row: &Row, number: u32, begin: f64, rng: &mut ChaCha8Rng) -> Try {
        let mut one = Try::draw(row, number, self.cylinders, begin, rng);
        let turns = self.turns();
        // Each of them in each sea.
        let turn = number / turns % turns;
        one.faults.retain(|fault| u32::from(fault.cylinder) % turns == turn);
        one
    }

    fn random(&self, stream: u64, number: u32) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(STREAMS + stream * NUMBERS + u64::from(number));
        rng
    }

    /// Seeds of the runs that `grade` is learnt from: one for the calibration, one for the level.
    pub fn lessons(&self) -> [u64; 2] {
        [0, 1].map(|which| self.random(NUMBERS - 1, which).random())
    }
}

/// Result for one grade of transducers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GradeResult {
    #[serde(skip)]
    pub of: Grade,
    pub grade: &'static str,
    /// Level h of the sequential detector, nats.
    pub level: f64,
    /// What the level was made from: the largest evidence, nats, and the time of cylinders, h;
    /// `None` where the level is configured.
    pub level_from: Option<[f64; 2]>,
    pub hours: Hours,
    pub rows: Vec<RowFigures>,
}

/// Collects the results of the jobs, in any order.
#[derive(Clone, Debug)]
pub struct ContestGathering<'a> {
    contest: &'a Contest,
    entries: Vec<BTreeMap<u32, Vec<Entry>>>,
    hours: BTreeMap<Grade, hours::Adding>,
}

impl<'a> ContestGathering<'a> {
    pub fn new(contest: &'a Contest) -> Self {
        let entries = vec![BTreeMap::new(); contest.rows.len()];
        Self { contest, entries, hours: BTreeMap::new() }
    }

    /// Takes the result of a job; each job once.
    pub fn take(&mut self, job: ContestJob, product: ContestProduct) {
        match (job, product) {
            (ContestJob::Faulty { row, number }, ContestProduct::Faulty(entries)) => {
                self.entries[row].insert(number, entries);
            }
            (ContestJob::Quiet { grade, .. }, ContestProduct::Quiet(quiet)) => {
                let adding = || hours::Adding::new(self.contest.cylinders);
                self.hours.entry(grade).or_insert_with(adding).add(&quiet);
            }
            // A job brings what it is.
            (ContestJob::Faulty { .. } | ContestJob::Quiet { .. }, _) => {}
        }
    }

    /// The result for every grade that was learnt; `sample_time` in s.
    pub fn finish(mut self, learnt: &[Learnt], sample_time: f64) -> Vec<GradeResult> {
        let entries: Vec<Vec<Entry>> = self
            .entries
            .iter_mut()
            .map(|it| std::mem::take(it).into_values().flatten().collect())
            .collect();
        let cylinders = self.contest.cylinders;
        let result = |learnt: &Learnt| {
            let hours = self.hours.remove(&learnt.grade);
            let hours = hours.map_or_else(Hours::default, |it| it.finish(learnt.nats, sample_time));
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
                        RowFigures::of(row, *course, entries, &hours, (cylinders, sample_time))
                    })
                    .collect(),
                hours,
            }
        };
        learnt.iter().map(result).collect()
    }
}
