//! Limits of runs: how long a residual may stand in a box before healthy transducers cannot be the cause.
//!
//! A healthy residual stays in a box by one excursion, by two at once, or by a chain in which the next excursion begins with
//! the very sample in which the one before ends. The joints make long chains rare, and how rare follows from the rate.

use super::law::Law;
use super::noise::{CoreNoise, Cumulative};
use super::survival::{Survival, overlapping};
use tertius_core::sequential::ExcursionLimits;
use tertius_core::sequential::excursions::{BOXES, STRAYS};

/// Lower end of the first box, m: above the smallest excursions.
const FIRST: f64 = 0.28e-3;
/// Deviations by which the first box is above the noise.
const ABOVE_NOISE: f64 = 3.3;
/// Noise for which the first box is at [`FIRST`], m: 3.3 deviations.
const USUAL_NOISE: f64 = 0.27e-3;
/// Width of a box, deviations: 3 on both sides of a step.
const WIDTH: f64 = 6.0;

/// Drift within a run, m: profile and baseline follow the rod.
const DRIFT: f64 = 0.03e-3;

/// Least share of wild samples.
const LEAST_WILD: f64 = 0.005;
/// Wild samples that are allowed for over those that were measured.
const WILD_FACTOR: f64 = 2.0;

/// Shortest and longest run that are limits, samples. A longer one is of no use beside the sums.
const LENGTHS: std::ops::RangeInclusive<usize> = 4..=250;

/// The boxes' lower and upper ends, m, for residuals of this deviation, m: a residual in a box is above the lower one and not
/// above the upper one. The last box has no upper end, and without excursions none has.
pub fn boxes(deviation: f64, excursions: bool) -> [[f64; 2]; BOXES] {
    let above = (ABOVE_NOISE * deviation - USUAL_NOISE).max(0.0);
    let width = if excursions { WIDTH * deviation } else { f64::INFINITY };
    ExcursionLimits::boxes(FIRST + above, width)
}

/// What fills a box in health.
#[derive(Clone, Debug)]
pub struct RunLimits {
    core: Cumulative,
    /// `None` where there are no excursions.
    survival: Option<Survival>,
    /// Share of wild samples that is allowed for.
    wild: f64,
}

impl RunLimits {
    /// Runs of these excursions, of a core that is not weighted, and this measured share of wild samples.
    pub fn new(law: &Law, core: &CoreNoise, wild_share: f64) -> Self {
        // One length more than the longest run, as the rate of runs of exactly this length is asked for.
        let survival = Survival::of(law, LENGTHS.end() + 1);
        let wild = (WILD_FACTOR * wild_share).clamp(LEAST_WILD, 1.0);
        Self { core: Cumulative::of(core), survival, wild }
    }

    /// The least lengths of a run in a box, samples, that healthy transducers reach less than once in e^`level` samples,
    /// without, with one and with two samples outside; `None` where no length up to 250 samples is that rare.
    pub fn limits(&self, ends: [f64; 2], level: f64) -> [Option<u16>; STRAYS] {
        let fillings = self.fillings(ends);
        let idle = self.inside(ends, 0.0);
        std::array::from_fn(|strays| limit(&fillings, idle, strays, level))
    }

    /// β: the chance that a healthy sample of this offset, m, is in the box.
    fn inside(&self, [low, high]: [f64; 2], offset: f64) -> f64 {
        let moved = offset + DRIFT;
        (1.0 - self.wild) * self.core.between(low - moved, high - moved) + 0.5 * self.wild
    }

    /// F(t): the rate a sample at which one excursion, or the overlap of two, begins to fill the box for `t` samples at least,
    /// for t from 0 (which is not used) to one more than the longest run.
    fn fillings(&self, ends: [f64; 2]) -> Vec<f64> {
        let mut rates = vec![0.0; LENGTHS.end() + 2];
        let Some(survival) = &self.survival else { return rates };
        let sizes = survival.sizes();
        let single: Vec<f64> = sizes.iter().map(|size| self.inside(ends, *size)).collect();
        let both = |(i, a): (usize, &f64)| -> Vec<f64> {
            sizes[i..].iter().map(|b| self.inside(ends, a + b)).collect()
        };
        let double: Vec<Vec<f64>> = sizes.iter().enumerate().map(both).collect();
        let (mut singles, mut doubles) = (single.clone(), double.clone());
        for (t, rate) in rates.iter_mut().enumerate().skip(1) {
            let (lasting, remaining) = (survival.lasting(t), survival.remaining(t));
            if lasting.is_empty() {
                break;
            }
            // On C1 in one direction or on C2 in the other: both push the difference to the same side.
            let one: f64 = lasting.iter().zip(&singles).map(|(a, beta)| a * beta).sum();
            *rate = 2.0 * survival.chance() * one;
            for (i, row) in doubles.iter().enumerate() {
                let mut sum = 0.0;
                for (beta, j) in row.iter().zip(i..) {
                    let overlaps =
                        overlapping([lasting[i], lasting[j]], [remaining[i], remaining[j]]);
                    // Two sizes that differ stand for both orders.
                    sum += if i == j { 1.0 } else { 2.0 } * overlaps * beta;
                }
                *rate += survival.chance().powi(2) * sum;
            }
            singles.iter_mut().zip(&single).for_each(|(power, beta)| *power *= beta);
            for (powers, betas) in doubles.iter_mut().zip(&double) {
                powers.iter_mut().zip(betas).for_each(|(power, beta)| *power *= beta);
            }
        }
        rates
    }
}

/// The limit for runs with at most `strays` samples outside: the least t at which the rate of chains that fill t samples is
/// below e^−`level`, with the places that the strays may have.
///
/// `fillings` is F(t), and `idle` the chance that a sample is in the box without an excursion. Of the chains E(t) begin with
/// an excursion and N(t) without; an excursion may join the one before at 2 `strays` + 1 places. Pauses of no samples are left
/// out of N(t), which would otherwise contain E(t).
fn limit(fillings: &[f64], idle: f64, strays: usize, level: f64) -> Option<u16> {
    let joints = (2 * strays + 1) as f64;
    let rare = (-level).exp();
    let exactly: Vec<f64> = fillings.windows(2).map(|pair| (pair[0] - pair[1]).max(0.0)).collect();
    let (mut excursions, mut idles, mut powers) = (vec![0.0], vec![0.0], vec![1.0]);
    for t in 1..=*LENGTHS.end() {
        let chained = |r: usize| exactly[r] * (joints * excursions[t - r] + idles[t - r]);
        let chains = fillings[t] + (1..t).map(chained).sum::<f64>();
        let power = powers[t - 1] * idle;
        let pauses = power + (1..t).map(|r| powers[r] * excursions[t - r]).sum::<f64>();
        if LENGTHS.contains(&t) && places(t, strays) * (chains + pauses) < rare {
            return u16::try_from(t).ok();
        }
        excursions.push(chains);
        idles.push(pauses);
        powers.push(power);
    }
    None
}

/// Number of ways in which `strays` samples can be placed in a run with `t` others.
fn places(t: usize, strays: usize) -> f64 {
    (1..=strays).map(|k| (t + k) as f64 / k as f64).product()
}
