//! Accommodation of a step (thesis, 6-2): whether the estimate by a transducer less its step is right once the other
//! transducer is lost, and what is valid without it.
//!
//! One transducer of every second cylinder has a fault, and the other one is lost a minute and a half later. In some cases
//! the one that is left then has a second fault. Two monitors take the same frames, with and without accommodation.

mod figures;
#[cfg(test)]
mod tests;
mod trial;

pub use figures::{AccommodateFigures, AccommodateGathering, AccommodateResult};
pub use trial::AccommodateOutcome;

use super::grade::Grade;
use super::plan::Extent;
use super::row::label;
use super::stand::{Stand, StandError};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use tertius_config::design;
use tertius_core::monitor::{Estimates, MonitorDesign};
use tertius_machine::inject::Shape;
use trial::Drawn;

/// Faults of the transducer that is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccommodateCase {
    /// While the other transducer is there.
    pub first: Shape,
    /// Added while it is alone.
    pub second: Option<Shape>,
}

impl AccommodateCase {
    const fn alone(first: Shape, second: Shape) -> Self {
        Self { first, second: Some(second) }
    }

    /// The faults in words.
    pub fn label(&self) -> String {
        let second = self.second.map(|shape| format!(", then {}", label(shape)));
        label(self.first) + &second.unwrap_or_default()
    }
}

/// What is tried. An observer follows the drift of the last case: no residual shows it.
pub const CASES: [AccommodateCase; 7] = {
    const STEP: Shape = Shape::Step { size: 0.01 };
    const fn only(first: Shape) -> AccommodateCase {
        AccommodateCase { first, second: None }
    }
    [
        only(Shape::Step { size: 2.5e-3 }),
        only(STEP),
        only(Shape::Step { size: 0.06 }),
        only(Shape::Drift { rate: 1e-3 }),
        AccommodateCase::alone(STEP, Shape::Step { size: 2.5e-3 }),
        AccommodateCase::alone(STEP, STEP),
        AccommodateCase::alone(STEP, Shape::Drift { rate: 1e-4 }),
    ]
};

/// `estimate.accommodate_after` where the configuration has none, s.
const AFTER: f64 = 60.0;

/// First stream of random numbers, apart from those of all other jobs.
const STREAMS: u64 = 15 << 41;

/// What is tried on which machines.
#[derive(Clone, Debug, PartialEq)]
pub struct AccommodateStudy {
    pub cases: Vec<AccommodateCase>,
    /// Significant wave height, m, and peak period, s; the seas take turns.
    pub seas: Vec<[f64; 2]>,
    /// Faults of each case, rounded up to whole machines.
    pub trials: u32,
    pub seed: u64,
    /// Number of cylinders that are monitored.
    pub cylinders: u8,
}

/// One simulated machine, with every case one after another from the same beginning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct AccommodateJob {
    /// Index in [`Grade::ALL`].
    pub grade: usize,
    pub number: u32,
}

/// Result of a job: by case, of each cylinder with a fault, without accommodation and with it.
pub type AccommodateProduct = Vec<Vec<[AccommodateOutcome; 2]>>;

impl AccommodateStudy {
    pub fn new(seed: u64, extent: &Extent) -> Self {
        Self {
            cases: CASES.to_vec(),
            seas: extent.seas.clone(),
            trials: extent.trials,
            seed,
            cylinders: extent.cylinders,
        }
    }

    pub fn jobs(&self) -> Vec<AccommodateJob> {
        let machines = self.trials.div_ceil(u32::from((self.cylinders / 2).max(1)));
        let of = |grade| (0..machines).map(move |number| AccommodateJob { grade, number });
        (0..Grade::ALL.len()).flat_map(of).collect()
    }

    /// Does one job on `stand`.
    ///
    /// # Errors
    /// There is no such machine, or no place for such a fault on it.
    pub fn run(
        &self,
        stand: &Stand,
        job: AccommodateJob,
    ) -> Result<AccommodateProduct, StandError> {
        // Both grades, and all cases, are tried on the same machines at the same times.
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(STREAMS + u64::from(job.number));
        let sea = self.seas[job.number as usize % self.seas.len()];
        let drawn = Drawn::new(job.number, self.cylinders, sea, &mut rng);
        stand.accommodated(Grade::ALL[job.grade], &self.cases, &drawn)
    }
}

impl Stand<'_> {
    /// The monitor without accommodation, and with it.
    fn accommodating(&self) -> [MonitorDesign; 2] {
        let after = self.settings.estimate.accommodate_after.unwrap_or(AFTER);
        [None, Some(design::accommodation(self.settings, after))].map(|accommodation| {
            let mut design =
                MonitorDesign { estimates: Estimates::Computed, ..self.design.clone() };
            for cylinder in &mut design.cylinders {
                cylinder.estimate.accommodation = accommodation;
            }
            design
        })
    }
}
