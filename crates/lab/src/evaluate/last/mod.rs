//! The last transducer of a cylinder: whether its faults are found once the other one is out, or where there is no C2.
//!
//! The other transducer is lost, frozen or off by a step. Ten seconds later the last one has a fault. Each fault is
//! tried beside the controller's loop and in it. The controller reads C1, so in the loop C2 is always the one that is
//! out. Only every second cylinder of a machine has faults, because the monitor may attribute what most cylinders show
//! together to something that they share.

mod cases;
mod figures;
mod outcome;
#[cfg(test)]
mod tests;
mod trial;

pub use cases::{FAULTS, LastGroup, Outage};
pub use figures::{LastFigures, LastGathered, LastHours, LastProduct, LastResult};
pub use outcome::{LastOutcome, LastQuiet};

use super::extent::{Extent, StudyName};
use super::grade::Grade;
use super::random::random;
use super::stand::{Stand, StandError};
use super::study::Study;
use crate::flaws::listed;
use cases::STRETCH;
use tertius_config::design;
use tertius_config::settings::Settings;
use tertius_core::monitor::MonitorDesign;
use tertius_machine::inject::Wanted;
use trial::{Drawn, Machines};

/// First stream of random numbers, apart from those of all other jobs.
const STREAMS: u64 = 13 << 41;
const NUMBERS: u64 = 1 << 20;

/// The studies of the last transducers: once the other one is out, and where there is no other one.
const LAST: StudyName = StudyName::slow(
    "last",
    "Faults of the transducer that is left after the other one was lost, froze or stepped by 10 mm",
);
const SINGLE: StudyName = StudyName::slow("single", "The same on cylinders that have no C2");

/// What is tried on which machines.
#[derive(Clone, Debug, PartialEq)]
pub struct LastStudy {
    pub groups: Vec<LastGroup>,
    pub faults: Vec<Option<Wanted>>,
    /// Significant wave height, m, and peak period, s; the seas take turns.
    pub seas: Vec<[f64; 2]>,
    /// Faults of each kind, rounded up to whole machines.
    pub trials: u32,
    /// Hours of a machine of each grade with each outage, rounded up to whole stretches.
    pub hours: f64,
    pub seed: u64,
    /// Number of cylinders that are monitored.
    pub cylinders: u8,
}

/// One simulated machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LastJob {
    /// A machine of that group, with every outage and every fault one after another from the same beginning.
    Faulty { group: usize, number: u32 },
    /// A machine with that outage of its group.
    Quiet { group: usize, outage: usize, number: u32 },
}

impl Study for LastStudy {
    const NAMES: &'static [StudyName] = &[LAST, SINGLE];
    type Job = LastJob;
    /// The configuration without C2, and its monitor.
    type Taught = (Settings, MonitorDesign);
    type Product = LastProduct;
    type Gathered = LastGathered;
    type Figures = LastResult;

    fn planned(seed: u64, extent: &Extent) -> Option<Self> {
        let asked = [(LAST, false), (SINGLE, true)];
        let asked = asked.into_iter().filter(|(study, _)| extent.asks(*study));
        let groups = asked.flat_map(|(_, single)| {
            Grade::ALL.into_iter().flat_map(move |grade| {
                [false, true].map(|in_loop| LastGroup { grade, in_loop, single })
            })
        });
        let groups: Vec<LastGroup> = groups.collect();
        (!groups.is_empty()).then(|| Self {
            groups,
            faults: FAULTS.to_vec(),
            seas: extent.seas.clone(),
            trials: extent.trials,
            hours: extent.hours,
            seed,
            cylinders: extent.cylinders,
        })
    }

    fn lessons(&self) -> usize {
        usize::from(self.groups.iter().any(|group| group.single))
    }

    fn teach(&self, stand: &Stand, _: usize) -> Result<Self::Taught, StandError> {
        let mut settings = stand.settings.clone();
        let signals = &mut settings.signals.cylinder;
        signals.c2 = None;
        signals.c2_velocity = None;
        signals.c2_status = None;
        signals.c2_counter = None;
        for cylinder in &mut settings.cylinder {
            cylinder.sequential = None;
            if let Some(process) = &mut cylinder.process {
                (process.flow, process.friction) = (None, None);
            }
        }
        let design = design::judging(&settings, stand.database);
        let design = design
            .map_err(|flaws| StandError::Untaught(format!("without C2: {}", listed(&flaws))))?;
        Ok((settings, design))
    }

    fn jobs(&self) -> Vec<LastJob> {
        let machines = self.trials.div_ceil(u32::from((self.cylinders / 2).max(1)));
        let stretches = (self.hours * 3600.0 / STRETCH).ceil() as u32;
        let groups = || self.groups.iter().enumerate();
        let faulty = groups().flat_map(|(group, _)| {
            (0..machines).map(move |number| LastJob::Faulty { group, number })
        });
        let quiet = groups().filter(|(_, it)| !it.in_loop).flat_map(|(group, it)| {
            (0..it.outages().len()).flat_map(move |outage| {
                (0..stretches).map(move |number| LastJob::Quiet { group, outage, number })
            })
        });
        faulty.chain(quiet).collect()
    }

    fn run(
        &self,
        stand: &Stand,
        taught: &[Self::Taught],
        job: LastJob,
    ) -> Result<LastProduct, StandError> {
        // All outages and faults are tried on the same machines at the same times.
        let drawn = |group: &LastGroup, first: u64, number: u32| {
            let mut rng = random(self.seed, first + u64::from(number));
            let sea = self.seas[number as usize % self.seas.len()];
            Drawn::new(group, number, self.cylinders, sea, &mut rng)
        };
        Ok(match job {
            LastJob::Faulty { group: index, number } => {
                let group = &self.groups[index];
                let machines = Machines::new(stand, group, taught.first())?;
                let drawn = drawn(group, STREAMS, number);
                let outcomes = machines.left_with(&self.faults, &drawn)?;
                LastProduct::Faulty { group: index, number, outcomes }
            }
            LastJob::Quiet { group: index, outage, number } => {
                let group = &self.groups[index];
                let machines = Machines::new(stand, group, taught.first())?;
                let drawn = drawn(group, STREAMS + NUMBERS, number);
                let quiet = machines.left_alone(group.outages()[outage], &drawn)?;
                LastProduct::Quiet { group: index, outage, quiet }
            }
        })
    }

    fn gather(&self, _: &Stand, gathered: &mut LastGathered, product: LastProduct) {
        gathered.add(product);
    }

    fn figures(&self, stand: &Stand, _: &[Self::Taught], gathered: LastGathered) -> LastResult {
        gathered.result(&self.groups, &self.faults, stand.settings.machine.sample_time)
    }
}
