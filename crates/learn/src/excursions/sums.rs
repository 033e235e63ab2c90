//! Limits of sums over windows: clipped residuals, squares, and the number of samples that are off and elsewhere than the one
//! before.
//!
//! Chernoff's bound: a sum of w samples is beyond B with a chance of at most exp(K(θ) − θ B), for every θ > 0, where K is the
//! logarithm of its exponential moment. The limit is the least B that one θ gives for the wanted chance.

use super::noise::CoreNoise;
use super::renewal::log_moments;
use super::survival::Survival;
use tertius_core::sequential::excursions::OFF;

/// Ends of the first clip, m, and deviations at which it is between them.
const CLIP: [f64; 2] = [0.25e-3, 0.6e-3];
const CLIP_DEVIATIONS: f64 = 3.3;
/// Deviations of the second clip above the largest usual excursion, and its least multiple of the first clip.
const SECOND_DEVIATIONS: f64 = 2.0;
const SECOND_FACTOR: f64 = 1.5;
/// Deviations of the third clip above two of the largest usual excursions.
const THIRD_DEVIATIONS: f64 = 3.5;
/// Least third clip, and the second one without excursions, m.
const WIDE_CLIP: f64 = 1.25e-3;

/// Displacements, m, that are no fault, for windows up to these numbers of samples: profile and baseline follow the rod, the more the
/// longer it takes.
const DEAD_BANDS: [(usize, f64); 4] =
    [(8, 0.01e-3), (24, 0.02e-3), (64, 0.05e-3), (usize::MAX, 0.1e-3)];

/// Least share of wild samples.
const LEAST_WILD: f64 = 0.01;
/// Wild samples that are allowed for over those that were measured.
const WILD_FACTOR: f64 = 2.0;

/// Ends and number of the θ that are tried, in geometric order: 1/mm for sums and 1/mm² for squares.
const TILTS: ([f64; 2], usize) = ([0.02, 150.0], 70);
/// A millimetre, m: unit of [`TILTS`].
const MILLIMETRE: f64 = 1e-3;
/// The same for counts. A bound on a few samples asks for closer θ: of 12 counts in 64 samples this grid loses 0.02, and that
/// of [`TILTS`] would lose 0.05.
const COUNT_TILTS: ([f64; 2], usize) = ([0.2, 10.0], 60);

/// The clips of residuals of this deviation and of excursions of which 95 % are not larger than `size`, m; `size` is `None`
/// without excursions. Without them there are two clips, else three.
pub fn clips(deviation: f64, size: Option<f64>) -> Vec<f64> {
    let first = (CLIP_DEVIATIONS * deviation).clamp(CLIP[0], CLIP[1]);
    let Some(size) = size else { return vec![first, WIDE_CLIP] };
    let second = (size + SECOND_DEVIATIONS * deviation).max(SECOND_FACTOR * first);
    let third = (2.0 * size + THIRD_DEVIATIONS * deviation).max(WIDE_CLIP);
    vec![first, second, third]
}

/// What adds up in health. Residuals are those that are weighted by the deviation at their speed.
#[derive(Clone, Debug)]
pub struct SumLimits<'a> {
    core: &'a CoreNoise,
    /// `None` where there are no excursions. Its tables reach to the widest window.
    survival: Option<Survival>,
    /// Overlaps of two excursions, where they are counted by themselves.
    overlaps: Option<Survival>,
    /// Share of wild samples that is allowed for.
    wild: f64,
}

impl<'a> SumLimits<'a> {
    /// Sums of this core, these excursions and this measured share of wild samples.
    pub fn new(core: &'a CoreNoise, survival: Option<Survival>, wild_share: f64) -> Self {
        let wild = (WILD_FACTOR * wild_share).clamp(LEAST_WILD, 1.0);
        Self { core, survival, overlaps: None, wild }
    }

    /// The same with overlaps of two excursions counted by themselves.
    ///
    /// Without them the gain of an overlap is the sum of the gains of both. That is too little where wild samples are most of
    /// the moment: a gain is then near 0 for one excursion and large for two at once, and limits between the levels of one
    /// and two are exceeded more often than wanted.
    #[must_use]
    pub fn with_overlaps(self) -> Self {
        Self { overlaps: self.survival.as_ref().map(Survival::overlaps), ..self }
    }

    /// Limits of the sum of residuals clipped to ± `clip`, m, that are reached in one direction less than once in e^`level`
    /// samples, m, for each of `widths`, samples.
    pub fn clipped(&self, clip: f64, level: f64, widths: &[usize]) -> Vec<f64> {
        let log_moment = |tilt: f64, offset: f64| {
            // e^(θ clip) is taken out of everything, so that nothing overflows.
            let calm = self.core.clipped_exponential(tilt, offset, clip);
            let wild = 0.5 * (1.0 + (-2.0 * tilt * clip).exp());
            tilt * clip + ((1.0 - self.wild) * calm + self.wild * wild).ln()
        };
        let (unit, directions) = (MILLIMETRE, 1.0);
        let summand = Summand { most: clip, unit, directions, dead_band: 1.0, log_moment };
        self.limits(&summand, level, widths)
    }

    /// Limits of the sum of squares of these residuals, m²; each is at most the square of `clip`.
    pub fn squares(&self, clip: f64, level: f64, widths: &[usize]) -> Vec<f64> {
        let most = clip * clip;
        let log_moment = |tilt: f64, offset: f64| {
            let below = |residual: f64| most - (residual + offset).powi(2);
            // Most bins of an excursion are beyond the clip, and need no exponential.
            let moment = |below: f64| if below > 0.0 { (-tilt * below).exp() } else { 1.0 };
            let calm = self.core.expectation(|residual| moment(below(residual)));
            tilt * most + ((1.0 - self.wild) * calm + self.wild).ln()
        };
        // Excursions of both directions add to a square.
        let (unit, directions) = (MILLIMETRE * MILLIMETRE, 2.0);
        let summand = Summand { most, unit, directions, dead_band: 0.5, log_moment };
        self.limits(&summand, level, widths)
    }

    /// Limits of the number of samples that are off, and elsewhere than the one before, by three of their deviations, which
    /// is `deviation`, m, for a single sample.
    pub fn elsewhere(&self, deviation: f64, level: f64, widths: &[usize]) -> Vec<f64> {
        let chance = self.survival.as_ref().map_or(0.0, Survival::chance);
        let length = self.survival.as_ref().map_or(0.0, Survival::mean_length);
        // Excursions of two transducers in two directions; a wild sample within one is elsewhere, and the next is again.
        let begin = 4.0 * chance;
        let once = (self.wild + self.core.beyond(OFF * deviation) + begin).min(1.0);
        let twice = self.wild * (begin * length).min(1.0);
        let mut limits = unreachable(widths, 1.0);
        for tilt in tilts(COUNT_TILTS, 1.0) {
            let each = (once * tilt.exp_m1() + twice * (2.0 * tilt).exp_m1()).ln_1p();
            for (limit, width) in limits.iter_mut().zip(widths) {
                *limit = limit.min((level + *width as f64 * each) / tilt);
            }
        }
        limits
    }

    /// Limits of the sum of `summand` that are reached less than once in e^`level` samples, for each of `widths`.
    fn limits<F: Fn(f64, f64) -> f64>(
        &self,
        summand: &Summand<F>,
        level: f64,
        widths: &[usize],
    ) -> Vec<f64> {
        let mut limits = unreachable(widths, summand.most);
        let mut narrowest = 0;
        for (widest, dead_band) in DEAD_BANDS {
            let displacement = summand.dead_band * dead_band;
            let alike = |at: &usize| (narrowest..=widest).contains(&widths[*at]);
            let places: Vec<_> = (0..widths.len()).filter(alike).collect();
            for tilt in if places.is_empty() { Vec::new() } else { tilts(TILTS, summand.unit) } {
                let calm = (summand.log_moment)(tilt, displacement);
                // Excursions only add to the exponent: without them it must already be low enough.
                let bound = |width: usize| (level + width as f64 * calm) / tilt;
                let lower = |at: &usize| bound(widths[*at]) < limits[*at];
                let lower: Vec<_> = places.iter().copied().filter(lower).collect();
                let some: Vec<_> = lower.iter().map(|at| widths[*at]).collect();
                let added = self.excursions(summand, tilt, displacement, calm, &some);
                for (at, added) in lower.into_iter().zip(added) {
                    // An infinite exponent leaves the limit as it is.
                    limits[at] = limits[at].min(bound(widths[at]) + added / tilt);
                }
            }
            narrowest = widest.saturating_add(1);
        }
        limits
    }

    /// What excursions add to K(θ) for each of `widths`, where the residual is displaced by a dead band, m, and ln M(0) is
    /// `calm`.
    fn excursions<F: Fn(f64, f64) -> f64>(
        &self,
        summand: &Summand<F>,
        tilt: f64,
        displacement: f64,
        calm: f64,
        widths: &[usize],
    ) -> Vec<f64> {
        let mut exponents = vec![0.0; widths.len()];
        if widths.is_empty() {
            return exponents;
        }
        // Two transducers that do not depend on each other.
        let kinds = [(self.survival.as_ref(), 2.0), (self.overlaps.as_ref(), 1.0)];
        for (kind, times) in kinds.into_iter().filter_map(|(kind, times)| Some((kind?, times))) {
            let gain =
                |size: &f64| ((summand.log_moment)(tilt, size + displacement) - calm).max(0.0);
            let gains: Vec<_> = kind.sizes().iter().map(gain).collect();
            let chance = summand.directions * kind.chance();
            let moments = log_moments(kind, chance, &gains, widths);
            exponents.iter_mut().zip(moments).for_each(|(exponent, x)| *exponent += times * x);
        }
        exponents
    }
}

/// What is added up.
struct Summand<F: Fn(f64, f64) -> f64> {
    /// The largest value.
    most: f64,
    /// Unit of the values; θ is in its inverse.
    unit: f64,
    /// Number of directions in which excursions add to the sum.
    directions: f64,
    /// Part of the dead band that displaces the residual.
    dead_band: f64,
    /// ln M(a): logarithm of the exponential moment of a sample at θ and an offset a, m.
    log_moment: F,
}

/// The θ that are tried, in the inverse of `unit`.
fn tilts(([first, last], count): ([f64; 2], usize), unit: f64) -> Vec<f64> {
    let ratio = |i: usize| i as f64 / (count - 1) as f64;
    (0..count).map(|i| first * (last / first).powf(ratio(i)) / unit).collect()
}

/// Limits that sums of values up to `most` cannot reach: those where no θ gives a bound.
fn unreachable(widths: &[usize], most: f64) -> Vec<f64> {
    widths.iter().map(|width| 2.0 * most * (*width).max(1) as f64).collect()
}
