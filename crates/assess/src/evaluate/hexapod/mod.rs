//! Drifts of one transducer that the controller reads, named by the attitude of the deck: by a sensor on it, and by the
//! vessel's motion sensor alone, which has to take it that the controller holds the deck level.
//!
//! A monitor is taught by one healthy recording of each grade of transducers; the process detectors, which would name
//! drifts by themselves, are left out. It watches other machines of the same kind, which have been at work for minutes
//! when a drift begins.

mod figures;
mod trial;

pub use figures::{HexapodFigures, HexapodGathering, HexapodHealthy, HexapodResult};
pub use trial::{HexapodOutcome, HexapodQuiet};

use super::grade::Grade;
use super::learning::Learnt;
use super::side::{LESSONS, SideCase};
use super::stand::{Stand, StandError};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tertius_core::monitor::MonitorDesign;

/// What the deck's attitude is taken from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DeckWitness {
    /// The vessel's motion sensor alone: a deck that stands level.
    VesselAlone,
    /// A sensor on the deck whose noise, and whose error that comes and goes, have this standard deviation each, rad.
    Sensor(f64),
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// What is compared.
pub const WITNESSES: [DeckWitness; 4] = [
    DeckWitness::VesselAlone,
    DeckWitness::Sensor(0.005 * DEGREE),
    DeckWitness::Sensor(0.01 * DEGREE),
    DeckWitness::Sensor(0.05 * DEGREE),
];

impl DeckWitness {
    /// The monitor that knows how good the witness is; a deck that is presumed to be level is as good as configured.
    fn known_to(self, mut design: MonitorDesign) -> MonitorDesign {
        if let (Self::Sensor(accuracy), Some(tilt)) = (self, &mut design.tilt) {
            tilt.accuracy = accuracy;
        }
        design
    }

    /// In words.
    pub fn label(self) -> String {
        match self {
            Self::VesselAlone => "the vessel's sensor alone".to_owned(),
            Self::Sensor(accuracy) => format!("a sensor of {:.3}° on the deck", accuracy / DEGREE),
        }
    }
}

/// What is tried.
pub const CASES: [SideCase; 6] = SideCase::each([0.2e-3, 0.5e-3, 2e-3]);

/// How long one healthy machine is watched, s.
pub const STRETCH: f64 = 1800.0;

/// First stream of random numbers, apart from those of all other jobs.
const STREAMS: u64 = 11 << 41;
const NUMBERS: u64 = 1 << 20;

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

/// Result of a job.
#[derive(Clone, Debug, PartialEq)]
pub enum HexapodProduct {
    Drift(HexapodOutcome),
    Quiet(HexapodQuiet),
}

impl HexapodStudy {
    /// The study of all grades and witnesses.
    pub fn new(seed: u64, seas: Vec<[f64; 2]>, trials: u32, hours: f64) -> Self {
        let (grades, witnesses) = (Grade::ALL.to_vec(), WITNESSES.to_vec());
        Self { grades, witnesses, seas, trials, hours, seed }
    }

    /// All jobs, the longest first.
    pub fn jobs(&self) -> Vec<HexapodJob> {
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

    /// The monitors of all grades, each taught by a recording of its own.
    ///
    /// # Errors
    /// There is no such machine, it has no sensor on its deck, or it teaches nothing.
    pub fn designs(&self, stand: &Stand) -> Result<Vec<MonitorDesign>, StandError> {
        if stand.design.tilt.is_none() {
            return Err(StandError::Untaught(
                "there is no sensor on the deck: see config/e-type-top.toml".to_owned(),
            ));
        }
        let numbered = (0..).zip(&self.grades);
        let taught = numbered.map(|(number, grade)| {
            let mut rng = self.random(STREAMS + number);
            let seeds = [rng.random(), rng.random()];
            let Learnt { mut design, .. } = stand.learn(*grade, &self.seas[..1], seeds, LESSONS)?;
            design.cylinders.iter_mut().for_each(|cylinder| cylinder.process = None);
            Ok(design)
        });
        taught.collect()
    }

    /// Does one job on `stand`.
    ///
    /// # Errors
    /// There is no such machine, or no place for such a drift on it.
    pub fn run(&self, stand: &Stand, job: HexapodJob) -> Result<HexapodProduct, StandError> {
        let (HexapodJob::Drift { grade, witness, number, .. }
        | HexapodJob::Quiet { grade, witness, number }) = job;
        let sea = self.seas[number as usize % self.seas.len()];
        let of = (self.grades[grade], self.witnesses[witness]);
        let design = &of.1.known_to(stand.decked[grade].clone());
        Ok(match job {
            HexapodJob::Drift { case, .. } => {
                // All cases and witnesses are tried on the same machines at the same times.
                let mut rng = self.random(STREAMS + NUMBERS + u64::from(number));
                let case = &CASES[case];
                HexapodProduct::Drift(stand.tilting(of, design, sea, case, number, &mut rng)?)
            }
            HexapodJob::Quiet { .. } => {
                let kind = (grade * self.witnesses.len() + witness) as u64;
                let stream = STREAMS + (2 + kind) * NUMBERS + u64::from(number);
                HexapodProduct::Quiet(stand.level(of, design, sea, &mut self.random(stream))?)
            }
        })
    }

    fn random(&self, stream: u64) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(stream);
        rng
    }
}
