//! Generalised likelihood ratios, in nats, maximised over the windows.

use super::parameters::EvidenceParameters;
use super::rate::Rate;
use super::wild::Outliers;
use super::windows::{VALUES, WIDTHS};
use crate::state::whole;

/// A statistic and its window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Peak {
    /// Evidence, nats.
    pub nats: f64,
    /// Width of the window, samples; 0 while nothing stands out.
    pub width: usize,
}

whole! { Peak { nats, width } }

/// The larger of two.
pub(super) fn larger(one: Peak, other: Peak) -> Peak {
    if other.nats > one.nats { other } else { one }
}

/// Number of samples of a window that carry as much information as one independent sample, at least
/// 1: for the mean and for the mean square, for each of [`WIDTHS`] ([`super::dependence`]).
pub type Dependence = [[f64; WIDTHS.len()]; 2];

/// Every sample is independent.
pub const INDEPENDENT: Dependence = [[1.0; WIDTHS.len()]; 2];

const P: &EvidenceParameters = &EvidenceParameters::DEFAULT;

/// What is below this is no fault but a temperature or a bend that the calibration has left, m.
pub const DEAD_BAND: f64 = P.dead_band;

/// Parts of the weighted residuals that are not evidence: those that may be a bend, or wild.
#[derive(Clone, Debug, PartialEq)]
pub struct Bands {
    /// Dead band of the mean, m, at rest.
    dead_band: f64,
    /// Dead band of the mean for each of [`WIDTHS`], m.
    dead_bands: [f64; WIDTHS.len()],
    /// Dead band of the mean square, m².
    spread_band: f64,
    /// Value beyond which one sample is no more evidence, m.
    farthest: f64,
    outliers: Outliers,
}

impl Bands {
    /// Bands for residuals that scatter by `noise` at rest, m, readings with this `resolution`, m,
    /// and this share of `outliers`. A displacement of `dead_band`, m, is no fault.
    ///
    /// In a short window a displacement of ε is hardly evidence, and the healthy residuals of the
    /// rate function have been displaced, too. The dead band therefore grows with the window, ε
    /// w/(w + w₀), with w₀ such that a window of samples that are all ε has at most 1 nat.
    ///
    /// Where a rod moves by whole counts from cycle to cycle and both readings lie between two of
    /// them, the noise rounds each up or down as long as the speed lasts. Each then has a mean
    /// square of q²/4, however small it is elsewhere, which is not a fault.
    pub fn new(noise: f64, dead_band: f64, resolution: [f64; 2], outliers: Outliers) -> Self {
        let ratio = noise / dead_band;
        let grown = 8.0 * P.by_dead_band * (ratio * ratio);
        let of = |width: usize| dead_band * width as f64 / (width as f64 + grown);
        let tossed: f64 = resolution.iter().map(|count| 0.25 * count * count).sum();
        let least = (dead_band * dead_band).max(P.least_spread_band * noise * noise);
        Self {
            dead_band,
            dead_bands: WIDTHS.map(of),
            spread_band: least.max(tossed - noise * noise),
            farthest: outliers.reach() * noise,
            outliers,
        }
    }

    pub const fn farthest(&self) -> f64 {
        self.farthest
    }

    pub const fn outliers(&self) -> Outliers {
        self.outliers
    }

    pub const fn dead_band(&self) -> f64 {
        self.dead_band
    }

    /// Dead band ε_w of the window of `index`, m.
    pub const fn dead_band_of(&self, index: usize) -> f64 {
        self.dead_bands[index]
    }

    pub const fn spread_band(&self) -> f64 {
        self.spread_band
    }

    /// Mean of the weighted residuals beyond the dead band, m, in the window of `index`; `share` is
    /// their mean factor, since the dead band applies to unweighted residuals.
    pub fn beyond(&self, index: usize, mean: f64, share: f64) -> f64 {
        (mean.abs() - self.dead_bands[index] * share).max(0.0)
    }
}

/// Scales for the weighing of evidence.
#[derive(Clone, Debug)]
pub struct Scales {
    mean: Rate,
    square: Rate,
    bands: Bands,
    pub(super) windows: [Window; WIDTHS.len()],
}

/// Constants of the statistics of one window, multiplied by its width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Window {
    /// Part 1/w of each sample.
    part: f64,
    /// Dead band ε_w, m.
    dead_band: f64,
    /// Dead band of the sum of squares, m².
    spread_band: f64,
    /// Number of independent samples w/κ, for mean and mean square.
    worth: [f64; 2],
    /// Bound: the root of the nats of the mean is at most this, 1/m, times the part of the sum
    /// beyond its band.
    pub root: f64,
    /// Bound: the nats of the mean square are at most the first, 1/m², times the sum of squares,
    /// less the second.
    pub line: [f64; 2],
}

/// The bounds are so much too large: rounding must not let one fall below what it bounds.
const ROUNDING: f64 = 1e-9;

impl Window {
    fn new(width: usize, dead_band: f64, spread_band: f64, worth: [f64; 2]) -> Self {
        let width = width as f64;
        Self {
            part: 1.0 / width,
            dead_band,
            spread_band: width * spread_band,
            worth,
            root: 0.0,
            line: [0.0; 2],
        }
    }

    /// Part of a sum beyond its band, m.
    #[inline]
    pub fn beyond(&self, [sum, _, shares, _]: [f64; VALUES]) -> f64 {
        sum.abs() - self.dead_band * shares
    }

    /// Part of the sum of squares beyond its band, m².
    #[inline]
    pub fn square_beyond(&self, [_, squares, ..]: [f64; VALUES]) -> f64 {
        squares - self.spread_band
    }

    /// This window with bounds: I(x) ≤ M x², where x is the part of the sum beyond its band over
    /// the width; and I₂(x) ≤ M₂ (x² − x₀²), where x² is that of the squares ([`Rate::steepest`]).
    fn bounded(self, mean: &Rate, square: &Rate) -> Self {
        let root = libm::sqrt(self.worth[0] * mean.steepest(0.0)) * self.part * (1.0 + ROUNDING);
        let silent = square.silent();
        let steepest = self.worth[1] * square.steepest(silent) * (1.0 + ROUNDING);
        let slope = steepest * self.part;
        let begins = slope * self.spread_band + steepest * silent * silent;
        // Of a rate that begins above 0 the slope is infinite: then all are looked at.
        let begins = if slope.is_finite() { begins * (1.0 - ROUNDING) } else { 0.0 };
        Self { root, line: [slope, begins], ..self }
    }
}

impl Scales {
    /// Scales by the rate functions of the mean and of the mean square of weighted residuals.
    pub fn new(mean: Rate, square: Rate, dependence: Dependence, bands: Bands) -> Self {
        let windows = core::array::from_fn(|index| {
            let worth = dependence.map(|of| WIDTHS[index] as f64 / of[index]);
            Window::new(WIDTHS[index], bands.dead_bands[index], bands.spread_band, worth)
                .bounded(&mean, &square)
        });
        Self { mean, square, bands, windows }
    }

    pub const fn mean(&self) -> &Rate {
        &self.mean
    }

    pub const fn square(&self) -> &Rate {
        &self.square
    }

    pub const fn bands(&self) -> &Bands {
        &self.bands
    }

    /// Nats of the part of a sum `beyond` its band, m.
    #[inline]
    pub(super) fn mean_nats(&self, window: &Window, beyond: f64) -> f64 {
        if beyond > 0.0 { window.worth[0] * self.mean.at(beyond * window.part) } else { 0.0 }
    }

    #[inline]
    pub(super) fn square_nats(&self, window: &Window, beyond: f64) -> f64 {
        if beyond > 0.0 {
            window.worth[1] * self.square.at(libm::sqrt(beyond * window.part))
        } else {
            0.0
        }
    }

    /// Evidence of a mean that is `beyond` its band, m, of as many samples as the window of `index`
    /// has, nats.
    pub fn by_mean(&self, index: usize, beyond: f64) -> f64 {
        self.windows[index].worth[0] * self.mean.at(beyond)
    }

    /// Evidence of a mean `square`, m², of as many samples as the window of `index` has, nats.
    pub fn by_square(&self, index: usize, square: f64) -> f64 {
        let beyond = (square - self.bands.spread_band).max(0.0);
        self.windows[index].worth[1] * self.square.at(libm::sqrt(beyond))
    }
}

#[cfg(test)]
mod tests {
    use super::super::clip::Clip;
    use super::super::samples::{AT_REST, History, Independence, Sample};
    use super::*;

    const DEVIATION: f64 = 1e-4;

    fn scales(dead_band: f64) -> Scales {
        counted(dead_band, INDEPENDENT, [0.0; 2])
    }

    /// Scales for a normal distribution of 0.1 mm, up to 0.5 mm.
    fn counted(dead_band: f64, dependence: Dependence, resolution: [f64; 2]) -> Scales {
        let mean: Vec<f64> = (0..=50).map(|i| f64::from(i * i) / 200.0).collect();
        let square = |i: i32| match f64::from(i * i) / 100.0 {
            rho if rho > 1.0 => 0.5 * (rho - 1.0 - rho.ln()),
            _ => 0.0,
        };
        let square: Vec<f64> = (0..=50).map(square).collect();
        let [mean, square] = [mean, square].map(|values| Rate::new(1e-5, &values));
        Scales::new(
            mean,
            square,
            dependence,
            Bands::new(DEVIATION, dead_band, resolution, Outliers::UNSAID),
        )
    }

    fn after(residuals: impl IntoIterator<Item = f64>, independence: Independence) -> [Peak; 2] {
        weighed(residuals.into_iter(), 1.0, independence)
    }

    fn weighed(residuals: impl Iterator<Item = f64>, share: f64, of: Independence) -> [Peak; 2] {
        let (mut history, scales) = (History::default(), scales(1e-4));
        let clip = Clip::new(scales.bands());
        for residual in residuals {
            history.push(Sample { residual, share, doubt: 0.0 }, &clip, of);
        }
        scales.peaks(&history, 1024)
    }

    /// A residual that is twice as large, with twice the scatter by its speed, is worth half of it
    /// at rest, and so is its dead band.
    #[test]
    fn what_scatters_more_by_its_speed_proves_less() {
        let alternating = (0..200).map(|k| 2e-4 * f64::from(1 - 2 * (k & 1)));
        let [_, variance] = weighed(alternating.clone(), 0.5, Independence::InMotion);
        assert_eq!(variance, Peak::default());
        assert!(weighed(alternating, 1.0, Independence::InMotion)[1].nats > 20.0);
        for length in [1, 5, 20, 80, 300] {
            let [mean, _] = weighed((0..length).map(|_| 1e-4), 0.5, Independence::InMotion);
            assert!(mean.nats < P.by_dead_band, "{length}: {mean:?}");
        }
    }

    /// A place where the reference may be off by 0.2 mm, and is; and a fault there.
    #[test]
    fn what_is_not_known_costs_evidence_in_quadrature() {
        let most = |residual: f64, doubt: f64, length: usize| {
            let (mut history, scales) = (History::default(), scales(1e-4));
            let (clip, mut most) = (Clip::new(scales.bands()), 0.0_f64);
            for _ in 0..length {
                let doubt = doubt * doubt;
                history.push(Sample { residual, share: 1.0, doubt }, &clip, Independence::InMotion);
                let [mean, square] = scales.peaks(&history, 1024);
                most = most.max(mean.nats).max(square.nats);
            }
            most
        };
        assert!(most(2e-4, 0.0, 300) > 40.0 && most(2e-4, 2e-4, 300) < 5.0);
        assert!(most(5e-4, 2e-4, 10) > 22.0 && most(5e-4, 0.0, 5) > 22.0);
    }

    #[test]
    fn a_step_has_the_window_that_it_fills() {
        let [mean, variance] =
            after((0..100).map(|k| if k < 88 { 0.0 } else { 3e-4 }), Independence::InMotion);
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
            after((0..100).map(|k| if k == 90 { 1.0 } else { 0.0 }), Independence::InMotion);
        assert!(mean.nats < 1.0 && variance.nats < 5.0, "{mean:?} {variance:?}");
    }

    #[test]
    fn a_displacement_of_the_dead_band_is_no_evidence() {
        for length in [1, 5, 20, 80, 300, 2000] {
            let [mean, variance] = after((0..length).map(|_| 1e-4), Independence::InMotion);
            assert!(mean.nats < P.by_dead_band + 1e-9, "{length}: {mean:?}");
            assert_eq!(variance, Peak::default(), "{length}");
        }
    }

    #[test]
    fn what_is_said_twice_is_evidence_once() {
        let twice = counted(1e-4, [[2.0; WIDTHS.len()]; 2], [0.0; 2]);
        for index in 0..WIDTHS.len() {
            let (once, twice) = (scales(1e-4), &twice);
            assert!((once.by_mean(index, 3e-4) / twice.by_mean(index, 3e-4) - 2.0).abs() < 1e-12);
            let [one, half] = [&once, twice].map(|scales| scales.by_square(index, 9e-8));
            assert!((one / half - 2.0).abs() < 1e-12);
        }
    }

    /// Both readings are rounded up or down independently, equally often.
    #[test]
    fn readings_that_lie_between_two_counts_are_no_noise() {
        let tossed = (0..96).map(|k| 4e-4 * f64::from((k & 1) - ((k / 3) & 1)));
        let most = |scales: Scales| {
            let (mut history, clip) = (History::default(), Clip::new(scales.bands()));
            let samples = tossed.clone().map(Sample::at_rest);
            samples.for_each(|sample| history.push(sample, &clip, Independence::InMotion));
            scales.peaks(&history, 1024)[1].nats
        };
        let known = most(counted(1e-4, INDEPENDENT, [4e-4; 2]));
        assert!(most(scales(1e-4)) > 10.0 && known < 1.0, "{known}");
    }

    #[test]
    fn at_rest_only_short_windows_count() {
        let [mean, _] = after((0..100).map(|_| 3e-4), Independence::AtRest);
        assert_eq!(mean.width, AT_REST);
        let nothing = after((0..100).map(|_| 3e-4), Independence::Repeated);
        assert_eq!(nothing, [Peak::default(); 2]);
    }

    #[test]
    fn noise_of_twice_the_deviation_is_in_the_mean_square() {
        let [mean, variance] =
            after((0..64).map(|k| 2e-4 * f64::from(1 - 2 * (k & 1))), Independence::InMotion);
        assert!(mean.nats < 5.0, "{mean:?}");
        let s: f64 = 4.0 - 1.0;
        assert_eq!(variance.width, 64);
        let expected = 32.0 * (s - 1.0 - s.ln());
        assert!((variance.nats / expected - 1.0).abs() < 1e-3, "{variance:?} {expected}");
    }
}
