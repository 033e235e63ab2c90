//! Comparison of weights for the observers, each set with its own threshold.
//!
//! Every set of weights has its monitor, and all of them watch the same machines: fault-free hours
//! give the δ_h for a wanted rate of false alarms and show how often the thesis's is crossed; the
//! faults of section 5-4 show how many are seen with each. Weights cannot be judged without their
//! threshold, and a result from a calm sea does not hold in a rough one, so the seas are tried in
//! turn and judged together.

mod cases;
mod figures;
mod trial;

pub use cases::{FAULTS, MOST, SETS, TransducerKind};
pub use figures::{Seen, SetResult, WeightsGathered, WeightsProduct};
pub use trial::{Faulty, QuietMachine};

use super::extent::{Extent, StudyName};
use super::random::random;
use super::stand::{Stand, StandError};
use super::study::Study;
use crate::flaws::listed;
use figures::Results;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use tertius_config::design::{self, Flaw};
use tertius_core::monitor::MonitorDesign;
use tertius_learn::tune::{LEAST_HIGH, Weights};
use tertius_machine::inject::Wanted;
use trial::STRETCH;

/// First stream of random numbers, apart from those of all other jobs.
const STREAMS: u64 = 5 << 40;
const NUMBERS: u64 = 1 << 20;

/// The study of the observers' weights.
const WEIGHTS: StudyName =
    StudyName::slow("weights", "Weights of the observers, each with its own thresholds");

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

impl Weighing {
    fn random(&self, stream: u64, number: u32) -> ChaCha8Rng {
        random(self.seed, STREAMS + stream * NUMBERS + u64::from(number))
    }
}

impl Study for Weighing {
    const NAMES: &'static [StudyName] = &[WEIGHTS];
    type Job = WeightsJob;
    /// The monitor of a set, with the thesis's thresholds and otherwise as configured.
    type Taught = MonitorDesign;
    type Product = WeightsProduct;
    type Gathered = WeightsGathered;
    type Figures = Vec<SetResult>;

    fn planned(seed: u64, extent: &Extent) -> Option<Self> {
        extent.asks(WEIGHTS).then(|| Self {
            kinds: TransducerKind::ALL.to_vec(),
            sets: extent.weights.clone(),
            seas: extent.seas.clone(),
            trials: extent.trials,
            hours: extent.hours * extent.seas.len() as f64,
            seed,
            cylinders: extent.cylinders,
        })
    }

    /// A set may have no observer.
    fn check(&self, stand: &Stand) -> Result<(), StandError> {
        (0..self.lessons()).try_for_each(|set| self.teach(stand, set).map(drop))
    }

    fn lessons(&self) -> usize {
        self.sets.len()
    }

    fn teach(&self, stand: &Stand, lesson: usize) -> Result<MonitorDesign, StandError> {
        let (mut settings, weights) = (stand.settings.clone(), self.sets[lesson]);
        (settings.observer.q, settings.observer.r) = (weights.q, weights.r);
        (settings.fde.high, settings.fde.low) = (LEAST_HIGH, 0.75 * LEAST_HIGH);
        let refused = |flaws: Vec<Flaw>| format!("--weights: {}", listed(&flaws));
        let design = design::judging(&settings, stand.database);
        design.map_err(|flaws| StandError::Refused(refused(flaws)))
    }

    fn jobs(&self) -> Vec<WeightsJob> {
        let stretches = (self.hours * 3600.0 / STRETCH).ceil() as u32;
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

    fn run(
        &self,
        stand: &Stand,
        taught: &[MonitorDesign],
        job: WeightsJob,
    ) -> Result<WeightsProduct, StandError> {
        let sea = |number: u32| self.seas[number as usize % self.seas.len()];
        // The same machines and times of faults for every kind.
        Ok(match job {
            WeightsJob::Faulty { kind, fault, number } => {
                let mut rng = self.random(1 + fault as u64, number);
                let (shape, watch) = FAULTS[fault];
                let fault_of_all = (Wanted::Shape(shape), watch);
                let sets = stand.seen(taught, kind, sea(number), fault_of_all, &mut rng)?;
                WeightsProduct::Faulty { kind, fault, number, sets }
            }
            WeightsJob::Quiet { kind, number } => {
                let seed = self.random(0, number).random();
                let sets = stand.unseen(taught, kind, sea(number), seed)?;
                WeightsProduct::Quiet { kind, number, sets }
            }
        })
    }

    fn gather(&self, _: &Stand, gathered: &mut WeightsGathered, product: WeightsProduct) {
        gathered.add(product);
    }

    fn figures(
        &self,
        stand: &Stand,
        _: &[MonitorDesign],
        gathered: WeightsGathered,
    ) -> Vec<SetResult> {
        let results = Results {
            gathered: &gathered,
            sets: &self.sets,
            cylinders: self.cylinders.into(),
            block: stand.block(),
        };
        self.kinds.iter().flat_map(|kind| results.of_kind(*kind)).collect()
    }
}
