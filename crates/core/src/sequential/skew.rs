//! Time between the samples of C1 and C2 at present, from the residuals of one cylinder, to which
//! it contributes in proportion to the velocity.

use super::noise::Noise;
use super::parameters::SamplingParameters;
use crate::state::state;

const P: &SamplingParameters = &SamplingParameters::DEFAULT;

/// How many time constants there are.
const TIMES: usize = P.times.len();

/// Observation over some seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// Growth of C1 − C2 with the velocity beyond the calibrated one, s: C2 is sampled sooner by
    /// this time.
    pub mean: f64,
    /// Largest variance of `mean`, s².
    pub mean_variance: f64,
    /// Mean square of the random part of the time between both samples, s².
    pub square: f64,
    /// Largest variance of `square`, s⁴.
    pub square_variance: f64,
}

/// Sums over the newest samples of a cylinder, with fading weights.
#[derive(Clone, Debug)]
pub struct Skew {
    known: f64,
    /// Part of each sum that remains after another sample.
    keep: [f64; TIMES],
    sums: [[f64; TIMES]; SUMS],
}

state! {
    Skew { sums }
    but { known, keep }
}

/// Of v², of v⁴, of v e, of v² times what e² is beyond the noise at rest, and of the variances of these
/// two.
const SUMS: usize = 6;

impl Skew {
    /// Sums of samples every `sample_time` seconds, for a calibration with the timing `known`, s.
    pub fn new(sample_time: f64, known: f64) -> Self {
        let keep = P.times.map(|time| libm::exp(-sample_time / time));
        Self { known, keep, sums: [[0.0; TIMES]; SUMS] }
    }

    /// Forgets the sums after the bus was lost, since the devices may have restarted.
    pub const fn reset(&mut self) {
        self.sums = [[0.0; TIMES]; SUMS];
    }

    /// Takes a residual by the calibration, m, at a `velocity`, m/s; `noise` and `mean`, s, are the
    /// present estimates.
    #[inline]
    pub fn take(&mut self, residual: f64, velocity: f64, noise: &Noise, mean: f64) {
        let square = velocity * velocity;
        let variance = noise.variance(velocity);
        let left = residual - mean * velocity;
        if left * left > P.wild * variance {
            return;
        }
        let (all, most) = (left * left, P.clip * variance);
        let clipped = if all < most { all } else { most } * (1.0 / P.clipped);
        let excess = clipped - noise.rest * noise.rest;
        let fourth = square * square;
        let values = [
            square,
            fourth,
            velocity * residual,
            square * excess,
            square * variance,
            fourth * (variance * variance),
        ];
        for (sums, value) in self.sums.iter_mut().zip(values) {
            let [fast, slow] = *sums;
            *sums = [fast * self.keep[0] + value, slow * self.keep[1] + value];
        }
    }

    /// Observations of the newest half second, and of the newest half minute.
    pub fn seen(&self) -> [Seen; 2] {
        let [squares, fourths, products, excesses, variances, others] = self.sums;
        let (samples, speed) = (P.prior_samples, P.prior_speed);
        let square = speed * speed;
        let few = [samples * speed * speed, samples * (square * square)];
        let known = few[1] * self.known * self.known;
        [0, 1].map(|i: usize| {
            let [by_square, by_fourth] = [1.0 / (squares[i] + few[0]), 1.0 / (fourths[i] + few[1])];
            Seen {
                mean: products[i] * by_square,
                mean_variance: variances[i] * (by_square * by_square),
                square: (excesses[i] + known) * by_fourth,
                square_variance: 2.0 * others[i] * (by_fourth * by_fourth),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const NOISE: Noise = Noise { rest: 8e-5, timing: 2e-4 };

    /// Observations after `seconds` of a rod that moves up and down, sampled with this skew and
    /// jitter, s; one sample in `wild` is wild.
    fn after(seconds: f64, skew: f64, jitter: f64, wild: usize) -> [Seen; 2] {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let mut it = Skew::new(0.02, 0.0);
        for k in 0..(seconds / 0.02) as usize {
            let velocity = 0.4 * (0.016 * k as f64).cos();
            let apart = velocity * (skew + jitter * normal());
            let wild = if k % wild == 7 { 4e-4 } else { 0.0 };
            it.take(NOISE.rest * normal() + apart + wild, velocity, &NOISE, 0.0);
        }
        it.seen()
    }

    #[test]
    fn skew_and_jitter_are_seen_for_what_they_are() {
        let [_, slow] = after(60.0, 0.0, 4e-4, usize::MAX);
        assert!((slow.square.sqrt() - 4e-4).abs() < 1e-4 && slow.mean.abs() < 3e-5, "{slow:?}");
        let [fast, slow] = after(60.0, -3e-4, 0.0, usize::MAX);
        assert!((fast.mean + 3e-4).abs() < 1e-4 && (slow.mean + 3e-4).abs() < 3e-5, "{slow:?}");
        assert!(slow.mean_variance.sqrt() < 2e-5, "{slow:?}");
        let [fast, slow] = after(1.0, 0.0, 5e-4, usize::MAX);
        assert!(fast.square > 9e-8 && slow.square > 4e-8, "{fast:?} {slow:?}");
    }

    #[test]
    fn wild_samples_are_hardly_taken_for_it() {
        let [_, none] = after(60.0, 0.0, 0.0, usize::MAX);
        let [_, wild] = after(60.0, 0.0, 0.0, 20);
        assert!(none.square < 1e-8, "{none:?}");
        assert!(wild.square < 2.5e-8 && wild.mean.abs() < 1e-4, "{wild:?}");
    }
}
