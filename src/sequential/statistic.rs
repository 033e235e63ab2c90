//! The generalised likelihood ratios, in nats, maximised over the windows.

use super::clip::Clip;
use super::novelty::News;
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

/// Up to this width a window takes every sample that is news; wider ones only those in motion, because
/// at rest the count hardly changes and one sample says much of what the one before has said.
pub const AT_REST: usize = 4;

/// Of all samples, in motion or not, so many are held.
const NEWEST: usize = 64;

/// The sums of the clipped residual, m, of its clipped square, m², of the residual itself, m, of its
/// square, m², and of the cycles since the sample before.
#[derive(Clone, Debug, Default)]
pub struct History {
    /// Over all samples.
    pub all: Sums<{ NEWEST + 1 }>,
    /// Over those that do not repeat others.
    news: Sums<{ AT_REST + 1 }>,
    /// Over those of them that are in motion.
    pub moving: Sums<1025>,
    /// Cycles since the newest of each of the two.
    since: [u32; 2],
}

impl History {
    /// Takes a residual, m, as far as `clip` lets it count: a wild one must not be a mean of many.
    pub fn push(&mut self, residual: f64, clip: &Clip, news: News) {
        let square = residual * residual;
        let clipped = residual.clamp(-clip.farthest, clip.farthest);
        let values = |cycles| [clipped, square.min(clip.square), residual, square, cycles];
        self.all.push(values(1.0));
        self.since = self.since.map(|cycles| cycles.saturating_add(1));
        let [said, moved] = &mut self.since;
        let cycles = |since: &mut u32| f64::from(std::mem::take(since));
        if news != News::Repeated {
            self.news.push(values(cycles(said)));
        }
        if news == News::InMotion {
            self.moving.push(values(cycles(moved)));
        }
    }

    pub fn clear(&mut self) {
        self.all.clear();
        self.news.clear();
        self.moving.clear();
        self.since = [0; 2];
    }

    /// The sums over the newest few samples, news or not.
    pub fn newest(&self) -> Option<[f64; VALUES]> {
        self.all.over(AT_REST)
    }

    /// The cycles that the newest `width` samples that count go back.
    pub fn cycles(&self, width: usize) -> usize {
        self.over(width).map_or(width, |[.., cycles]| cycles as usize)
    }

    /// The sums over the newest `width` samples that count; `None` if there are not so many.
    pub fn over(&self, width: usize) -> Option<[f64; VALUES]> {
        if width <= AT_REST { self.news.over(width) } else { self.moving.over(width) }
    }
}

/// What is weighed against what.
#[derive(Clone, Debug)]
pub struct Scales {
    mean: Rate,
    square: Rate,
    /// Of healthy residuals, m.
    deviation: f64,
    /// Of the mean, m, for each of [`WIDTHS`].
    dead_bands: [f64; WIDTHS.len()],
    /// Samples of mean and of mean square that say as much as one, for each of [`WIDTHS`].
    dependence: Dependence,
    /// Of the mean square, m².
    spread_band: f64,
}

/// So many samples of a window say as much as one, 1 at least: of the mean and of the mean square, for
/// each of [`WIDTHS`] ([`super::dependence`]).
pub type Dependence = [[f64; WIDTHS.len()]; 2];

/// Every sample is news.
pub const INDEPENDENT: Dependence = [[1.0; WIDTHS.len()]; 2];

/// What is below this is no fault but a temperature or a bend that the calibration has left, m.
pub const DEAD_BAND: f64 = 1e-4;

/// What a displacement of the dead band may add to the evidence of any window, nats.
const BY_DEAD_BAND: f64 = 1.0;

/// The least dead band of the mean square, in healthy ones.
const LEAST_SPREAD_BAND: f64 = 0.25;

impl Scales {
    /// By the rate functions of the mean and of the mean square of residuals with this `deviation`,
    /// m. A displacement of `dead_band`, m, is no fault.
    ///
    /// In a short window a displacement of ε is hardly evidence, and the healthy residuals of the
    /// rate function have been displaced, too; so the dead band grows with the window, ε w/(w + w₀),
    /// with w₀ so that a window of samples that are all ε has 1 nat at the most.
    pub fn new(
        mean: Rate,
        square: Rate,
        dependence: Dependence,
        deviation: f64,
        dead_band: f64,
    ) -> Self {
        let grown = 8.0 * BY_DEAD_BAND * (deviation / dead_band).powi(2);
        let of = |width: usize| dead_band * width as f64 / (width as f64 + grown);
        let spread_band = (dead_band * dead_band).max(LEAST_SPREAD_BAND * deviation * deviation);
        Self { mean, square, dead_bands: WIDTHS.map(of), deviation, dependence, spread_band }
    }

    /// Of readings C1 and C2 that move in counts of this `resolution`, m.
    ///
    /// Where a rod goes whole counts from cycle to cycle and both readings lie between two of them, the
    /// noise rounds each up or down as long as the speed lasts: a mean square of q²/4 of each, however
    /// little it is elsewhere. So much is no noise.
    pub fn rounded(self, resolution: [f64; 2]) -> Self {
        let tossed: f64 = resolution.iter().map(|count| 0.25 * count * count).sum();
        let beyond = tossed - self.deviation * self.deviation;
        Self { spread_band: self.spread_band.max(beyond), ..self }
    }

    /// As far as one sample is evidence, m.
    pub fn farthest(&self) -> f64 {
        self.mean.farthest()
    }

    /// Of both statistics, the largest over the windows of at most `widest` samples: w/κ I(|mean| − ε_w),
    /// and w/κ₂ I₂(mean square − δ), where these are above 0.
    pub fn peaks(&self, history: &History, widest: usize) -> [Peak; 2] {
        let mut peaks = [Peak::default(); 2];
        for (index, width) in WIDTHS.into_iter().take_while(|width| *width <= widest).enumerate() {
            let Some([sum, squares, ..]) = history.over(width) else { continue };
            let count = width as f64;
            peaks[0] = peaks[0].or(self.by_mean(index, sum / count), width);
            peaks[1] = peaks[1].or(self.by_square(index, squares / count), width);
        }
        peaks
    }

    /// The evidence of a `mean`, m, of as many samples as the window of `index` has, nats.
    pub fn by_mean(&self, index: usize, mean: f64) -> f64 {
        let beyond = mean.abs() - self.dead_bands[index];
        if beyond <= 0.0 {
            return 0.0;
        }
        WIDTHS[index] as f64 / self.dependence[0][index] * self.mean.at(beyond)
    }

    /// The same of a mean `square`, m².
    pub fn by_square(&self, index: usize, square: f64) -> f64 {
        let beyond = square - self.spread_band;
        if beyond <= 0.0 {
            return 0.0;
        }
        WIDTHS[index] as f64 / self.dependence[1][index] * self.square.at(beyond.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEVIATION: f64 = 1e-4;

    /// Of a normal distribution of 0.1 mm, up to 0.5 mm.
    fn scales(dead_band: f64) -> Scales {
        let mean: Vec<f64> = (0..=50).map(|i| f64::from(i * i) / 200.0).collect();
        let square = |i: i32| match f64::from(i * i) / 100.0 {
            rho if rho > 1.0 => 0.5 * (rho - 1.0 - rho.ln()),
            _ => 0.0,
        };
        let square: Vec<f64> = (0..=50).map(square).collect();
        let [mean, square] = [mean, square].map(|values| Rate::new(1e-5, &values));
        Scales::new(mean, square, INDEPENDENT, DEVIATION, dead_band)
    }

    fn after(residuals: impl IntoIterator<Item = f64>, news: News) -> [Peak; 2] {
        let (mut history, scales) = (History::default(), scales(1e-4));
        let clip = Clip::new(&scales, f64::INFINITY);
        residuals.into_iter().for_each(|r| history.push(r, &clip, news));
        scales.peaks(&history, 1024)
    }

    #[test]
    fn a_step_has_the_window_that_it_fills() {
        let [mean, variance] =
            after((0..100).map(|k| if k < 88 { 0.0 } else { 3e-4 }), News::InMotion);
        assert_eq!(mean.width, 12);
        // ε is 0.1 mm · 12/(12 + 8): 12 samples of 2.4 deviations.
        assert!((mean.nats - 12.0 * 2.4 * 2.4 / 2.0).abs() < 1e-9, "{mean:?}");
        // The mean square is 9 healthy ones, less the band of one.
        let expected = 12.0 * 0.5 * (8.0 - 1.0 - 8.0_f64.ln());
        assert!((variance.nats / expected - 1.0).abs() < 1e-3, "{variance:?} {expected}");
    }

    #[test]
    fn one_wild_sample_is_no_mean_of_many() {
        let [mean, variance] =
            after((0..100).map(|k| if k == 90 { 1.0 } else { 0.0 }), News::InMotion);
        assert!(mean.nats < 1.0 && variance.nats < 5.0, "{mean:?} {variance:?}");
    }

    #[test]
    fn a_displacement_of_the_dead_band_is_no_evidence() {
        for length in [1, 5, 20, 80, 300, 2000] {
            let [mean, variance] = after((0..length).map(|_| 1e-4), News::InMotion);
            assert!(mean.nats < BY_DEAD_BAND + 1e-9, "{length}: {mean:?}");
            assert_eq!(variance, Peak::default(), "{length}");
        }
    }

    #[test]
    fn what_is_said_twice_is_evidence_once() {
        let Scales { mean, square, .. } = scales(1e-4);
        let twice = Scales::new(mean, square, [[2.0; WIDTHS.len()]; 2], DEVIATION, 1e-4);
        for index in 0..WIDTHS.len() {
            let (once, twice) = (scales(1e-4), &twice);
            assert!((once.by_mean(index, 3e-4) / twice.by_mean(index, 3e-4) - 2.0).abs() < 1e-12);
            let [one, half] = [&once, twice].map(|scales| scales.by_square(index, 9e-8));
            assert!((one / half - 2.0).abs() < 1e-12);
        }
    }

    /// Both readings are rounded up or down by turns that are their own: each as often.
    #[test]
    fn readings_that_lie_between_two_counts_are_no_noise() {
        let tossed = (0..96).map(|k| 4e-4 * f64::from((k & 1) - ((k / 3) & 1)));
        let most = |scales: Scales| {
            let (mut history, clip) = (History::default(), Clip::new(&scales, f64::INFINITY));
            tossed.clone().for_each(|r| history.push(r, &clip, News::InMotion));
            scales.peaks(&history, 1024)[1].nats
        };
        let (unknown, known) = (most(scales(1e-4)), most(scales(1e-4).rounded([4e-4; 2])));
        assert!(unknown > 10.0 && known < 1.0, "{unknown} {known}");
        assert_eq!(most(scales(1e-4).rounded([0.0; 2])), unknown);
    }

    #[test]
    fn at_rest_only_short_windows_count() {
        let [mean, _] = after((0..100).map(|_| 3e-4), News::AtRest);
        assert_eq!(mean.width, 4);
        let nothing = after((0..100).map(|_| 3e-4), News::Repeated);
        assert_eq!(nothing, [Peak::default(); 2]);
    }

    #[test]
    fn noise_of_twice_the_deviation_is_in_the_mean_square() {
        let [mean, variance] =
            after((0..64).map(|k| 2e-4 * f64::from(1 - 2 * (k & 1))), News::InMotion);
        assert!(mean.nats < 5.0, "{mean:?}");
        let s: f64 = 4.0 - 1.0;
        assert_eq!(variance.width, 64);
        let expected = 32.0 * (s - 1.0 - s.ln());
        assert!((variance.nats / expected - 1.0).abs() < 1e-3, "{variance:?} {expected}");
    }
}
