//! How much of one sample counts.

use super::statistic::Scales;

/// A single sample, however wild, is at most this part of the level: it takes two.
const SHARE: f64 = 0.6;

/// Beyond these a sample counts no more. The evidence of a window is convex in its sum, so that no
/// window makes more of a wild sample than that of one sample does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clip {
    /// Of the residual, m.
    pub farthest: f64,
    /// Of its square, m².
    pub square: f64,
}

impl Clip {
    /// For the level `level`, nats, of statistics by `scales`.
    pub fn new(scales: &Scales, level: f64) -> Self {
        let (most, farthest) = (SHARE * level, scales.farthest());
        Self {
            farthest: largest(farthest, |residual| scales.by_mean(0, residual) <= most),
            square: largest(farthest * farthest, |square| scales.by_square(0, square) <= most),
        }
    }

    /// Nothing is clipped.
    pub const NONE: Self = Self { farthest: f64::INFINITY, square: f64::INFINITY };
}

/// The largest value up to `farthest` that is `sound`; what is below a sound one is, too.
fn largest(farthest: f64, sound: impl Fn(f64) -> bool) -> f64 {
    if sound(farthest) {
        return farthest;
    }
    let (mut low, mut high) = (0.0, farthest);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if sound(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::super::novelty::News;
    use super::super::rate::Rate;
    use super::super::statistic::{History, INDEPENDENT};
    use super::*;

    const DEVIATION: f64 = 1e-4;

    /// Of a calibration of months: one sample alone is up to 25 nats and more.
    fn scales() -> Scales {
        let mean: Vec<f64> = (0..=100).map(|i| f64::from(i * i) / 400.0).collect();
        let square = |i: i32| match f64::from(i * i) / 100.0 {
            rho if rho > 1.0 => 0.5 * (rho - 1.0 - rho.ln()),
            _ => 0.0,
        };
        let square: Vec<f64> = (0..=100).map(square).collect();
        let [mean, square] = [mean, square].map(|values| Rate::new(1e-5, &values));
        Scales::new(mean, square, INDEPENDENT, DEVIATION, 1e-4)
    }

    /// The most of both statistics after healthy samples, with `wild` ones from sample 500 on.
    fn most(level: f64, wild: &[f64]) -> f64 {
        let scales = scales();
        let clip = Clip::new(&scales, level);
        let mut history = History::default();
        let mut most = 0.0_f64;
        for k in 0..2000_usize {
            let healthy = if k % 2 == 0 { DEVIATION } else { -DEVIATION };
            let residual = k.checked_sub(500).and_then(|i| wild.get(i)).copied();
            history.push(residual.unwrap_or(healthy), &clip, News::InMotion);
            let [mean, variance] = scales.peaks(&history, 1024);
            most = most.max(mean.nats).max(variance.nats);
        }
        most
    }

    #[test]
    fn one_sample_is_never_enough_and_two_are() {
        for level in [8.0, 12.0, 23.0] {
            for size in [1e-3, 5e-3, -1.0] {
                let one = most(level, &[size]);
                assert!(one < 0.65 * level, "{level} {size}: {one}");
                let two = most(level, &[size; 2]);
                assert!(two > level, "{level} {size}: {two}");
            }
        }
    }

    /// A short calibration clips sooner than a high level does.
    #[test]
    fn a_level_that_nothing_reaches_takes_samples_as_they_are() {
        let (scales, farthest) = (scales(), scales().farthest());
        let clip = Clip::new(&scales, f64::INFINITY);
        assert_eq!(clip, Clip { farthest, square: farthest * farthest });
    }
}
