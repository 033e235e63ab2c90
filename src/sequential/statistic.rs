//! The generalised likelihood ratios, in nats, maximised over the windows.

use super::clip::Clip;
use super::rate::Rate;
use super::windows::{Sums, VALUES, WIDTHS};

/// A statistic and the window that it comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Peak {
    /// Nats.
    pub nats: f64,
    /// Samples; 0 while nothing stands out.
    pub width: usize,
}

impl Peak {
    fn or(self, nats: f64, width: usize) -> Self {
        if nats > self.nats { Self { nats, width } } else { self }
    }
}

/// Up to this width a window takes every sample; wider ones only those in motion, because at rest
/// the count does not change and one sample says what the one before has said.
pub const AT_REST: usize = 4;

/// Of all samples, in motion or not, so many are held.
const NEWEST: usize = 64;

/// z² is not counted beyond this: one wild sample is not noise.
pub const CAP: f64 = 36.0;

/// The sums of the clipped residual, m, of its capped z², of the residual, m, and of its square, m²,
/// over all samples and over those in motion.
#[derive(Clone, Debug, Default)]
pub struct History {
    pub all: Sums<{ NEWEST + 1 }>,
    pub moving: Sums<1025>,
}

impl History {
    /// Takes a residual, m, of a healthy `deviation`, as far as `clip` lets it count: a wild one must
    /// not be a mean of many.
    pub fn push(&mut self, residual: f64, deviation: f64, clip: &Clip, moving: bool) {
        let z = residual / deviation;
        let clipped = residual.clamp(-clip.farthest, clip.farthest);
        let values = [clipped, (z * z).min(clip.square), residual, residual * residual];
        self.all.push(values);
        if moving {
            self.moving.push(values);
        }
    }

    pub fn clear(&mut self) {
        self.all.clear();
        self.moving.clear();
    }

    /// The sums over the newest few samples, in motion or not.
    pub fn newest(&self) -> Option<[f64; VALUES]> {
        self.all.over(AT_REST)
    }

    fn over(&self, width: usize) -> Option<[f64; VALUES]> {
        if width <= AT_REST { self.all.over(width) } else { self.moving.over(width) }
    }
}

/// Of both statistics, the largest over the windows of at most `widest` samples.
///
/// The mean's is w I(max(|mean| − ε, 0)), with the dead band ε in m. That of the variance is
/// w/2 (s − 1 − ln s) with s = mean z² / (1 + δ) where s is above 1.
pub fn peaks(
    history: &History,
    rate: &Rate,
    dead_band: f64,
    spread_band: f64,
    widest: usize,
) -> [Peak; 2] {
    let mut peaks = [Peak::default(); 2];
    for width in WIDTHS.into_iter().take_while(|width| *width <= widest) {
        let Some([sum, squares, ..]) = history.over(width) else { continue };
        let count = width as f64;
        let beyond = (sum / count).abs() - dead_band;
        if beyond > 0.0 {
            peaks[0] = peaks[0].or(count * rate.at(beyond), width);
        }
        let ratio = squares / (count * (1.0 + spread_band));
        if ratio > 1.0 {
            peaks[1] = peaks[1].or(0.5 * count * (ratio - 1.0 - ratio.ln()), width);
        }
    }
    peaks
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLIP: Clip = Clip { farthest: 5e-4, square: CAP };

    fn rate() -> Rate {
        // 0.1 mm of deviation, up to 0.5 mm.
        let values = (0..=50).map(|i| f64::from(i * i) / 200.0).collect();
        Rate { spacing: 1e-5, values }
    }

    fn after(residuals: impl IntoIterator<Item = f64>, moving: bool) -> [Peak; 2] {
        let mut history = History::default();
        residuals.into_iter().for_each(|r| history.push(r, 1e-4, &CLIP, moving));
        peaks(&history, &rate(), 1e-4, 0.25, 1024)
    }

    #[test]
    fn a_step_has_the_window_that_it_fills() {
        let [mean, _] = after((0..100).map(|k| if k < 88 { 0.0 } else { 3e-4 }), true);
        assert_eq!(mean.width, 12);
        // Twice the deviation beyond the dead band: 12 × 2.
        assert!((mean.nats - 24.0).abs() < 1e-9, "{mean:?}");
    }

    #[test]
    fn one_wild_sample_is_no_mean_of_many() {
        let [mean, _] = after((0..100).map(|k| if k == 90 { 1.0 } else { 0.0 }), true);
        assert!(mean.nats < 1.0, "{mean:?}");
    }

    #[test]
    fn within_the_dead_band_nothing_stands_out() {
        let [mean, variance] = after((0..2000).map(|_| 0.9999e-4), true);
        assert_eq!((mean, variance), (Peak::default(), Peak::default()));
    }

    #[test]
    fn at_rest_only_short_windows_count() {
        let [mean, _] = after((0..100).map(|_| 3e-4), false);
        assert_eq!(mean.width, 4);
    }

    #[test]
    fn noise_of_twice_the_deviation_is_in_the_variance() {
        let [mean, variance] = after((0..64).map(|k| 2e-4 * f64::from(1 - 2 * (k & 1))), true);
        assert!(mean.nats < 5.0, "{mean:?}");
        let s: f64 = 4.0 / 1.25;
        assert_eq!(variance.width, 64);
        assert!((variance.nats - 32.0 * (s - 1.0 - s.ln())).abs() < 1e-9, "{variance:?}");
    }
}
