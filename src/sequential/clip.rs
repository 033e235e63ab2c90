//! How much of one sample counts.

use super::rate::Rate;
use super::statistic::CAP;

/// A single sample, however wild, is at most this part of the level: it takes two.
const SHARE: f64 = 0.6;

/// Beyond these a sample counts no more. The evidence of a window is convex in its sum, so that no
/// window makes more of a wild sample than that of one sample does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clip {
    /// Of the residual, m.
    pub farthest: f64,
    /// Of z².
    pub square: f64,
}

impl Clip {
    /// For the level `level`, nats, and the dead bands of the statistics: that of the mean, m, and
    /// that of the variance.
    pub fn new(rate: &Rate, level: f64, dead_band: f64, spread_band: f64) -> Self {
        let most = SHARE * level;
        Self {
            farthest: rate.farthest().min(dead_band + within(rate, most)),
            square: CAP.min((1.0 + spread_band) * ratio(most)),
        }
    }
}

/// The largest x, m, with I(x) of at most `nats`; as far as the table goes.
fn within(rate: &Rate, nats: f64) -> f64 {
    let beyond = rate.values.iter().position(|value| *value > nats);
    beyond.map_or(rate.farthest(), |i| {
        let [low, high] = [i - 1, i].map(|i| rate.values[i]);
        rate.spacing * ((i - 1) as f64 + (nats - low) / (high - low))
    })
}

/// The ratio s above 1 of one sample with (s − 1 − ln s) / 2 = `nats`; at most beyond [`CAP`].
fn ratio(nats: f64) -> f64 {
    let (mut low, mut high) = (1.0, 2.0 * CAP);
    for _ in 0..60 {
        let middle: f64 = 0.5 * (low + high);
        if 0.5 * (middle - 1.0 - middle.ln()) > nats {
            high = middle;
        } else {
            low = middle;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::super::statistic::{History, peaks};
    use super::*;

    const DEVIATION: f64 = 1e-4;
    const DEAD_BAND: f64 = 1e-4;
    const SPREAD_BAND: f64 = 0.25;

    /// Of a calibration of months: one sample alone is up to 25 nats.
    fn rate() -> Rate {
        Rate { spacing: 1e-5, values: (0..=100).map(|i| f64::from(i * i) / 400.0).collect() }
    }

    /// The most of both statistics after healthy samples, with `wild` ones from sample 500 on.
    fn most(level: f64, wild: &[f64]) -> f64 {
        let rate = rate();
        let clip = Clip::new(&rate, level, DEAD_BAND, SPREAD_BAND);
        let mut history = History::default();
        let mut most = 0.0_f64;
        for k in 0..2000_usize {
            let healthy = if k % 2 == 0 { DEVIATION } else { -DEVIATION };
            let residual = k.checked_sub(500).and_then(|i| wild.get(i)).copied();
            history.push(residual.unwrap_or(healthy), DEVIATION, &clip, true);
            let [mean, variance] = peaks(&history, &rate, DEAD_BAND, SPREAD_BAND, 1024);
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
        let clip = Clip::new(&rate(), f64::INFINITY, DEAD_BAND, SPREAD_BAND);
        assert_eq!(clip, Clip { farthest: rate().farthest(), square: CAP });
    }
}
