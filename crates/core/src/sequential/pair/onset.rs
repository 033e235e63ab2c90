//! Whose reading moved at an onset that C1 − C2 shows, however long ago.
//!
//! A step of C1 by m moves the mean of both readings by m/2, and one of C2 that makes the same difference by −m/2. The innovations'
//! sum has it at the onset alone, and there the closed loop has not answered yet.

use super::{KEPT, Pair, Signature};
use crate::sequential::excursions::{Beginning, Onset, displaced, student};
use crate::sequential::parameters::OnsetParameters;
use crate::sequential::whitening::ORDER;

/// Samples of the measured course before and after the onset.
const COURSE: [usize; 2] = [2, 10];

/// Shifts of the onset at the most, either way.
const SHIFTS: usize = 8;

/// Unpredicted sums of the innovations around an onset.
struct Seen {
    /// The oldest sample first, m.
    sums: [f64; KEPT],
    count: usize,
    /// Scale of their errors, m.
    scale: f64,
    freedom: f64,
}

impl Seen {
    /// Log-likelihood of an expected course of these sums, from the first one on.
    fn likelihood(&self, expected: impl Fn(usize) -> f64) -> f64 {
        let sums = self.sums[..self.count].iter().enumerate();
        sums.map(|(at, sum)| student(sum - expected(at), self.scale, self.freedom)).sum()
    }
}

impl Pair {
    /// Evidence of the reading that moved at `onset`, nats: positive for C1. `residuals` are those of C1 − C2, newest first, m, with
    /// this `deviation`. `None` where the filter has not followed for so long, or the step and the measured course do not agree.
    pub fn compare_at(
        &self,
        onset: &Onset,
        residuals: &[f64],
        deviation: f64,
        p: &OnsetParameters,
    ) -> Option<f64> {
        let around = p.around.min(SHIFTS);
        let first = onset.ago + around.max(COURSE[0]);
        let last = (onset.ago + around).saturating_sub(p.telling).max(1);
        let seen = self.seen(first, last, p)?;
        let Signature { plus, .. } = &self.design.signatures[0];
        // Both innovations together, for a step of one unit.
        let sum = |age: usize| plus.get(age).map_or(0.0, |half| 2.0 * half);
        let course = course(onset, residuals, first);
        let filtered = |at: usize| {
            let moves = course.iter().enumerate().take(at + 1);
            moves.map(|(begun, change)| change * sum(at - begun)).sum::<f64>()
        };
        let measured = seen.likelihood(filtered) - seen.likelihood(|at| -filtered(at));
        if onset.beginning == Beginning::Ramp {
            return Some(measured);
        }
        let best = |sign: f64| {
            let shifted =
                (onset.ago.saturating_sub(around).max(1)..=onset.ago + around).map(|ago| {
                    let expected = |at: usize| {
                        let age = (ago + at).checked_sub(first);
                        age.map_or(0.0, |age| sign * onset.size * sum(age))
                    };
                    shift(onset, ago, residuals, deviation, p) + seen.likelihood(expected)
                });
            log_sum(shifted)
        };
        let step = best(1.0) - best(-1.0);
        (step * measured > 0.0 && measured.abs() >= p.agreeing).then_some(step)
    }

    /// The unpredicted sums from `first` to `last` samples ago, 1 being the newest one, and what they err by before.
    fn seen(&self, first: usize, last: usize, p: &OnsetParameters) -> Option<Seen> {
        if first + ORDER >= self.held || first < last {
            return None;
        }
        let whitening = &self.design.whitening;
        let sum = |ago: usize| self.ago(ago - 1).iter().sum::<f64>();
        let unpredicted = |ago: usize| whitening.unpredicted(sum(ago), |cycles| sum(ago + cycles));
        let mut sums = [0.0; KEPT];
        let count = first - last + 1;
        for (place, ago) in sums.iter_mut().zip((last..=first).rev()) {
            *place = unpredicted(ago);
        }
        let mut errors = [0.0; KEPT];
        let before = p.errors.min(self.held - ORDER - first).min(KEPT);
        let errors = &mut errors[..before];
        for (error, ago) in errors.iter_mut().zip(first + 1..) {
            *error = unpredicted(ago).abs();
        }
        errors.sort_unstable_by(f64::total_cmp);
        let healthy = libm::sqrt(2.0 * whitening.left() / self.design.weights[0]);
        let now = errors.get(before / 2).map_or(0.0, |median| MEDIAN * median);
        Some(Seen { sums, count, scale: healthy.max(now), freedom: p.freedom })
    }
}

/// Standard deviation of a normal variable by the median of its magnitude.
const MEDIAN: f64 = 1.4826;

/// Changes of C1 − C2 around the onset, from `first` samples ago on, m; it stays where it is after.
fn course(onset: &Onset, residuals: &[f64], first: usize) -> [f64; KEPT] {
    let mut changes = [0.0; KEPT];
    let [before, after] = COURSE;
    let mut value = 0.0;
    let to = onset.ago.saturating_sub(after).max(1);
    for ago in (to..=onset.ago + before).rev() {
        let Some(residual) = residuals.get(ago - 1) else { continue };
        if let Some(change) = first.checked_sub(ago).and_then(|at| changes.get_mut(at)) {
            *change = residual - value;
            value = *residual;
        }
    }
    changes
}

/// How much more likely C1 − C2 makes an onset `ago` samples ago than that which was found, nats.
fn shift(onset: &Onset, ago: usize, residuals: &[f64], deviation: f64, p: &OnsetParameters) -> f64 {
    let of = |from: usize, to: usize| {
        let between = residuals.get(from..to).unwrap_or_default().iter();
        between.map(|it| displaced(*it, onset.size, deviation, p)).sum::<f64>()
    };
    if ago > onset.ago { of(onset.ago, ago) } else { -of(ago, onset.ago) }
}

fn log_sum(terms: impl Iterator<Item = f64> + Clone) -> f64 {
    let most = terms.clone().fold(f64::NEG_INFINITY, f64::max);
    most + libm::log(terms.map(|term| libm::exp(term - most)).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_difference_prefers_the_onset_that_it_shows() {
        let (size, deviation) = (5e-4, 8e-5);
        let residuals: Vec<f64> = (1..=40).map(|ago| if ago <= 10 { size } else { 0.0 }).collect();
        let from = |found: usize, ago: usize| {
            let onset = Onset { ago: found, size, beginning: Beginning::Step };
            shift(&onset, ago, &residuals, deviation, &OnsetParameters::DEFAULT)
        };
        assert!(from(12, 10) > 0.0 && from(12, 14) < 0.0 && from(12, 12) == 0.0);
        assert!(from(8, 10) > 0.0 && from(8, 7) < 0.0);
    }
}
