//! Drifts of C1 and of C2 that the controller reads: which of the two is named, and how far it had drifted by then.
//!
//! A monitor is taught by one healthy recording of each machine, the sequential detectors and those of the process
//! alike, and watches other machines of the same kind, which have been at work for minutes when a drift begins.

pub(super) mod cases;
mod figures;
mod trial;

pub use cases::{CASES, IN_TIME, STRETCH, SideCase};
pub use figures::{SideFigures, SideGathered, SideHealthy, SideProduct, SideResult};
pub use trial::{SideOutcome, SideQuiet};

use super::extent::{Extent, StudyName};
use super::learning::COMMISSIONING;
use super::machines::ProcessMachine;
use super::random::random;
use super::stand::{Stand, StandError};
use super::study::Study;
use rand::RngExt;
use tertius_core::monitor::MonitorDesign;

/// First stream of random numbers, apart from those of all other jobs.
const STREAMS: u64 = 7 << 41;
const NUMBERS: u64 = 1 << 20;

/// The study of the drifts in the loop.
const SIDE: StudyName = StudyName::slow(
    "side",
    "Drifts of C1 and of C2 that the controller reads: which of them is named, and how soon",
);

/// What is tried on which machines.
#[derive(Clone, Debug, PartialEq)]
pub struct SideStudy {
    pub machines: Vec<ProcessMachine>,
    /// Significant wave height, m, and peak period, s; the seas take turns. The first one teaches.
    pub seas: Vec<[f64; 2]>,
    /// Drifts of each case on each machine, rounded up to whole machines.
    pub trials: u32,
    /// Hours of each healthy machine, rounded up to whole stretches.
    pub hours: f64,
    pub seed: u64,
    /// Number of cylinders that are monitored.
    pub cylinders: u8,
}

/// One simulated machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SideJob {
    /// The machine of that index with the drift of that index of [`CASES`] on every cylinder.
    Drift {
        machine: usize,
        case: usize,
        number: u32,
    },
    Quiet {
        machine: usize,
        number: u32,
    },
}

impl Study for SideStudy {
    const NAMES: &'static [StudyName] = &[SIDE];
    type Job = SideJob;
    /// The monitor of a machine, taught by a recording of its own.
    type Taught = MonitorDesign;
    type Product = SideProduct;
    type Gathered = SideGathered;
    type Figures = SideResult;

    fn planned(seed: u64, extent: &Extent) -> Option<Self> {
        extent.asks(SIDE).then(|| Self {
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
        Ok(stand.commission(machine, false, seas, seeds, COMMISSIONING)?.design)
    }

    fn jobs(&self) -> Vec<SideJob> {
        let stretches = (self.hours * 3600.0 / STRETCH).ceil() as u32;
        let repeats = self.trials.div_ceil(u32::from(self.cylinders));
        let machines = || 0..self.machines.len();
        let quiet = machines().flat_map(|machine| {
            (0..stretches).map(move |number| SideJob::Quiet { machine, number })
        });
        let drifts = machines().flat_map(|machine| {
            (0..CASES.len()).flat_map(move |case| {
                (0..repeats).map(move |number| SideJob::Drift { machine, case, number })
            })
        });
        quiet.chain(drifts).collect()
    }

    fn run(
        &self,
        stand: &Stand,
        taught: &[MonitorDesign],
        job: SideJob,
    ) -> Result<SideProduct, StandError> {
        let sea = |number: u32| self.seas[number as usize % self.seas.len()];
        Ok(match job {
            SideJob::Drift { machine, case, number } => {
                // All cases are tried on the same machines at the same times.
                let mut rng = random(self.seed, STREAMS + NUMBERS + u64::from(number));
                let (of, design) = (self.machines[machine], &taught[machine]);
                let outcomes = stand.drifting(of, design, sea(number), &CASES[case], &mut rng)?;
                SideProduct::Drift { machine, case, number, outcomes }
            }
            SideJob::Quiet { machine, number } => {
                let stream = STREAMS + (2 + machine as u64) * NUMBERS + u64::from(number);
                let (of, design) = (self.machines[machine], &taught[machine]);
                let mut rng = random(self.seed, stream);
                let quiet = stand.still(of, design, sea(number), &mut rng)?;
                SideProduct::Quiet { machine, quiet }
            }
        })
    }

    fn gather(&self, _: &Stand, gathered: &mut SideGathered, product: SideProduct) {
        gathered.add(product);
    }

    fn figures(&self, _: &Stand, _: &[MonitorDesign], gathered: SideGathered) -> SideResult {
        gathered.result(&self.machines)
    }
}
