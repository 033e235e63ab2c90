//! The last transducer of a cylinder: whether its faults are found once the other one is out, or where there is no C2.
//!
//! The other transducer is lost, frozen or off by a step. Ten seconds later the last one has a fault. Each fault is
//! tried beside the controller's loop and in it. The controller reads C1, so in the loop C2 is always the one that is
//! out. Only every second cylinder of a machine has faults, because the monitor may attribute what most cylinders show
//! together to something that they share.

mod figures;
mod outcome;
#[cfg(test)]
mod tests;
mod trial;

pub use figures::{LastFigures, LastGathering, LastHours, LastResult};
pub use outcome::{LastOutcome, LastQuiet};

use super::grade::Grade;
use super::plan::Extent;
use super::row::{SIGMA, Study};
use super::stand::{Stand, StandError};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use tertius_config::design;
use tertius_config::settings::Settings;
use tertius_core::monitor::MonitorDesign;
use tertius_machine::inject::{Shape, Wanted};
use trial::Drawn;

/// An estimate is wrong when it is off by more of its own standard deviations than this.
pub(super) const WRONG: f64 = 3.0;

/// Why a cylinder has one transducer left: the state of the other one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outage {
    /// No frame of it arrives.
    Lost,
    Frozen,
    /// It is off by 10 mm.
    Stepped,
    /// The cylinder has no C2.
    Absent,
}

/// Step of the other transducer, m.
const OFF: f64 = 0.01;

impl Outage {
    pub const fn name(self) -> &'static str {
        match self {
            Self::Lost => "lost",
            Self::Frozen => "frozen",
            Self::Stepped => "10 mm off",
            Self::Absent => "absent",
        }
    }

    /// The fault of the other transducer; `None`: it does not exist.
    const fn shape(self) -> Option<Shape> {
        match self {
            Self::Lost => Some(Shape::Loss { probability: 1.0 }),
            Self::Frozen => Some(Shape::Freeze),
            Self::Stepped => Some(Shape::Step { size: OFF }),
            Self::Absent => None,
        }
    }
}

/// Faults of the last transducer; `None` is no fault and shows what is found by chance.
pub const FAULTS: [Option<Wanted>; 16] = {
    const fn of(shape: Shape) -> Option<Wanted> {
        Some(Wanted::Shape(shape))
    }
    [
        of(Shape::Step { size: 1.25e-3 }),
        of(Shape::Step { size: 2.5e-3 }),
        of(Shape::Step { size: 0.01 }),
        of(Shape::Step { size: 0.06 }),
        of(Shape::Noise { size: 2.0 * SIGMA }),
        of(Shape::Noise { size: 6.0 * SIGMA }),
        of(Shape::Incipient { size: 0.07, b: 1.0 }),
        of(Shape::Drift { rate: 1e-3 }),
        of(Shape::Drift { rate: 0.01 }),
        of(Shape::Drift { rate: 0.1 }),
        of(Shape::Scale { gain: 0.01 }),
        of(Shape::Freeze),
        of(Shape::Loss { probability: 1.0 }),
        Some(Wanted::OutOfRange(None)),
        Some(Wanted::BrokenWire(None)),
        None,
    ]
};

/// Machines on which the same faults are tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LastGroup {
    pub grade: Grade,
    /// The controller reads the faults of C1.
    pub in_loop: bool,
    /// The cylinders have no C2.
    pub single: bool,
}

impl LastGroup {
    /// The outages that are tried.
    pub const fn outages(&self) -> &'static [Outage] {
        if self.single {
            &[Outage::Absent]
        } else {
            &[Outage::Lost, Outage::Frozen, Outage::Stepped]
        }
    }
}

/// How long one machine without a fault of the last transducer is watched, s.
const STRETCH: f64 = 600.0;

/// First stream of random numbers, apart from those of all other jobs.
const STREAMS: u64 = 13 << 41;
const NUMBERS: u64 = 1 << 20;

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

/// Result of a job.
#[derive(Clone, Debug, PartialEq)]
pub enum LastProduct {
    /// By outage and fault.
    Faulty(Vec<Vec<LastOutcome>>),
    Quiet(LastQuiet),
}

impl LastStudy {
    /// The studies that `extent` asks for.
    pub fn new(seed: u64, extent: &Extent) -> Self {
        let asked = [(Study::Last, false), (Study::Single, true)];
        let asked = asked.into_iter().filter(|(study, _)| extent.studies.contains(study));
        let groups = asked.flat_map(|(_, single)| {
            Grade::ALL.into_iter().flat_map(move |grade| {
                [false, true].map(|in_loop| LastGroup { grade, in_loop, single })
            })
        });
        Self {
            groups: groups.collect(),
            faults: FAULTS.to_vec(),
            seas: extent.seas.clone(),
            trials: extent.trials,
            hours: extent.last_hours,
            seed,
            cylinders: extent.cylinders,
        }
    }

    /// All jobs, the longest first.
    pub fn jobs(&self) -> Vec<LastJob> {
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

    /// The configuration of `stand` without C2, and its monitor; `None` where it is not asked for.
    ///
    /// # Errors
    /// The monitor cannot be without C2.
    pub fn without_c2(
        &self,
        stand: &Stand,
    ) -> Result<Option<(Settings, MonitorDesign)>, StandError> {
        if !self.groups.iter().any(|group| group.single) {
            return Ok(None);
        }
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
        let design = design::judging(&settings, stand.database).map_err(|flaws| {
            let told: Vec<String> =
                flaws.iter().map(|flaw| format!("{}: {}", flaw.key, flaw.message)).collect();
            StandError::Untaught(format!("without C2: {}", told.join("; ")))
        })?;
        Ok(Some((settings, design)))
    }

    /// Does one job on `stand`.
    ///
    /// # Errors
    /// There is no such machine, or no place for such a fault on it.
    pub fn run(&self, stand: &Stand, job: LastJob) -> Result<LastProduct, StandError> {
        let (LastJob::Faulty { group, number } | LastJob::Quiet { group, number, .. }) = job;
        let group = &self.groups[group];
        // All outages and faults are tried on the same machines at the same times.
        let first = match job {
            LastJob::Faulty { .. } => STREAMS,
            LastJob::Quiet { .. } => STREAMS + NUMBERS,
        };
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(first + u64::from(number));
        let sea = self.seas[number as usize % self.seas.len()];
        let drawn = Drawn::new(group, number, self.cylinders, sea, &mut rng);
        Ok(match job {
            LastJob::Faulty { .. } => {
                LastProduct::Faulty(stand.left_with(group, &self.faults, &drawn)?)
            }
            LastJob::Quiet { outage, .. } => {
                LastProduct::Quiet(stand.left_alone(group, group.outages()[outage], &drawn)?)
            }
        })
    }
}
