//! Accommodation of a step (thesis, 6-2): whether the estimate by a transducer less its step is right once the other
//! transducer is lost, and what is valid without it.
//!
//! One transducer of every second cylinder has a fault, and the other one is lost a minute and a half later. In some cases
//! the one that is left then has a second fault. Two monitors take the same frames, with and without accommodation.

mod cases;
mod figures;
#[cfg(test)]
mod tests;
mod trial;

pub use cases::{AccommodateCase, CASES};
pub use figures::{AccommodateFigures, AccommodateResult};
pub use trial::{AccommodateOutcome, AccommodateOutcomes};

use super::extent::{Extent, StudyName};
use super::grade::Grade;
use super::random::random;
use super::stand::{Stand, StandError};
use super::study::Study;
use std::collections::BTreeMap;
use trial::Drawn;

/// First stream of random numbers, apart from those of all other jobs.
const STREAMS: u64 = 15 << 41;

/// The study of accommodation.
const ACCOMMODATE: StudyName = StudyName::slow(
    "accommodate",
    "The estimate by a transducer less its step, once the other one is lost",
);

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

impl Study for AccommodateStudy {
    const NAMES: &'static [StudyName] = &[ACCOMMODATE];
    type Job = AccommodateJob;
    type Taught = ();
    type Product = (AccommodateJob, AccommodateOutcomes);
    type Gathered = BTreeMap<AccommodateJob, AccommodateOutcomes>;
    type Figures = AccommodateResult;

    fn planned(seed: u64, extent: &Extent) -> Option<Self> {
        extent.asks(ACCOMMODATE).then(|| Self {
            cases: CASES.to_vec(),
            seas: extent.seas.clone(),
            trials: extent.trials,
            seed,
            cylinders: extent.cylinders,
        })
    }

    fn teach(&self, _: &Stand, _: usize) -> Result<(), StandError> {
        Ok(())
    }

    fn jobs(&self) -> Vec<AccommodateJob> {
        let machines = self.trials.div_ceil(u32::from((self.cylinders / 2).max(1)));
        let of = |grade| (0..machines).map(move |number| AccommodateJob { grade, number });
        (0..Grade::ALL.len()).flat_map(of).collect()
    }

    fn run(
        &self,
        stand: &Stand,
        _: &[()],
        job: AccommodateJob,
    ) -> Result<Self::Product, StandError> {
        // Both grades, and all cases, are tried on the same machines at the same times.
        let mut rng = random(self.seed, STREAMS + u64::from(job.number));
        let sea = self.seas[job.number as usize % self.seas.len()];
        let drawn = Drawn::new(job.number, self.cylinders, sea, &mut rng);
        Ok((job, stand.accommodated(Grade::ALL[job.grade], &self.cases, &drawn)?))
    }

    fn gather(&self, _: &Stand, gathered: &mut Self::Gathered, (job, outcomes): Self::Product) {
        gathered.insert(job, outcomes);
    }

    fn figures(&self, stand: &Stand, _: &[()], gathered: Self::Gathered) -> AccommodateResult {
        let mut grades = Grade::ALL.map(|grade| (grade, Vec::new()));
        for (job, outcomes) in gathered {
            grades[job.grade].1.push(outcomes);
        }
        AccommodateResult::new(&self.cases, &grades, stand.settings.machine.sample_time)
    }
}
