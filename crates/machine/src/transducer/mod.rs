//! The position transducers C1 and C2: their readings of a length.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::Deserialize;
use std::f64::consts::TAU;

/// Cylinders, each with two transducers.
pub const CYLINDERS: usize = 6;

/// Properties that all transducers share.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Common {
    /// Standard deviation of a length, m.
    pub noise: f64,
    /// Offset of the readings for a while now and then, up or down, m: Figure 5-9.
    pub fluctuation: f64,
    /// Probability that such a fluctuation begins with a reading.
    pub fluctuation_probability: f64,
    /// Duration of a fluctuation, s.
    pub fluctuation_time: f64,
    /// Part by which the offset of one fluctuation is larger or smaller, equally likely; default 0.
    #[serde(default)]
    pub fluctuation_spread: f64,
    /// The same of its duration; default 0.
    #[serde(default)]
    pub fluctuation_time_spread: f64,
    /// Standard deviation of a speed, m/s.
    pub speed_noise: f64,
    /// Time constant with which a speed lags, as by a filter of the first order, s; default 0.
    #[serde(default)]
    pub speed_lag: f64,
    /// Number of counts over the whole range: 27648 in (5-3).
    pub counts: f64,
    /// Range that the counts cover, m.
    pub range: [f64; 2],
}

/// Grid of a transducer's counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Length of count 0, m.
    low: f64,
    /// Length of one count, m.
    count: f64,
}

impl Grid {
    /// The length of the count that is nearest to `length`, m.
    pub fn nearest(&self, length: f64) -> f64 {
        ((length - self.low) / self.count).round() * self.count + self.low
    }
}

impl Common {
    /// The grid that a length is rounded to.
    pub fn grid(&self) -> Grid {
        let [low, high] = self.range;
        Grid { low, count: (high - low) / self.counts }
    }
}

/// The errors of six transducers, in the order of the cylinders.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Errors {
    /// Offset at the middle of the stroke, m.
    pub offset: [f64; CYLINDERS],
    /// Gain error, m per m.
    pub gain: [f64; CYLINDERS],
    /// Quadratic error, which no straight line removes, m per m².
    pub bow: [f64; CYLINDERS],
    /// Delay of the sample after Sync, s.
    pub skew: [f64; CYLINDERS],
    /// Periodic error along the stroke; default none.
    #[serde(default)]
    pub ripple: Ripple,
    /// Drift with the temperature; default none.
    #[serde(default)]
    pub warming: Warming,
}

/// Periodic error that the transducer's own linearisation leaves along the stroke: two harmonics.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ripple {
    /// Amplitudes of the two harmonics, m.
    pub amplitudes: [[f64; 2]; CYLINDERS],
    /// Wavelengths of the two harmonics, m.
    pub lengths: [f64; 2],
    /// Phase of both harmonics in the middle of the stroke, rad.
    pub phases: [f64; CYLINDERS],
}

/// An offset that rises and falls with the temperature.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Warming {
    /// Amplitudes of the offset, m.
    pub amplitudes: [f64; CYLINDERS],
    /// Period of one rise and fall, s.
    pub period: f64,
}

impl Ripple {
    fn at(&self, cylinder: usize, length: f64) -> f64 {
        let harmonics = self.amplitudes[cylinder].iter().zip(self.lengths);
        harmonics
            .filter(|(amplitude, _)| **amplitude != 0.0)
            .map(|(amplitude, wave)| {
                amplitude * (length * TAU / wave + self.phases[cylinder]).sin()
            })
            .sum()
    }
}

impl Warming {
    fn at(&self, cylinder: usize, time: f64) -> f64 {
        match self.amplitudes[cylinder] {
            0.0 => 0.0,
            amplitude => amplitude * (time * TAU / self.period).sin(),
        }
    }
}

/// One transducer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transducer {
    common: Common,
    errors: Errors,
    /// Cylinder index, from 0.
    cylinder: usize,
    /// Number of readings that a fluctuation lasts.
    lasting: u32,
    /// Number of readings left of the present fluctuation.
    left: u32,
    /// Offset of the present fluctuation, m.
    shift: f64,
    /// Part of a change of speed that appears in one reading.
    following: f64,
    /// Speed that has appeared in the readings so far, m/s; `None` before the first.
    followed: Option<f64>,
}

/// A factor that is larger or smaller than one by at most this `part`; without one nothing is drawn.
fn spread(part: f64, rng: &mut ChaCha8Rng) -> f64 {
    if part > 0.0 { 1.0 + part * rng.random_range(-1.0..=1.0) } else { 1.0 }
}

/// Reading of a transducer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// Length, m.
    pub length: f64,
    /// Length before it was rounded to counts, m.
    pub unrounded: f64,
    /// Speed, m/s.
    pub speed: f64,
}

impl Transducer {
    /// The transducer of cylinder `cylinder`, from 0, which is read every `sample_time` seconds.
    pub fn new(common: &Common, errors: &Errors, cylinder: usize, sample_time: f64) -> Self {
        Self {
            common: *common,
            errors: *errors,
            cylinder,
            lasting: ((common.fluctuation_time / sample_time).round() as u32).max(1),
            left: 0,
            shift: 0.0,
            following: sample_time / (sample_time + common.speed_lag),
            followed: None,
        }
    }

    /// Reads at `time`, s, a piston that is at `length`, m, at Sync and moves at `speed`, m/s; the
    /// sample is `late` s later than usual, and off by `counts`.
    pub fn read(
        &mut self,
        time: f64,
        [length, speed]: [f64; 2],
        [late, counts]: [f64; 2],
        rng: &mut ChaCha8Rng,
    ) -> Reading {
        let [length_noise, speed_noise]: [f64; 2] = [(); 2].map(|()| StandardNormal.sample(rng));
        let true_length = length + speed * (self.errors.skew[self.cylinder] + late);
        let noise = self.common.noise * length_noise + self.fluctuation(rng);
        let unrounded =
            self.calibrated(time, true_length) + noise + counts * self.common.grid().count;
        let speed = self.lagging(speed);
        Reading {
            length: self.quantised(unrounded),
            unrounded,
            speed: speed * (1.0 + self.errors.gain[self.cylinder])
                + self.common.speed_noise * speed_noise,
        }
    }

    /// The speed as far as the lag lets it through, m/s.
    fn lagging(&mut self, speed: f64) -> f64 {
        if self.common.speed_lag == 0.0 {
            return speed;
        }
        let before = self.followed.unwrap_or(speed);
        let followed = before + self.following * (speed - before);
        self.followed = Some(followed);
        followed
    }

    /// Offset of the present fluctuation, m; 0 between two.
    fn fluctuation(&mut self, rng: &mut ChaCha8Rng) -> f64 {
        if self.left > 0 {
            self.left -= 1;
            return self.shift;
        }
        if rng.random::<f64>() < self.common.fluctuation_probability {
            let up = rng.random::<bool>();
            let Common { fluctuation, fluctuation_spread, fluctuation_time_spread, .. } =
                self.common;
            let size = fluctuation * spread(fluctuation_spread, rng);
            self.shift = if up { size } else { -size };
            let lasting = f64::from(self.lasting) * spread(fluctuation_time_spread, rng);
            self.left = (lasting.round() as u32).saturating_sub(1);
            return self.shift;
        }
        0.0
    }

    /// The reading of a true length, m, at `time`, s, without noise and rounding, m.
    pub fn calibrated(&self, time: f64, length: f64) -> f64 {
        let (errors, i) = (&self.errors, self.cylinder);
        let (ripple, warming) = (errors.ripple.at(i, length), errors.warming.at(i, time));
        let straight =
            length + errors.offset[i] + (errors.gain[i] + errors.bow[i] * length) * length;
        straight + ripple + warming
    }

    /// The length rounded to counts (5-3), from 1 to the highest: 0 means no signal.
    fn quantised(&self, length: f64) -> f64 {
        let Grid { low, count } = self.common.grid();
        let lengths = [low + count, low + self.common.counts * count];
        self.common.grid().nearest(length.clamp(lengths[0], lengths[1]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    const QUIET: Common = Common {
        noise: 0.0,
        fluctuation: 0.0,
        fluctuation_probability: 0.0,
        fluctuation_time: 0.2,
        fluctuation_spread: 0.0,
        fluctuation_time_spread: 0.0,
        speed_noise: 0.0,
        speed_lag: 0.0,
        counts: 27648.0,
        range: [-1.5, 1.5],
    };

    /// A transducer without errors.
    fn exact() -> Errors {
        Errors {
            offset: [0.0; CYLINDERS],
            gain: [0.0; CYLINDERS],
            bow: [0.0; CYLINDERS],
            skew: [0.0; CYLINDERS],
            ripple: Ripple::default(),
            warming: Warming::default(),
        }
    }

    /// A fluctuation of four counts for ten readings, each of them by up to a half more or less.
    #[test]
    fn fluctuations_are_of_uneven_size_and_length() {
        let common = Common {
            fluctuation: 4.34e-4,
            fluctuation_probability: 0.01,
            fluctuation_spread: 0.5,
            fluctuation_time_spread: 0.5,
            ..QUIET
        };
        let errors = exact();
        let mut transducer = Transducer::new(&common, &errors, 0, 0.02);
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let (mut sizes, mut lengths, mut lasting) = (Vec::new(), Vec::new(), 0_u32);
        let mut before = 0.0;
        for _ in 0..50_000 {
            let shift = transducer.fluctuation(&mut rng);
            if shift != before && lasting > 0 {
                sizes.push(f64::abs(before));
                lengths.push(lasting);
            }
            lasting = if shift == 0.0 {
                0
            } else if shift == before {
                lasting + 1
            } else {
                1
            };
            before = shift;
        }
        let ends = |low: f64, high: f64, values: &[f64]| {
            let [least, most] = [f64::min, f64::max].map(|of| values.iter().copied().reduce(of));
            least.is_some_and(|it| (low..1.1 * low).contains(&it))
                && most.is_some_and(|it| (0.9 * high..=high).contains(&it))
        };
        assert!(sizes.len() > 300 && ends(2.17e-4, 6.51e-4, &sizes), "{}", sizes.len());
        let lengths: Vec<f64> = lengths.into_iter().map(f64::from).collect();
        assert!(ends(5.0, 15.0, &lengths));
    }

    #[test]
    fn ripple_and_warming_are_in_the_length_that_is_read() {
        let straight = Errors {
            offset: [0.001; CYLINDERS],
            gain: [0.0; CYLINDERS],
            bow: [0.0; CYLINDERS],
            skew: [0.0; CYLINDERS],
            ripple: Ripple::default(),
            warming: Warming::default(),
        };
        let mut amplitudes = [[0.0; 2]; CYLINDERS];
        amplitudes[2] = [2e-4, 1e-4];
        let ripple = Ripple { amplitudes, lengths: [0.8, 0.2], phases: [0.5; CYLINDERS] };
        let mut warm = [0.0; CYLINDERS];
        warm[2] = 3e-4;
        let warming = Warming { amplitudes: warm, period: 400.0 };
        let rippled = Errors { ripple, warming, ..straight };
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut read = |errors: &Errors, cylinder: usize, time: f64, length: f64| {
            let mut transducer = Transducer::new(&QUIET, errors, cylinder, 0.02);
            transducer.read(time, [length, 0.0], [0.0; 2], &mut rng).unrounded
        };
        // A quarter of the long wave is one whole short one.
        for (time, length) in [(0.0, 0.0), (100.0, 0.2), (300.0, -0.7)] {
            let expected = 2e-4 * (length * TAU / 0.8 + 0.5).sin()
                + 1e-4 * (length * TAU / 0.2 + 0.5).sin()
                + 3e-4 * (time * TAU / 400.0_f64).sin();
            let difference = read(&rippled, 2, time, length) - read(&straight, 2, time, length);
            assert!((difference - expected).abs() < 1e-15, "{difference} {expected}");
            assert_eq!(read(&rippled, 1, time, length), read(&straight, 1, time, length));
        }
    }

    /// A filter of the first order is late on a ramp by its time, and a cycle's share of it.
    #[test]
    fn a_speed_lags_behind_by_its_time() {
        let errors = exact();
        let common = Common { speed_lag: 0.06, ..QUIET };
        let mut transducer = Transducer::new(&common, &errors, 0, 0.02);
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut at = |k: u32| {
            let speed = 0.1 + 0.5 * 0.02 * f64::from(k);
            let reading = transducer.read(0.0, [0.0, speed], [0.0; 2], &mut rng);
            (reading.speed, speed)
        };
        assert_eq!(at(0).0, 0.1, "it has stood at the first speed for ever");
        let (read, speed) = (1..200).map(&mut at).last().expect("there are some");
        assert!((read - (speed - 0.5 * 0.06)).abs() < 1e-9, "{read} {speed}");
    }
}
