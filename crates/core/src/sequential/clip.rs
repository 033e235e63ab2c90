//! Limits of a single sample's contribution.

use super::parameters::OutlierParameters;
use super::statistic::{Bands, Scales};
use super::wild::Frequency;
use super::windows::window_of;
use crate::state::state;

/// The window of several wild samples.
const OF_SEVERAL: usize = window_of(OutlierParameters::DEFAULT.several);

/// Values beyond which a sample contributes no more: a wild one is assumed to lie there
/// ([`super::wild`]), and greater distance proves nothing more. The evidence of a window is convex
/// in its sum, so that a wild sample contributes no more to any window than it does alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clip {
    /// Limit of the weighted residual, m.
    pub farthest: f64,
    /// Limit of its square, m².
    pub square: f64,
}

impl Clip {
    /// Limits for statistics with these `bands`.
    pub fn new(bands: &Bands) -> Self {
        let farthest = bands.farthest();
        Self {
            farthest: farthest + bands.dead_band(),
            square: farthest * farthest + bands.spread_band(),
        }
    }

    /// Limits where wild samples are frequent: each contributes less, so that several in a row,
    /// which lose less to the dead band than one alone, contribute no more than in proportion to
    /// their number.
    pub fn of_frequent(scales: &Scales) -> Self {
        let bands = scales.bands();
        let [mean, square] = bands.outliers().evidence_of_frequent();
        let farthest = |nats: Option<f64>| nats.unwrap_or(f64::INFINITY).min(bands.farthest());
        let root = farthest(scales.square().reaches(square));
        Self {
            farthest: farthest(scales.mean().reaches(mean)) + bands.dead_band_of(OF_SEVERAL),
            square: root * root + bands.spread_band(),
        }
    }

    /// Nothing is clipped.
    pub const NONE: Self = Self { farthest: f64::INFINITY, square: f64::INFINITY };
}

/// The clipping of samples in a stream.
#[derive(Clone, Debug)]
pub struct Clipping {
    usual: Clip,
    of_frequent: Clip,
    frequency: Frequency,
}

state! {
    Clipping { frequency }
    but { usual, of_frequent }
}

impl Clipping {
    /// A clipping for statistics by `scales`.
    pub fn new(scales: &Scales) -> Self {
        let bands = scales.bands();
        Self {
            usual: Clip::new(bands),
            of_frequent: Clip::of_frequent(scales),
            frequency: Frequency::new(bands.outliers(), bands.farthest()),
        }
    }

    /// Limits while there are no more wild samples than expected.
    pub const fn usual(&self) -> &Clip {
        &self.usual
    }

    /// Takes a weighted sample that is part of no fault, m: it may be wild.
    #[inline]
    pub fn take(&mut self, weighed: f64) {
        self.frequency.take(weighed);
    }

    /// Limits for the newest sample.
    #[inline]
    pub fn clip(&self) -> &Clip {
        if self.frequency.is_high() { &self.of_frequent } else { &self.usual }
    }
}

#[cfg(test)]
mod tests {
    use super::super::rate::{Magnitudes, Of, Rate};
    use super::super::samples::{History, Independence, Sample};
    use super::super::statistic::{DEAD_BAND, INDEPENDENT, Scales};
    use super::super::wild::Outliers;
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const DEVIATION: f64 = 1e-4;

    /// Scales from a calibration of an hour without a wild sample.
    fn scales(outliers: Outliers) -> Scales {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut magnitudes = Magnitudes::new(1e-6);
        for _ in 0..180_000 {
            let normal: f64 = StandardNormal.sample(&mut rng);
            magnitudes.add(DEVIATION * normal);
        }
        let [mean, square] =
            [Of::Mean, Of::Square].map(|what| Rate::of(&magnitudes, what, DEVIATION, outliers));
        let (mean, square) = (mean.expect("there are some"), square.expect("there are some"));
        Scales::new(mean, square, INDEPENDENT, Bands::new(DEVIATION, DEAD_BAND, [0.0; 2], outliers))
    }

    /// The maximum of both statistics after healthy samples, with a wild one in the place of each
    /// of `wild`, of that size.
    fn most(scales: &Scales, clip: &Clip, wild: &[usize], size: f64) -> f64 {
        let mut history = History::default();
        let mut most = 0.0_f64;
        for k in 0..1500_usize {
            let healthy = if k % 2 == 0 { 0.5 * DEVIATION } else { -0.5 * DEVIATION };
            let residual = if wild.contains(&k) { size } else { healthy };
            history.push(Sample::at_rest(residual), clip, Independence::InMotion);
            let [mean, variance] = scales.peaks(&history, 1024);
            most = most.max(mean.nats).max(variance.nats);
        }
        most
    }

    /// Positions of some wild samples, in a row and scattered, with their directions and sizes.
    fn places(count: usize) -> impl Iterator<Item = (Vec<usize>, f64)> {
        let rows = [[500, 501, 502, 503], [500, 502, 505, 506]];
        let of = move |row: [usize; 4]| {
            [4e-4, 1e-3, -5e-3, 1.0].map(|size| (row[..count].to_vec(), size))
        };
        rows.into_iter().flat_map(of)
    }

    /// In whatever order they come, k wild samples contribute at most k times as much as one.
    #[test]
    fn wild_samples_prove_no_more_than_how_many_they_are() {
        for outliers in [Outliers::UNSAID, Outliers::USUAL, Outliers::LEAST] {
            let scales = scales(outliers);
            let (clip, each) = (Clip::new(scales.bands()), outliers.evidence());
            for (places, size) in (1..=4).flat_map(places) {
                let (most, count) = (most(&scales, &clip, &places, size), places.len() as f64);
                // The healthy ones between them are on one side, too.
                assert!(most <= each * count + 0.5, "{outliers:?}: {places:?} of {size}: {most}");
            }
            assert!(most(&scales, &clip, &[500], 5e-3) > 0.6 * each, "{outliers:?}");
        }
    }

    /// Where they are frequent, four of them stay below the level by more than a healthy one may
    /// add.
    #[test]
    fn of_frequent_ones_four_prove_nothing() {
        for outliers in [Outliers::UNSAID, Outliers::USUAL, Outliers::LEAST] {
            let scales = scales(outliers);
            let (clip, level) = (Clip::of_frequent(&scales), outliers.least_level());
            for (places, size) in places(4) {
                let most = most(&scales, &clip, &places, size);
                assert!(most < level - 2.5, "{outliers:?}: {places:?} of {size}: {most}");
            }
        }
    }

    /// A stream is clipped by the limits that fit how often its samples are wild.
    #[test]
    fn frequent_wild_samples_count_less() {
        let scales = scales(Outliers::USUAL);
        let after = |every: usize| {
            let mut clipping = Clipping::new(&scales);
            for k in 0..30_000_usize {
                clipping.take(if k.is_multiple_of(every) { 5e-3 } else { 0.0 });
            }
            *clipping.clip()
        };
        assert_eq!(after(1000), Clip::new(scales.bands()));
        assert_eq!(after(30), Clip::of_frequent(&scales));
        assert!(after(30).farthest < after(1000).farthest);
    }

    /// How many in a row it takes depends on how many are expected, and on how many there are.
    #[test]
    fn a_few_in_a_row_are_a_fault() {
        let shares =
            [(Outliers::UNSAID, [6, 6]), (Outliers::USUAL, [4, 6]), (Outliers::LEAST, [3, 6])];
        for (outliers, counts) in shares {
            let (scales, level) = (scales(outliers), outliers.least_level());
            let clips = [Clip::new(scales.bands()), Clip::of_frequent(&scales)];
            for (clip, count) in clips.iter().zip(counts) {
                for size in [7e-4, -5e-3, 1.0] {
                    let row: Vec<usize> = (500..500 + count).collect();
                    let found = most(&scales, clip, &row, size);
                    assert!(found > level, "{outliers:?} {size}: {found}");
                }
            }
        }
    }
}
