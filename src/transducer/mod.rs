//! The position transducers C1 and C2: what they make of a length.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::Deserialize;

/// Cylinders, each with two transducers.
pub const CYLINDERS: usize = 6;

/// What all transducers have in common.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Common {
    /// Standard deviation of a length, m.
    pub noise: f64,
    /// Now and then the readings are off by this much for a while, up or down, m: Figure 5-9.
    pub fluctuation: f64,
    /// Of a reading to be the first of such a while.
    pub fluctuation_probability: f64,
    /// How long it lasts, s.
    pub fluctuation_time: f64,
    /// Standard deviation of a speed, m/s.
    pub speed_noise: f64,
    /// Counts over the whole range: 27648 in (5-3).
    pub counts: f64,
    /// The range that the counts cover, m.
    pub range: [f64; 2],
}

/// The counts of a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// The length of count 0, m.
    low: f64,
    /// m in a count.
    count: f64,
}

impl Grid {
    /// The length of the count that is nearest to `length`, m.
    pub fn nearest(&self, length: f64) -> f64 {
        ((length - self.low) / self.count).round() * self.count + self.low
    }
}

impl Common {
    /// What a length is rounded to.
    pub fn grid(&self) -> Grid {
        let [low, high] = self.range;
        Grid { low, count: (high - low) / self.counts }
    }
}

/// The errors of six transducers, in the order of the cylinders.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Errors {
    /// m at the middle of the stroke.
    pub offset: [f64; CYLINDERS],
    /// m per m.
    pub gain: [f64; CYLINDERS],
    /// What no straight line takes away, m per m².
    pub bow: [f64; CYLINDERS],
    /// How long after Sync it samples, s.
    pub skew: [f64; CYLINDERS],
}

/// One transducer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transducer {
    common: Common,
    offset: f64,
    gain: f64,
    bow: f64,
    skew: f64,
    /// Readings that a fluctuation lasts.
    lasting: u32,
    /// Readings that are left of the present one, and what it adds, m.
    left: u32,
    shift: f64,
}

/// What a transducer says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// m.
    pub length: f64,
    /// The same before it was rounded to counts, m.
    pub unrounded: f64,
    /// m/s.
    pub speed: f64,
}

impl Transducer {
    /// The transducer of that cylinder, from 0, which is read every `sample_time` seconds.
    pub fn new(common: &Common, errors: &Errors, cylinder: usize, sample_time: f64) -> Self {
        Self {
            common: *common,
            offset: errors.offset[cylinder],
            gain: errors.gain[cylinder],
            bow: errors.bow[cylinder],
            skew: errors.skew[cylinder],
            lasting: ((common.fluctuation_time / sample_time).round() as u32).max(1),
            left: 0,
            shift: 0.0,
        }
    }

    /// Reads a piston that is at `length`, m, at Sync and moves at `speed`, m/s; `late` s later than
    /// it usually does, and off by `counts`.
    pub fn read(
        &mut self,
        [length, speed]: [f64; 2],
        [late, counts]: [f64; 2],
        rng: &mut ChaCha8Rng,
    ) -> Reading {
        let [length_noise, speed_noise]: [f64; 2] = [(); 2].map(|()| StandardNormal.sample(rng));
        let true_length = length + speed * (self.skew + late);
        let noise = self.common.noise * length_noise + self.fluctuation(rng);
        let unrounded = self.calibrated(true_length) + noise + counts * self.common.grid().count;
        Reading {
            length: self.quantised(unrounded),
            unrounded,
            speed: speed * (1.0 + self.gain) + self.common.speed_noise * speed_noise,
        }
    }

    /// What the present fluctuation adds, m; 0 between two.
    fn fluctuation(&mut self, rng: &mut ChaCha8Rng) -> f64 {
        if self.left > 0 {
            self.left -= 1;
            return self.shift;
        }
        if rng.random::<f64>() < self.common.fluctuation_probability {
            let up = rng.random::<bool>();
            self.shift = if up { self.common.fluctuation } else { -self.common.fluctuation };
            self.left = self.lasting - 1;
            return self.shift;
        }
        0.0
    }

    /// What the calibration makes of a true length, m.
    pub fn calibrated(&self, length: f64) -> f64 {
        length + self.offset + (self.gain + self.bow * length) * length
    }

    /// (5-3), counts 1 to the highest: 0 is no signal.
    fn quantised(&self, length: f64) -> f64 {
        let Grid { low, count } = self.common.grid();
        let lengths = [low + count, low + self.common.counts * count];
        self.common.grid().nearest(length.clamp(lengths[0], lengths[1]))
    }
}
