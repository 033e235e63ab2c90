//! The commissionings of a census.

use serde::{Deserialize, Serialize};

/// Number of machines, half of them fine, of which two thirds fluctuate, and half coarse.
pub const MACHINES: usize = 24;

/// Lengths of the recordings, s.
const LENGTHS: [f64; 3] = [900.0, 3600.0, 10_800.0];

/// One more commissioning with a fault in its recording for each group of this many sound ones.
const ONE_FAULTY_FOR: usize = 8;

/// One machine of this many in a grade has a configuration which states that its bus has no spikes,
/// which is true of it.
const FREE_OF: usize = 4;

/// What the transducers of a machine are like.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Transducers {
    /// Fine, and now and then four counts off for 0.2 s, as Figure 5-9 has it.
    Fluctuating,
    /// The same by two to six counts, for 0.02 to 0.38 s.
    Uneven,
    /// Fine, and never off.
    Steady,
    Coarse,
}

impl Transducers {
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fluctuating => "fluctuating",
            Self::Uneven => "fluctuating unevenly",
            Self::Steady => "steady",
            Self::Coarse => "coarse",
        }
    }
}

/// A mishap in a recording that is no fault of a transducer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mishap {
    None,
    /// 0.5 % of the samples of every transducer are 0.43 mm off.
    Spikes,
    /// 0.5 % of the cycles are lost.
    Losses,
    /// The machine comes to rest for a minute.
    Stop,
}

const MISHAPS: [Mishap; 4] = [Mishap::None, Mishap::Spikes, Mishap::Losses, Mishap::Stop];

/// A fault of one transducer in the recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Spoilt {
    /// 0.5 mm for 10 s.
    Step,
    /// Noise of 0.87 mm for 20 s.
    Noise,
    /// 20 mm for 1 s.
    Jump,
    /// 0.5 mm from three tenths of the recording to its middle.
    Stays,
}

impl Spoilt {
    pub const fn words(self) -> &'static str {
        match self {
            Self::Step => "0.5 mm for 10 s",
            Self::Noise => "noise of 0.87 mm for 20 s",
            Self::Jump => "20 mm for 1 s",
            Self::Stays => "0.5 mm for a fifth of the recording",
        }
    }
}

const SPOILT: [Spoilt; 4] = [Spoilt::Step, Spoilt::Noise, Spoilt::Jump, Spoilt::Stays];

/// One commissioning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Task {
    pub number: usize,
    /// Seed of the census.
    pub seed: u64,
    /// Machine index, from 0.
    pub machine: usize,
    /// Length of the recording, s.
    pub length: f64,
    /// Number of the pair: both orders of the same files share it.
    pub pair: usize,
    pub calm_first: bool,
    pub mishap: Mishap,
    /// The configuration states that its bus has no spikes.
    pub stated_free: bool,
    pub spoilt: Option<Spoilt>,
}

impl Task {
    /// Every other machine has coarse transducers.
    pub const fn transducers(&self) -> Transducers {
        match (self.machine % 2, self.machine / 2 % 3) {
            (1, _) => Transducers::Coarse,
            (_, 0) => Transducers::Fluctuating,
            (_, 1) => Transducers::Uneven,
            _ => Transducers::Steady,
        }
    }

    pub fn is_coarse(&self) -> bool {
        self.transducers() == Transducers::Coarse
    }
}

#[derive(Clone, Debug)]
pub struct Plan {
    pub tasks: Vec<Task>,
}

impl Plan {
    /// The given number of sound commissionings, with both orders of the same files next to each
    /// other, and some with a fault; no recording is longer than `longest`, s.
    pub fn new(commissionings: usize, seed: u64, longest: f64) -> Self {
        let lengths: Vec<f64> = LENGTHS.into_iter().filter(|it| *it <= longest).collect();
        let lengths = if lengths.is_empty() { vec![longest] } else { lengths };
        let task = |number: usize, pair: usize, spoilt: Option<Spoilt>| {
            let (machine, round) = (pair % MACHINES, pair / MACHINES);
            // Every machine meets other lengths and mishaps in each round.
            let length = lengths[(round + machine / 2) % lengths.len()];
            let sound = MISHAPS[(round + machine / 2 / lengths.len()) % MISHAPS.len()];
            let mishap = if spoilt.is_some() { Mishap::None } else { sound };
            let calm_first = number.is_multiple_of(2);
            let stated_free = machine / 2 % FREE_OF == FREE_OF - 1 && mishap != Mishap::Spikes;
            Task { number, seed, machine, length, pair, calm_first, mishap, stated_free, spoilt }
        };
        let sound = (0..commissionings).map(|number| task(number, number / 2, None));
        let faulty = (0..commissionings / ONE_FAULTY_FOR).map(|index| {
            let spoilt = Some(SPOILT[index % SPOILT.len()]);
            task(commissionings + index, commissionings + index, spoilt)
        });
        Self { tasks: sound.chain(faulty).collect() }
    }
}
