//! Drifts of C1 and of C2 that the controller reads: which of the two is named, and how far it had drifted by then.
//!
//! A monitor is taught by one healthy recording of each machine, the sequential detectors and those of the process
//! alike, and watches other machines of the same kind, which have been at work for minutes when a drift begins.

mod figures;
mod trial;

pub use figures::{SideFigures, SideGathering, SideHealthy, SideResult};
pub use trial::{SideOutcome, SideQuiet};

use super::learning::Lessons;
use super::plan::Extent;
use super::process::ProcessMachine;
use super::stand::{Stand, StandError};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tertius_core::monitor::MonitorDesign;
use tertius_core::verdict::Suspect;

/// A drift of one transducer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideCase {
    /// C1 or C2.
    pub transducer: Suspect,
    /// m/s; either sign is tried.
    pub rate: f64,
}

/// What is tried.
pub const CASES: [SideCase; 10] = SideCase::each([0.3e-3, 0.5e-3, 1e-3, 2e-3, 5e-3]);

impl SideCase {
    /// Those of C1 with each of the `rates`, m/s, and then those of C2: `CASES` are twice as many.
    pub(super) const fn each<const RATES: usize, const CASES: usize>(
        rates: [f64; RATES],
    ) -> [Self; CASES] {
        let mut cases = [Self { transducer: Suspect::C1, rate: 0.0 }; CASES];
        let mut i = 0;
        while i < RATES {
            cases[i].rate = rates[i];
            cases[i + RATES] = Self { transducer: Suspect::C2, rate: rates[i] };
            i += 1;
        }
        cases
    }
}

/// A drift has to be named before this, m.
pub const IN_TIME: f64 = 0.02;

/// Hours to learn from: 25 minutes, and another recording for the level.
pub(super) const LESSONS: Lessons = Lessons { calibration: 1500.0 / 3600.0, level: 0.5 };

/// How long one healthy machine is watched, s.
pub const STRETCH: f64 = 1800.0;

/// First stream of random numbers, apart from those of all other jobs.
const STREAMS: u64 = 7 << 41;
const NUMBERS: u64 = 1 << 20;

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

/// Result of a job.
#[derive(Clone, Debug, PartialEq)]
pub enum SideProduct {
    Drift(Vec<SideOutcome>),
    Quiet(SideQuiet),
}

impl SideStudy {
    /// The study of all machines.
    pub fn new(seed: u64, extent: &Extent) -> Self {
        Self {
            machines: ProcessMachine::all(extent.lag),
            seas: extent.seas.clone(),
            trials: extent.trials,
            hours: extent.side_hours,
            seed,
            cylinders: extent.cylinders,
        }
    }

    /// All jobs, the longest first.
    pub fn jobs(&self) -> Vec<SideJob> {
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

    /// The monitors of all machines, each taught by a recording of its own.
    ///
    /// # Errors
    /// There is no such machine, or it teaches nothing.
    pub fn designs(&self, stand: &Stand) -> Result<Vec<MonitorDesign>, StandError> {
        let numbered = (0..).zip(&self.machines);
        let taught = numbered.map(|(number, machine)| {
            let mut rng = self.random(STREAMS + number);
            let seeds = [rng.random(), rng.random()];
            let learnt = stand.commission(*machine, false, &self.seas[..1], seeds, LESSONS)?;
            Ok(learnt.design)
        });
        taught.collect()
    }

    /// Does one job on `stand`.
    ///
    /// # Errors
    /// There is no such machine, or no place for such a drift on it.
    pub fn run(&self, stand: &Stand, job: SideJob) -> Result<SideProduct, StandError> {
        let (machine, number) = match job {
            SideJob::Drift { machine, number, .. } | SideJob::Quiet { machine, number } => {
                (machine, number)
            }
        };
        let sea = self.seas[number as usize % self.seas.len()];
        let design = &stand.sided[machine];
        let of = self.machines[machine];
        Ok(match job {
            SideJob::Drift { case, .. } => {
                // All cases are tried on the same machines at the same times.
                let mut rng = self.random(STREAMS + NUMBERS + u64::from(number));
                SideProduct::Drift(stand.drifting(of, design, sea, &CASES[case], &mut rng)?)
            }
            SideJob::Quiet { .. } => {
                let stream = STREAMS + (2 + machine as u64) * NUMBERS + u64::from(number);
                SideProduct::Quiet(stand.still(of, design, sea, &mut self.random(stream))?)
            }
        })
    }

    fn random(&self, stream: u64) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(stream);
        rng
    }
}
