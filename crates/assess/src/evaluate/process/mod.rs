//! Faults of the cylinders themselves, and of transducers beside them: what the process detectors find, how soon, and
//! what they call it.
//!
//! A monitor is taught by one healthy recording of each machine, of a valve with a slow spool and one with a fast one,
//! and watches other machines of the same kind.

mod cases;
mod figures;
mod trial;

pub use cases::{CASES, ProcessCase};
pub(super) use figures::percentiles;
pub use figures::{ProcessFigures, ProcessGathering, ProcessHealthy, ProcessResult};
pub use trial::{ProcessOutcome, ProcessQuiet};
pub(super) use trial::{is_process, varied};

use super::grade::Grade;
use super::plan::Extent;
use super::side::LESSONS;
use super::stand::{Stand, StandError};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use tertius_core::monitor::MonitorDesign;

/// Transducers, and the time constant of the spools, s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ProcessMachine {
    pub grade: Grade,
    pub lag: f64,
}

/// Time constant of the spools of fast servo-valves, s, which are tried beside the plant's own.
const FAST: f64 = 0.01;

impl ProcessMachine {
    /// Machines of every grade, with spools of the time constant `lag`, s, and with fast ones.
    pub(super) fn all(lag: f64) -> Vec<Self> {
        let of = |grade| [lag, FAST].map(|lag| Self { grade, lag });
        Grade::ALL.into_iter().flat_map(of).collect()
    }
}

/// How long one healthy machine is watched, s.
pub const STRETCH: f64 = 1800.0;

/// First stream of random numbers, apart from those of all other jobs.
const STREAMS: u64 = 7 << 40;
const NUMBERS: u64 = 1 << 20;

/// What is tried.
#[derive(Clone, Debug, PartialEq)]
pub struct ProcessStudy {
    pub machines: Vec<ProcessMachine>,
    /// Significant wave height, m, and peak period, s; the seas take turns. The first one teaches.
    pub seas: Vec<[f64; 2]>,
    /// Faults of each case, rounded up to whole machines.
    pub trials: u32,
    /// Hours of each healthy machine, rounded up to whole stretches.
    pub hours: f64,
    pub seed: u64,
    /// Number of cylinders that are monitored.
    pub cylinders: u8,
}

/// One simulated machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProcessJob {
    /// The machine of that index with the fault of that index of [`CASES`] on every cylinder.
    Faulty {
        machine: usize,
        case: usize,
        number: u32,
    },
    Quiet {
        machine: usize,
        number: u32,
    },
}

/// Result of a job.
#[derive(Clone, Debug, PartialEq)]
pub enum ProcessProduct {
    Faulty(Vec<ProcessOutcome>),
    Quiet(ProcessQuiet),
}

impl ProcessStudy {
    /// The study of all machines.
    pub fn new(seed: u64, extent: &Extent) -> Self {
        Self {
            machines: ProcessMachine::all(extent.lag),
            seas: extent.seas.clone(),
            trials: extent.trials,
            hours: extent.process_hours,
            seed,
            cylinders: extent.cylinders,
        }
    }

    /// Number of machines with the fault of `case`.
    pub const fn repeats(&self, case: &ProcessCase) -> u32 {
        if case.is_of_all() { self.trials } else { self.trials.div_ceil(self.cylinders as u32) }
    }

    /// All jobs, the longest first.
    pub fn jobs(&self) -> Vec<ProcessJob> {
        let stretches = (self.hours * 3600.0 / STRETCH).ceil() as u32;
        let machines = || 0..self.machines.len();
        let quiet = machines().flat_map(|machine| {
            (0..stretches).map(move |number| ProcessJob::Quiet { machine, number })
        });
        let faulty = machines().flat_map(|machine| {
            (0..CASES.len()).flat_map(move |case| {
                let numbers = 0..self.repeats(&CASES[case]);
                numbers.map(move |number| ProcessJob::Faulty { machine, case, number })
            })
        });
        quiet.chain(faulty).collect()
    }

    /// The monitors of all machines, each taught by a recording of its own.
    ///
    /// # Errors
    /// There is no such machine, or it teaches nothing.
    pub fn designs(&self, stand: &Stand) -> Result<Vec<MonitorDesign>, StandError> {
        let numbered = (0..).zip(&self.machines);
        let taught = numbered.map(|(number, machine)| {
            let mut rng = self.random(STREAMS + number);
            let seeds = [rng.random(), rng.random()];
            let learnt = stand.commission(*machine, true, &self.seas[..1], seeds, LESSONS)?;
            is_complete(&learnt.design)?;
            Ok(learnt.design)
        });
        taught.collect()
    }

    /// Does one job on `stand`.
    ///
    /// # Errors
    /// There is no such machine, or no place for such a fault on it.
    pub fn run(&self, stand: &Stand, job: ProcessJob) -> Result<ProcessProduct, StandError> {
        Ok(match job {
            ProcessJob::Faulty { machine, case, number } => {
                // All cases are tried on the same machines at the same times.
                let mut rng = self.random(STREAMS + NUMBERS + u64::from(number));
                let sea = self.sea(number);
                let case = &CASES[case];
                ProcessProduct::Faulty(stand.ailing(
                    self.machines[machine],
                    machine,
                    sea,
                    case,
                    &mut rng,
                )?)
            }
            ProcessJob::Quiet { machine, number } => {
                let stream = STREAMS + (2 + machine as u64) * NUMBERS + u64::from(number);
                let mut rng = self.random(stream);
                let sea = self.sea(number);
                ProcessProduct::Quiet(stand.hale(self.machines[machine], machine, sea, &mut rng)?)
            }
        })
    }

    fn sea(&self, number: u32) -> [f64; 2] {
        self.seas[number as usize % self.seas.len()]
    }

    fn random(&self, stream: u64) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(stream);
        rng
    }
}

/// Whether every cylinder has learnt every relation: figures of the others would be of nothing.
fn is_complete(design: &MonitorDesign) -> Result<(), StandError> {
    for (number, cylinder) in (1..).zip(&design.cylinders) {
        let process = cylinder.process.as_ref();
        let learnt = [
            ("spool", process.is_some_and(|it| it.spool.is_some())),
            ("chambers", process.is_some_and(|it| it.chambers.is_some())),
            ("flow", process.is_some_and(|it| it.flow.is_some())),
            ("friction", process.is_some_and(|it| it.friction.is_some())),
            ("supply", process.is_some_and(|it| it.supply)),
        ];
        if let Some((name, _)) = learnt.into_iter().find(|(_, is_known)| !is_known) {
            let why =
                format!("process detectors: cylinder {number} has learnt nothing by the {name}");
            return Err(StandError::Untaught(why));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use tertius_config::design;
    use tertius_dbc::{Database, text};

    #[test]
    fn a_cylinder_that_lacks_a_relation_is_not_evaluated_but_told() {
        let config = include_str!("../../../../../config/e-type.toml");
        let (settings, _) = tertius_config::parse("e-type.toml", config).expect("it is sound");
        let dbc = text::from_bytes(include_bytes!("../../../../../dbc/e-type.dbc"));
        let database = Database::parse(&dbc).expect("it is sound");
        let design = design::judging(&settings, &database).expect("they fit");
        let error = is_complete(&design).expect_err("it has no process detectors").to_string();
        assert!(error.contains("cylinder 1 has learnt nothing by the spool"), "{error}");
    }
}
