//! How alike two signals are: as readings of one length, and as a command and its motion.

use crate::order_statistics::lower_median;
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;

/// Cycles on either side over which a derivative and its command are averaged, so that counts matter little.
const HALF: usize = 4;

/// Longest time by which the motion may lead a reading of it, and a command the motion, s: filters and valves take less.
const LONGEST: [f64; 2] = [0.12, 0.35];

/// Cycles that these times are at least and at most.
const FEWEST: [f64; 2] = [6.0, 4.0];
const MOST: f64 = 64.0;

/// Cycles between two of the leads that are tried first.
const COARSE: usize = 4;

/// Samples that a correlation is computed from at the most.
const SAMPLED: usize = 4000;

/// Passes of the fit, each without what was far off in the one before.
const PASSES: usize = 4;

/// Standard deviations beyond which a sample is left out of the next pass.
const FAR: f64 = 4.0;

/// Standard deviation of the difference of two rounded readings, in steps: 1/√6.
const ROUNDED: f64 = 0.408;

/// How the readings of one signal follow from those of another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Agreement {
    /// First reading by the second one.
    pub gain: f64,
    /// First reading where the second one is 0, in its unit.
    pub offset: f64,
    /// Standard deviation of what is left, in the first one's unit.
    pub spread: f64,
    /// Standard deviation of the first reading.
    pub motion: f64,
    /// From the lowest to the highest of the readings that agree.
    pub travel: f64,
    /// Share of the samples that agree.
    pub share: f64,
}

/// How the motion of one signal follows another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Following {
    /// Correlation of the derivative with the other signal, leading by [`Self::lead`].
    pub correlation: f64,
    /// Cycles by which the other signal leads the motion, from sample to sample.
    pub lead: f64,
    /// Derivative by the other signal.
    pub gain: f64,
}

/// How `first` follows from `second`, where they may be sampled at slightly different times and have steps of
/// `resolution`. `None` if there are too few readings, or no motion in them.
pub(super) fn agreement(first: &[f64], second: &[f64], resolution: f64) -> Option<Agreement> {
    // Of coarse readings most are the same count, and the others are no outliers.
    let least = (ROUNDED * resolution).max(1e-12);
    let samples = samples(first, second);
    let mut kept: Vec<bool> = vec![true; samples.len()];
    let mut found = None;
    for _ in 0..PASSES {
        let chosen = || samples.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(one, _)| *one);
        let solution = solve(chosen())?;
        let rest = |[y, x, v]: [f64; 3]| y - solution.dot(&Vector3::new(x, 1.0, v));
        let sizes: Vec<f64> = chosen().map(|one| rest(one).abs()).collect();
        let spread = 1.4826 * lower_median(&sizes)?;
        let worst = sizes.iter().copied().fold(0.0, f64::max);
        let spread = spread.max(least);
        found = Some((solution, spread));
        if worst <= FAR * spread {
            break;
        }
        for (keep, one) in kept.iter_mut().zip(&samples) {
            *keep = rest(*one).abs() <= FAR * spread;
        }
    }
    let (solution, spread) = found?;
    let near: Vec<f64> = samples.iter().zip(&kept).filter(|it| *it.1).map(|it| it.0[0]).collect();
    let mean = near.iter().sum::<f64>() / near.len() as f64;
    let motion = (near.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / near.len() as f64).sqrt();
    let (low, high) = ends(&near);
    let share = near.len() as f64 / samples.len() as f64;
    let (gain, offset) = (solution[0], solution[1]);
    Some(Agreement { gain, offset, spread, motion, travel: high - low, share })
}

/// The lowest and the highest value.
pub(super) fn ends(values: &[f64]) -> (f64, f64) {
    let finite = values.iter().copied().filter(|it| it.is_finite());
    finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), it| (low.min(it), high.max(it)))
}

/// First reading, second reading, and the step of the second one over a cycle.
fn samples(first: &[f64], second: &[f64]) -> Vec<[f64; 3]> {
    let length = first.len().min(second.len());
    let stride = stride(length);
    let sample = |k: usize| [first[k], second[k], (second[k + 1] - second[k - 1]) / 2.0];
    let all = (1..length.saturating_sub(1)).step_by(stride).map(sample);
    all.filter(|sample| sample.iter().all(|it| it.is_finite())).collect()
}

const fn stride(length: usize) -> usize {
    length.div_ceil(SAMPLED) | 1
}

fn solve(samples: impl Iterator<Item = [f64; 3]>) -> Option<Vector3<f64>> {
    let samples: Vec<[f64; 3]> = samples.collect();
    let count = samples.len() as f64;
    if samples.len() < 20 {
        return None;
    }
    // About the means: an offset of kilometres would else be all that is left of the numbers.
    let means = [0, 1, 2].map(|place| samples.iter().map(|one| one[place]).sum::<f64>() / count);
    let (mut matrix, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for [y, x, v] in &samples {
        let row = Vector3::new(x - means[1], 0.0, v - means[2]);
        matrix += row * row.transpose();
        right += row * (y - means[0]);
    }
    matrix[(1, 1)] = 1.0;
    // Without any motion in the steps they explain nothing.
    matrix[(2, 2)] += 1e-12 * matrix[(0, 0)] + f64::MIN_POSITIVE;
    let mut solution = matrix.lu().solve(&right).filter(|it| it.iter().all(|it| it.is_finite()))?;
    solution[1] = means[0] - solution[0] * means[1] - solution[2] * means[2];
    Some(solution)
}

/// The derivative of a signal, smoothed, per cycle.
pub(super) fn derivative(values: &[f64]) -> Vec<f64> {
    let at = |k: usize| match k.checked_sub(HALF) {
        Some(before) if k + HALF < values.len() => {
            (values[k + HALF] - values[before]) / (2 * HALF) as f64
        }
        _ => f64::NAN,
    };
    (0..values.len()).map(at).collect()
}

/// A signal averaged as [`derivative`] averages the motion.
pub(super) fn smooth(values: &[f64]) -> Vec<f64> {
    let at = |k: usize| match k.checked_sub(HALF) {
        Some(before) if k + HALF < values.len() => {
            let near = values[before..=k + HALF].iter().copied().filter(|it| it.is_finite());
            let (sum, count) = near.fold((0.0, 0), |(sum, count), it| (sum + it, count + 1));
            if count > HALF { sum / f64::from(count as u32) } else { f64::NAN }
        }
        _ => f64::NAN,
    };
    (0..values.len()).map(at).collect()
}

/// How the motion with this derivative follows the smoothed signal `driver`, in cycles of `period` seconds. `None` where
/// nothing within [`LONGEST`] follows best: what two slow signals have in common grows towards the end of any range.
pub(super) fn following(derivative: &[f64], driver: &[f64], period: f64) -> Option<Following> {
    let [behind, ahead] =
        [0, 1].map(|side| (LONGEST[side] / period).round().clamp(FEWEST[side], MOST) as isize);
    // One more on either side, so that the best one has neighbours.
    let leads = -behind - 1..=ahead + 1;
    // The same part of the motion for all of them: of a rod that only extends, another part may correlate better.
    let length = derivative.len().min(driver.len());
    let part = leads.end().unsigned_abs()..length.saturating_sub(leads.start().unsigned_abs());
    let at_lead = |lead| at_lead(derivative, driver, part.clone(), lead);
    // The whole range only where a coarse look is promising.
    let promising = |(r, _): (f64, f64)| r.abs() > 0.4;
    let mut coarse = leads.clone().step_by(COARSE);
    if !coarse.any(|lead| at_lead(lead).is_some_and(promising)) {
        return None;
    }
    let all: Vec<(isize, (f64, f64))> =
        leads.filter_map(|lead| Some((lead, at_lead(lead)?))).collect();
    let place = (0..all.len()).max_by(|a, b| all[*a].1.0.abs().total_cmp(&all[*b].1.0.abs()))?;
    let (lead, (correlation, gain)) = all[place];
    let size = |place: usize| all.get(place).map(|(_, (r, _))| r.abs());
    let [before, after] = [size(place.checked_sub(1)?)?, size(place + 1)?];
    // The top of a parabola through the best lead and its neighbours.
    let bend = before - 2.0 * correlation.abs() + after;
    let between = if bend < 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
    Some(Following { correlation, lead: lead as f64 + between.clamp(-0.5, 0.5), gain })
}

/// Correlation, and the slope of a part of the derivative over the driver that leads by so many cycles.
fn at_lead(
    derivative: &[f64],
    driver: &[f64],
    part: Range<usize>,
    lead: isize,
) -> Option<(f64, f64)> {
    let mut sums = [0.0; 5];
    let mut count = 0.0;
    let stride = stride(part.len());
    for k in part.step_by(stride) {
        let Some(at) = k.checked_add_signed(-lead) else { continue };
        let (y, x) = (derivative[k], driver[at]);
        if y.is_finite() && x.is_finite() {
            count += 1.0;
            for (sum, term) in sums.iter_mut().zip([y, x, y * y, x * x, x * y]) {
                *sum += term;
            }
        }
    }
    let [y, x, yy, xx, xy] = sums.map(|sum| sum / count);
    let (vy, vx, vxy) = (yy - y * y, xx - x * x, xy - x * y);
    (count >= 50.0 && vy > 0.0 && vx > 0.0).then(|| (vxy / (vx * vy).sqrt(), vxy / vx))
}
