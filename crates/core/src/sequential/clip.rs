//! How much of one sample counts.

use super::statistic::Bands;

/// Beyond these a sample counts no more: there a wild one is taken to be ([`super::wild`]), and what it
/// is farther off proves nothing more. The evidence of a window is convex in its sum, so that no window
/// makes more of a wild sample than that of one sample does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clip {
    /// Of the weighed residual, m.
    pub farthest: f64,
    /// Of its square, m².
    pub square: f64,
}

impl Clip {
    /// For statistics with these `bands`.
    pub fn new(bands: &Bands) -> Self {
        let farthest = bands.farthest();
        Self {
            farthest: farthest + bands.dead_band(),
            square: farthest * farthest + bands.spread_band(),
        }
    }

    /// Nothing is clipped.
    pub const NONE: Self = Self { farthest: f64::INFINITY, square: f64::INFINITY };
}

#[cfg(test)]
mod tests {
    use super::super::novelty::News;
    use super::super::rate::{Magnitudes, Of, Rate};
    use super::super::samples::{History, Sample};
    use super::super::statistic::{DEAD_BAND, INDEPENDENT, Scales};
    use super::super::wild::SHARE;
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const DEVIATION: f64 = 1e-4;

    /// Of a calibration of an hour without a wild sample.
    fn scales() -> Scales {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut magnitudes = Magnitudes::new(1e-6);
        for _ in 0..180_000 {
            let normal: f64 = StandardNormal.sample(&mut rng);
            magnitudes.add(DEVIATION * normal);
        }
        let [mean, square] =
            [Of::Mean, Of::Square].map(|what| Rate::of(&magnitudes, what, DEVIATION));
        let (mean, square) = (mean.expect("there are some"), square.expect("there are some"));
        Scales::new(mean, square, INDEPENDENT, Bands::new(DEVIATION, DEAD_BAND, [0.0; 2]))
    }

    /// The most of both statistics after healthy samples, with a wild one in the place of each of
    /// `wild`, of that size.
    fn most(wild: &[usize], size: f64) -> f64 {
        let scales = scales();
        let clip = Clip::new(scales.bands());
        let mut history = History::default();
        let mut most = 0.0_f64;
        for k in 0..1500_usize {
            let healthy = if k % 2 == 0 { 0.5 * DEVIATION } else { -0.5 * DEVIATION };
            let residual = if wild.contains(&k) { size } else { healthy };
            history.push(Sample::at_rest(residual), &clip, News::InMotion);
            let [mean, variance] = scales.peaks(&history, 1024);
            most = most.max(mean.nats).max(variance.nats);
        }
        most
    }

    /// However they follow each other, k wild samples are no more than k times as much as one.
    #[test]
    fn wild_samples_prove_no_more_than_how_many_they_are() {
        let each = (2.0 / SHARE).ln();
        let (together, scattered) = ([500, 501, 502, 503], [500, 502, 505, 506]);
        for size in [4e-4, 1e-3, -5e-3, 1.0] {
            for count in 1..=4 {
                for places in [together, scattered] {
                    let most = most(&places[..count], size);
                    // The healthy ones between them are on one side, too.
                    assert!(most <= each * count as f64 + 0.5, "{count} of {size}: {most}");
                }
            }
            assert!(most(&together[..1], size) > 0.6 * each, "{size}");
        }
    }

    #[test]
    fn five_in_a_row_are_a_fault() {
        let row: Vec<usize> = (500..505).collect();
        for size in [6e-4, -5e-3, 1.0] {
            assert!(most(&row, size) > 19.5, "{size}: {}", most(&row, size));
        }
    }
}
