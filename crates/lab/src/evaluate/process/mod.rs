//! Faults of the cylinders themselves, and of transducers beside them: what the process detectors find, how soon, and
//! what they call it.
//!
//! A monitor is taught by one healthy recording of each machine, of a valve with a slow spool and one with a fast one,
//! and watches other machines of the same kind.

mod cases;
mod figures;
mod trial;

pub use cases::{CASES, ProcessCase, STRETCH};
pub use figures::{ProcessFigures, ProcessGathered, ProcessHealthy, ProcessProduct, ProcessResult};
pub use trial::{ProcessOutcome, ProcessQuiet};

use super::extent::{Extent, StudyName};
use super::learning::COMMISSIONING;
use super::machines::ProcessMachine;
use super::random::random;
use super::stand::{Stand, StandError};
use super::study::Study;
use rand::RngExt;
use tertius_core::monitor::MonitorDesign;

/// First stream of random numbers, apart from those of all other jobs.
const STREAMS: u64 = 7 << 40;
const NUMBERS: u64 = 1 << 20;

/// The study of faults of the process.
const PROCESS: StudyName = StudyName::slow(
    "process",
    "Faults of valves, pressures and commands, which are no transducer's",
);

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

impl ProcessStudy {
    /// Number of machines with the fault of `case`.
    const fn repeats(&self, case: &ProcessCase) -> u32 {
        if case.is_of_all() { self.trials } else { self.trials.div_ceil(self.cylinders as u32) }
    }

    fn sea(&self, number: u32) -> [f64; 2] {
        self.seas[number as usize % self.seas.len()]
    }
}

impl Study for ProcessStudy {
    const NAMES: &'static [StudyName] = &[PROCESS];
    type Job = ProcessJob;
    /// The monitor of a machine, taught by a recording of its own.
    type Taught = MonitorDesign;
    type Product = ProcessProduct;
    type Gathered = ProcessGathered;
    type Figures = ProcessResult;

    fn planned(seed: u64, extent: &Extent) -> Option<Self> {
        extent.asks(PROCESS).then(|| Self {
            machines: ProcessMachine::all(extent.lag),
            seas: extent.seas.clone(),
            trials: extent.trials,
            hours: extent.hours,
            seed,
            cylinders: extent.cylinders,
        })
    }

    fn lessons(&self) -> usize {
        self.machines.len()
    }

    fn teach(&self, stand: &Stand, lesson: usize) -> Result<MonitorDesign, StandError> {
        let mut rng = random(self.seed, STREAMS + lesson as u64);
        let seeds = [rng.random(), rng.random()];
        let (machine, seas) = (self.machines[lesson], &self.seas[..1]);
        let learnt = stand.commission(machine, true, seas, seeds, COMMISSIONING)?;
        is_complete(&learnt.design)?;
        Ok(learnt.design)
    }

    fn jobs(&self) -> Vec<ProcessJob> {
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

    fn run(
        &self,
        stand: &Stand,
        taught: &[MonitorDesign],
        job: ProcessJob,
    ) -> Result<ProcessProduct, StandError> {
        Ok(match job {
            ProcessJob::Faulty { machine, case, number } => {
                // All cases are tried on the same machines at the same times.
                let mut rng = random(self.seed, STREAMS + NUMBERS + u64::from(number));
                let (of, sea) = ((self.machines[machine], &taught[machine]), self.sea(number));
                let outcomes = stand.ailing(of, sea, &CASES[case], &mut rng)?;
                ProcessProduct::Faulty { machine, case, number, outcomes }
            }
            ProcessJob::Quiet { machine, number } => {
                let stream = STREAMS + (2 + machine as u64) * NUMBERS + u64::from(number);
                let (of, sea) = ((self.machines[machine], &taught[machine]), self.sea(number));
                let quiet = stand.hale(of, sea, &mut random(self.seed, stream))?;
                ProcessProduct::Quiet { machine, quiet }
            }
        })
    }

    fn gather(&self, _: &Stand, gathered: &mut ProcessGathered, product: ProcessProduct) {
        gathered.add(product);
    }

    fn figures(&self, _: &Stand, _: &[MonitorDesign], gathered: ProcessGathered) -> ProcessResult {
        gathered.result(&self.machines)
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
