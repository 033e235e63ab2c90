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

pub use figures::{GradeResult, Point, RowFigures};
pub use hours::{Adding, Hours};
pub use ladder::{LEVELS, Ladder, Rival};
pub use quiet::QuietHours;
pub use row::{ContestRow, Course};
pub use trial::Entry;

use super::extent::{Extent, Lessons, StudyName};
use super::grade::Grade;
use super::learning::Learnt;
use super::random::random;
use super::stand::{Stand, StandError};
use super::study::Study;
use super::tried::{TURNS, Try};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use row::rows;
use std::collections::BTreeMap;

/// Time from when the observers have settled until the faults begin, s: longer than the widest
/// window.
const LEAD: f64 = 37.0;

/// First stream of random numbers, apart from those of all other jobs.
const STREAMS: u64 = 3 << 40;
const NUMBERS: u64 = 1 << 20;

/// The study that compares detectors.
const CONTEST: StudyName =
    StudyName::slow("contest", "Thresholds and sequential detectors on the same faults and hours");

/// What the contest tries.
#[derive(Clone, Debug, PartialEq)]
pub struct Contest {
    pub grades: Vec<Grade>,
    pub rows: Vec<ContestRow>,
    pub seas: Vec<[f64; 2]>,
    /// Number of faults in a row.
    pub trials: u32,
    /// Hours of a healthy machine of each grade, rounded up to whole stretches; the seas take
    /// turns.
    pub hours: f64,
    /// Hours in each sea that the detectors learn from.
    pub lessons: Lessons,
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

/// What became of a trial.
#[derive(Clone, Debug, PartialEq)]
pub enum ContestProduct {
    Faulty { row: usize, number: u32, entries: Vec<Entry> },
    Quiet { grade: Grade, quiet: Box<QuietHours> },
}

/// Products so far.
#[derive(Clone, Debug, Default)]
pub struct ContestGathered {
    /// By row, and by the number of the machine.
    entries: BTreeMap<usize, BTreeMap<u32, Vec<Entry>>>,
    hours: BTreeMap<Grade, Adding>,
}

impl Contest {
    /// The number of machines of a row.
    fn machines(&self) -> u32 {
        self.trials.div_ceil(u32::from(self.cylinders) / self.turns())
    }

    /// Number of turns in which all cylinders have their faults.
    fn turns(&self) -> u32 {
        TURNS.min(self.cylinders.into())
    }

    /// Draws a trial in which only a few cylinders have a fault.
    fn few(&self, row: &ContestRow, number: u32, begin: f64, rng: &mut ChaCha8Rng) -> Try {
        let mut one = Try::draw(row.wanted, None, self.cylinders, begin, rng);
        let turns = self.turns();
        // Each of them in each sea.
        let turn = number / turns % turns;
        one.faults.retain(|fault| u32::from(fault.cylinder) % turns == turn);
        one
    }

    fn random(&self, stream: u64, number: u32) -> ChaCha8Rng {
        random(self.seed, STREAMS + stream * NUMBERS + u64::from(number))
    }
}

impl Study for Contest {
    const NAMES: &'static [StudyName] = &[CONTEST];
    type Job = ContestJob;
    /// What the detectors have learnt of a grade.
    type Taught = Learnt;
    type Product = ContestProduct;
    type Gathered = ContestGathered;
    type Figures = Vec<GradeResult>;

    /// Every grade in every sea.
    fn planned(seed: u64, extent: &Extent) -> Option<Self> {
        extent.asks(CONTEST).then(|| Self {
            grades: Grade::ALL.to_vec(),
            rows: Grade::ALL.into_iter().flat_map(rows).collect(),
            trials: extent.trials,
            hours: extent.hours * extent.seas.len() as f64,
            lessons: extent.lessons,
            seed,
            cylinders: extent.cylinders,
            seas: extent.seas.clone(),
        })
    }

    fn lessons(&self) -> usize {
        self.grades.len()
    }

    fn teach(&self, stand: &Stand, lesson: usize) -> Result<Learnt, StandError> {
        // One run for the calibration, one for the level.
        let seeds = [0, 1].map(|which| self.random(NUMBERS - 1, which).random());
        stand.learn(self.grades[lesson], &self.seas, seeds, self.lessons)
    }

    fn jobs(&self) -> Vec<ContestJob> {
        let stretches = (self.hours * 3600.0 / quiet::STRETCH).ceil() as u32;
        let quiet = self.grades.iter().flat_map(|grade| {
            (0..stretches).map(|number| ContestJob::Quiet { grade: *grade, number })
        });
        let faulty = (0..self.rows.len()).flat_map(|row| {
            (0..self.machines()).map(move |number| ContestJob::Faulty { row, number })
        });
        quiet.chain(faulty).collect()
    }

    fn run(
        &self,
        stand: &Stand,
        taught: &[Learnt],
        job: ContestJob,
    ) -> Result<ContestProduct, StandError> {
        let sea = |number: u32| self.seas[number as usize % self.seas.len()];
        Ok(match job {
            ContestJob::Faulty { row: index, number } => {
                let row = &self.rows[index];
                let learnt = of_grade(taught, row.grade)?;
                let mut rng = self.random(1 + index as u64, number);
                let settle = stand.settings.observer.settle;
                let entries = match row.course {
                    Course::Engaged => {
                        let one = self.few(row, number, settle + LEAD, &mut rng);
                        stand.contest(learnt, &one, sea(number), row.watch)?
                    }
                    Course::Stop => {
                        let one = self.few(row, number, stop::BEGIN, &mut rng);
                        stand.stop(learnt, &one, sea(number))?
                    }
                };
                ContestProduct::Faulty { row: index, number, entries }
            }
            ContestJob::Quiet { grade, number } => {
                // Not of the grades: both have the same seas and machines.
                let seed = self.random(0, number).random();
                let quiet = stand.quiet(of_grade(taught, grade)?, sea(number), seed)?;
                ContestProduct::Quiet { grade, quiet: Box::new(quiet) }
            }
        })
    }

    fn gather(&self, _: &Stand, gathered: &mut ContestGathered, product: ContestProduct) {
        match product {
            ContestProduct::Faulty { row, number, entries } => {
                gathered.entries.entry(row).or_default().insert(number, entries);
            }
            ContestProduct::Quiet { grade, quiet } => {
                let adding = || Adding::new(self.cylinders);
                gathered.hours.entry(grade).or_insert_with(adding).add(&quiet);
            }
        }
    }

    /// The result for every grade that was learnt.
    fn figures(
        &self,
        stand: &Stand,
        taught: &[Learnt],
        gathered: ContestGathered,
    ) -> Vec<GradeResult> {
        let ContestGathered { entries, mut hours } = gathered;
        let sample_time = stand.settings.machine.sample_time;
        let rows = entries.into_iter().map(|(row, machines)| {
            (&self.rows[row], machines.into_values().flatten().collect::<Vec<Entry>>())
        });
        let rows: Vec<_> = rows.filter(|(_, entries)| !entries.is_empty()).collect();
        let result = |learnt: &Learnt| {
            let hours = hours.remove(&learnt.grade);
            let hours = hours.map_or_else(Hours::default, |it| it.finish(learnt.nats, sample_time));
            let own = rows.iter().filter(|(row, _)| row.grade == learnt.grade);
            let scale = (self.cylinders, sample_time);
            let rows = own.map(|(row, entries)| RowFigures::of(row, entries, &hours, scale));
            GradeResult {
                grade: learnt.grade.name(),
                level: learnt.nats,
                level_from: learnt.level.map(|level| [level.worst, level.hours]),
                rows: rows.collect(),
                hours,
            }
        };
        taught.iter().map(result).collect()
    }
}

/// What was learnt of `grade`.
fn of_grade(taught: &[Learnt], grade: Grade) -> Result<&Learnt, StandError> {
    let learnt = taught.iter().find(|learnt| learnt.grade == grade);
    learnt.ok_or_else(|| StandError::Untaught(format!("{} was not learnt", grade.name())))
}
