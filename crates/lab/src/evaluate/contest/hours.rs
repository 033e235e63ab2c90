//! What the fault-free hours show: false alarms, and how large the evidence gets.

use super::ladder::{LEVELS, Rival};
use super::quiet::{BLOCK, QuietHours};
use crate::evaluate::outcome::DETECTORS;
use crate::evaluate::rate::Rate;
use serde::Serialize;
use std::collections::BTreeMap;
use tertius_core::alarm::Detector;
use tertius_learn::extremes::{HOURS_PER_YEAR, Maxima, Tail, common_level, per_second};

const RIVALS: usize = Rival::ALL.len();

/// False alarms are counted where more blocks than this exceed a level, and extrapolated where
/// fewer do.
const MANY: u64 = 100;

/// Hours that are being added up.
#[derive(Clone, Debug)]
pub struct Adding {
    samples: u64,
    squares: u128,
    raises: [u64; DETECTORS],
    maxima: Vec<[Maxima; RIVALS]>,
    beyond: [[u64; LEVELS]; RIVALS],
}

impl Adding {
    /// None yet, of a machine of so many `cylinders`.
    pub(super) fn new(cylinders: u8) -> Self {
        // The maxima of blocks come as they are: one is a block.
        let maxima = || std::array::from_fn(|_| Maxima::new(1));
        Self {
            samples: 0,
            squares: 0,
            raises: [0; DETECTORS],
            maxima: (0..cylinders).map(|_| maxima()).collect(),
            beyond: [[0; LEVELS]; RIVALS],
        }
    }
}

/// Figures of a healthy machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Hours {
    /// Hours of one machine that the sequential detectors judged.
    pub hours: f64,
    /// Warnings of the thesis's thresholds and of the sequential detector at its level.
    pub detectors: BTreeMap<&'static str, Rate>,
    /// Standard deviation of the sequential detectors' residuals, m.
    pub deviation: f64,
    /// The largest values: |R1| or |R2|, m, |R3|, m, and evidence, nats.
    pub largest: [f64; RIVALS],
    /// False alarms a year of the sequential detector at its level, extrapolated; `None` where
    /// there were too few hours.
    pub expected: Option<f64>,
    /// The level at which one false alarm a year is expected, nats.
    pub level_of_one: Option<f64>,
    /// False alarms a year of each rival at each of its levels.
    pub false_alarms: [Vec<f64>; RIVALS],
}

impl Adding {
    pub(super) fn add(&mut self, quiet: &QuietHours) {
        self.samples += quiet.samples;
        self.squares += quiet.squares;
        for (mine, more) in self.raises.iter_mut().zip(quiet.raises) {
            *mine += more;
        }
        for (mine, more) in self.beyond.iter_mut().flatten().zip(quiet.beyond.iter().flatten()) {
            *mine += more;
        }
        for (mine, more) in self.maxima.iter_mut().flatten().zip(quiet.blocks.iter().flatten()) {
            more.iter().for_each(|largest| mine.add(*largest));
        }
    }

    /// Figures of these hours; `level` is that of the sequential detector, nats.
    pub(super) fn finish(&self, level: f64, sample_time: f64) -> Hours {
        let hours = self.samples as f64 / self.maxima.len() as f64 * sample_time / 3600.0;
        if self.samples == 0 {
            return Hours::default();
        }
        let tails: [Option<Vec<Tail>>; RIVALS] = std::array::from_fn(|rival| {
            self.maxima.iter().map(|maxima| Tail::fit(&maxima[rival], BLOCK)).collect()
        });
        let yearly = |rival: usize, level: f64| {
            let tails = tails[rival].as_ref()?;
            Some(tails.iter().map(|tail| tail.rate(level)).sum::<f64>() / per_second(1.0))
        };
        let sequential = Rival::Sequential as usize;
        let by_level = |rival: Rival| -> Vec<f64> {
            let at = |index: usize| {
                let seen = self.beyond[rival as usize][index];
                let counted = seen as f64 / hours * HOURS_PER_YEAR;
                let extrapolated = || yearly(rival as usize, rival.level(index));
                if seen > MANY { counted } else { extrapolated().unwrap_or(counted) }
            };
            (0..LEVELS).map(at).collect()
        };
        let largest = |rival: usize| {
            self.maxima.iter().map(|maxima| maxima[rival].worst()).fold(0.0, f64::max)
        };
        let raises = Detector::ALL.into_iter().zip(self.raises);
        Hours {
            hours,
            detectors: raises.map(|(it, raises)| (it.name(), Rate::new(raises, hours))).collect(),
            deviation: (self.squares as f64 * 1e-15 / self.samples as f64).sqrt(),
            largest: std::array::from_fn(largest),
            expected: yearly(sequential, level),
            level_of_one: tails[sequential].as_ref().map(|it| common_level(it, per_second(1.0))),
            false_alarms: Rival::ALL.map(by_level),
        }
    }
}
