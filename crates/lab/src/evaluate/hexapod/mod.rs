//! Drifts of one transducer that the controller reads, named by the attitude of the deck: by a sensor on it, and by the
//! vessel's motion sensor alone, which has to take it that the controller holds the deck level.
//!
//! A monitor is taught by one healthy recording of each grade of transducers; the process detectors, which would name
//! drifts by themselves, are left out. It watches other machines of the same kind, which have been at work for minutes
//! when a drift begins.

mod cases;
mod figures;
mod trial;

pub use cases::{CASES, DeckWitness, STRETCH, WITNESSES};
pub use figures::{HexapodFigures, HexapodGathered, HexapodHealthy, HexapodProduct, HexapodResult};
pub use trial::{HexapodOutcome, HexapodQuiet};

use super::extent::{Extent, StudyName};
use super::grade::Grade;
use super::learning::{COMMISSIONING, Learnt};
use super::random::random;
use super::stand::{Stand, StandError};
use super::study::Study;
use rand::RngExt;
use tertius_config::settings::Settings;
use tertius_core::monitor::MonitorDesign;

/// First stream of random numbers, apart from those of all other jobs.
const STREAMS: u64 = 11 << 41;
const NUMBERS: u64 = 1 << 20;

/// The study of the deck's attitude.
const HEXAPOD: StudyName =
    StudyName::slow("hexapod", "The same by the attitude of the deck, which takes a sensor there");

/// What is tried on which machines.
#[derive(Clone, Debug, PartialEq)]
pub struct HexapodStudy {
    pub grades: Vec<Grade>,
    pub witnesses: Vec<DeckWitness>,
    /// Significant wave height, m, and peak period, s; the seas take turns. The first one teaches.
    pub seas: Vec<[f64; 2]>,
    /// Drifts of each case, each on a machine of its own.
    pub trials: u32,
    /// Hours of each healthy machine with a sensor, rounded up to whole stretches.
    pub hours: f64,
    pub seed: u64,
}

/// One simulated machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HexapodJob {
    /// The drift of that index of [`CASES`] on one cylinder.
    Drift {
        grade: usize,
        witness: usize,
        case: usize,
        number: u32,
    },
    Quiet {
        grade: usize,
        witness: usize,
        number: u32,
    },
}

impl Study for HexapodStudy {
    const NAMES: &'static [StudyName] = &[HEXAPOD];
    type Job = HexapodJob;
    /// The monitor of a grade, taught by a recording of its own.
    type Taught = MonitorDesign;
    type Product = HexapodProduct;
    type Gathered = HexapodGathered;
    type Figures = HexapodResult;

    fn planned(seed: u64, extent: &Extent) -> Option<Self> {
        extent.asks(HEXAPOD).then(|| Self {
            grades: Grade::ALL.to_vec(),
            witnesses: WITNESSES.to_vec(),
            seas: extent.seas.clone(),
            trials: extent.trials,
            hours: extent.hours,
            seed,
        })
    }

    fn fits(settings: &Settings) -> bool {
        settings.signals.top_roll.is_some()
    }

    fn lessons(&self) -> usize {
        self.grades.len()
    }

    fn teach(&self, stand: &Stand, lesson: usize) -> Result<MonitorDesign, StandError> {
        if stand.design.tilt.is_none() {
            return Err(StandError::Untaught(
                "there is no sensor on the deck: see config/e-type-top.toml".to_owned(),
            ));
        }
        let mut rng = random(self.seed, STREAMS + lesson as u64);
        let seeds = [rng.random(), rng.random()];
        let (grade, seas) = (self.grades[lesson], &self.seas[..1]);
        let Learnt { mut design, .. } = stand.learn(grade, seas, seeds, COMMISSIONING)?;
        design.cylinders.iter_mut().for_each(|cylinder| cylinder.process = None);
        Ok(design)
    }

    fn jobs(&self) -> Vec<HexapodJob> {
        let stretches = (self.hours * 3600.0 / STRETCH).ceil() as u32;
        let pairs = || {
            let witnesses = 0..self.witnesses.len();
            (0..self.grades.len())
                .flat_map(move |grade| witnesses.clone().map(move |witness| (grade, witness)))
        };
        let has_sensor = |(_, witness): &(usize, usize)| {
            matches!(self.witnesses[*witness], DeckWitness::Sensor(_))
        };
        let quiet = pairs().filter(has_sensor).flat_map(|(grade, witness)| {
            (0..stretches).map(move |number| HexapodJob::Quiet { grade, witness, number })
        });
        let drifts = pairs().flat_map(|(grade, witness)| {
            (0..CASES.len()).flat_map(move |case| {
                let numbers = 0..self.trials;
                numbers.map(move |number| HexapodJob::Drift { grade, witness, case, number })
            })
        });
        quiet.chain(drifts).collect()
    }

    fn run(
        &self,
        stand: &Stand,
        taught: &[MonitorDesign],
        job: HexapodJob,
    ) -> Result<HexapodProduct, StandError> {
        let (HexapodJob::Drift { grade, witness, number, .. }
        | HexapodJob::Quiet { grade, witness, number }) = job;
        let sea = self.seas[number as usize % self.seas.len()];
        let of = (self.grades[grade], self.witnesses[witness]);
        let design = &of.1.known_to(taught[grade].clone());
        Ok(match job {
            HexapodJob::Drift { case, .. } => {
                // All cases and witnesses are tried on the same machines at the same times.
                let mut rng = random(self.seed, STREAMS + NUMBERS + u64::from(number));
                let outcome = stand.tilting(of, design, sea, &CASES[case], number, &mut rng)?;
                HexapodProduct::Drift { place: [grade, witness, case], number, outcome }
            }
            HexapodJob::Quiet { .. } => {
                let kind = (grade * self.witnesses.len() + witness) as u64;
                let stream = STREAMS + (2 + kind) * NUMBERS + u64::from(number);
                let quiet = stand.level(of, design, sea, &mut random(self.seed, stream))?;
                HexapodProduct::Quiet { place: [grade, witness], quiet }
            }
        })
    }

    fn gather(&self, _: &Stand, gathered: &mut HexapodGathered, product: HexapodProduct) {
        gathered.add(product);
    }

    fn figures(&self, _: &Stand, _: &[MonitorDesign], gathered: HexapodGathered) -> HexapodResult {
        gathered.result(&self.grades, &self.witnesses)
    }
}
