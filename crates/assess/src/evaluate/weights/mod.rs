//! Comparison of weights for the observers, each set with its own threshold.
//!
//! Every set of weights has its monitor, and all of them watch the same machines: fault-free hours
//! give the δ_h for a wanted rate of false alarms and show how often the thesis's is crossed; the
//! faults of section 5-4 show how many are seen with each. Weights cannot be judged without their
//! threshold, and a result from a calm sea does not hold in a rough one, so the seas are tried in
//! turn and judged together.

mod figures;
mod trial;

pub use figures::{Seen, SetResult, WeightsGathering};
pub use trial::{Faulty, QuietMachine};

use super::grade::Grade;
use super::row::SIGMA;
use super::stand::{Stand, StandError};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tertius_config::design::{self, Flaw};
use tertius_config::settings::Settings;
use tertius_core::monitor::MonitorDesign;
use tertius_dbc::Database;
use tertius_learn::tune::criterion::{INCIPIENT, STEP};
use tertius_learn::tune::{LEAST_HIGH, Weights};
use tertius_machine::inject::{Shape, Wanted};

/// Sets that are tried when the command line names none: of the thesis's design, of fine and of
/// coarse transducers, and a slow one.
pub const SETS: [Weights; 4] = [
    Weights { q: [1e-8, 1e-3, 100.0], r: [1e-8, 1e-2] },
    Weights { q: [5e-9, 2e-4, 1e4], r: [1e-8, 5.0] },
    Weights { q: [1e-8, 3e-5, 2e3], r: [1e-8, 1.0] },
    Weights { q: [1e-9, 1e-6, 100.0], r: [1e-8, 1e-2] },
];

/// Most sets: each has its monitor on every machine.
pub const MOST: usize = 32;

/// Faults that are tried, and how long each is watched by the observer of its transducer, s: 0 is
/// the faulty reading alone.
pub const FAULTS: [(Shape, f64); 5] = [
    (Shape::Step { size: STEP }, 0.0),
    (Shape::Step { size: 1.25e-3 }, 0.0),
    (Shape::Step { size: 1.5e-3 }, 0.0),
    (Shape::Incipient { size: INCIPIENT.0, b: INCIPIENT.1 }, 0.1),
    (Shape::Noise { size: SIGMA }, 10.0),
];

/// First stream of random numbers, apart from those of all other jobs.
const STREAMS: u64 = 5 << 40;
const NUMBERS: u64 = 1 << 20;

/// Transducers, and whether their readings are off for a while now and then, as in Figure 5-9.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum TransducerKind {
    Steady,
    Fluctuating,
    Coarse,
}

impl TransducerKind {
    pub const ALL: [Self; 3] = [Self::Steady, Self::Fluctuating, Self::Coarse];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Steady => "fine",
            Self::Fluctuating => "fine, fluctuating",
            Self::Coarse => "coarse",
        }
    }

    const fn of_grade(self) -> Grade {
        match self {
            Self::Steady | Self::Fluctuating => Grade::Fine,
            Self::Coarse => Grade::Coarse,
        }
    }
}

/// What is tried.
#[derive(Clone, Debug, PartialEq)]
pub struct Weighing {
    pub kinds: Vec<TransducerKind>,
    pub sets: Vec<Weights>,
    /// Significant wave height, m, and peak period, s; the seas take turns.
    pub seas: Vec<[f64; 2]>,
    /// Faults of each kind, rounded up to whole machines.
    pub trials: u32,
    /// Hours of a healthy machine of each kind, rounded up to whole stretches.
    pub hours: f64,
    pub seed: u64,
    /// Number of cylinders that are monitored.
    pub cylinders: u8,
}

/// One simulated machine, which all sets watch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WeightsJob {
    /// A machine with the fault of that index of [`FAULTS`].
    Faulty {
        kind: TransducerKind,
        fault: usize,
        number: u32,
    },
    Quiet {
        kind: TransducerKind,
        number: u32,
    },
}

/// Result of a job, for each set.
#[derive(Clone, Debug, PartialEq)]
pub enum WeightsProduct {
    Faulty(Vec<Faulty>),
    Quiet(Vec<QuietMachine>),
}

impl Weighing {
    /// The monitors of all sets, with the thesis's thresholds and otherwise as in `settings`.
    ///
    /// # Errors
    /// The flaws of the first set that has no observer.
    pub fn designs(
        &self,
        settings: &Settings,
        database: &Database,
    ) -> Result<Vec<MonitorDesign>, Vec<Flaw>> {
        let design = |weights: &Weights| {
            let mut settings = settings.clone();
            (settings.observer.q, settings.observer.r) = (weights.q, weights.r);
            (settings.fde.high, settings.fde.low) = (LEAST_HIGH, 0.75 * LEAST_HIGH);
            design::judging(&settings, database)
        };
        self.sets.iter().map(design).collect()
    }

    /// All jobs, the longest first.
    pub fn jobs(&self) -> Vec<WeightsJob> {
        let stretches = (self.hours * 3600.0 / trial::STRETCH).ceil() as u32;
        let machines = self.trials.div_ceil(u32::from(self.cylinders));
        let kinds = || self.kinds.iter().copied();
        let quiet = kinds()
            .flat_map(|kind| (0..stretches).map(move |number| WeightsJob::Quiet { kind, number }));
        let faulty = kinds().flat_map(|kind| {
            (0..FAULTS.len()).flat_map(move |fault| {
                (0..machines).map(move |number| WeightsJob::Faulty { kind, fault, number })
            })
        });
        quiet.chain(faulty).collect()
    }

    /// Does one job on `stand`, which has the monitors.
    ///
    /// # Errors
    /// If the stand has no such machine.
    pub fn run(&self, stand: &Stand, job: WeightsJob) -> Result<WeightsProduct, StandError> {
        let sea = |number: u32| self.seas[number as usize % self.seas.len()];
        // The same machines and times of faults for every kind.
        Ok(match job {
            WeightsJob::Faulty { kind, fault, number } => {
                let mut rng = self.random(1 + fault as u64, number);
                let (shape, watch) = FAULTS[fault];
                let wanted = Wanted::Shape(shape);
                let faults = stand.seen(kind, sea(number), wanted, watch, &mut rng)?;
                WeightsProduct::Faulty(faults)
            }
            WeightsJob::Quiet { kind, number } => {
                let seed = self.random(0, number).random();
                WeightsProduct::Quiet(stand.unseen(kind, sea(number), seed)?)
            }
        })
    }

    fn random(&self, stream: u64, number: u32) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(STREAMS + stream * NUMBERS + u64::from(number));
        rng
    }
}
