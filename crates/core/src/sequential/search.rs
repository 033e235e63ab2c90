//! Search for the window with the most evidence, which seldom evaluates a rate function.

use super::samples::{AT_REST, History, MOVING};
use super::statistic::{Peak, Scales, larger};
use super::windows::{Few, NARROW_WINDOWS, Sums, VALUES, WIDE_EVERY, WIDTHS, add};
use crate::state::whole;
use core::ops::Range;

/// Number of windows, the narrowest ones, that are judged by samples at rest, too.
const WINDOWS_AT_REST: usize = 5;

const _: () = assert!(WIDTHS[WINDOWS_AT_REST - 1] <= AT_REST && WIDTHS[WINDOWS_AT_REST] > AT_REST);

impl Scales {
    /// Both statistics, the largest over the windows of at most `widest` samples: w/κ I(|mean| −
    /// ε_w share), and w/κ₂ I₂(mean square − δ), where these are above 0.
    pub fn peaks(&self, history: &History, widest: usize) -> [Peak; 2] {
        self.exhaustive(0..WIDTHS.len(), history, widest)
    }

    /// Both statistics by definition, window by window.
    fn exhaustive(&self, which: Range<usize>, history: &History, widest: usize) -> [Peak; 2] {
        let mut peaks = [Peak::default(); 2];
        for index in which.take_while(|index| WIDTHS[*index] <= widest) {
            let Some(sums) = history.over(WIDTHS[index]) else { continue };
            let (width, window) = (WIDTHS[index], &self.windows[index]);
            let mean = self.mean_nats(window, window.beyond(sums));
            let square = self.square_nats(window, window.square_beyond(sums));
            peaks[0] = larger(peaks[0], Peak { nats: mean, width });
            peaks[1] = larger(peaks[1], Peak { nats: square, width });
        }
        peaks
    }
}

/// The largest of some windows.
#[derive(Clone, Copy, Debug, Default)]
struct Largest {
    peaks: [Peak; 2],
    /// Root of the largest nats.
    root: f64,
}

/// The largest evidence of a growing history.
#[derive(Clone, Copy, Debug, Default)]
pub struct Search {
    /// Number of samples since the wide windows were searched.
    age: u32,
    /// Result of the newest search of the wide windows.
    wide: [Peak; 2],
}

whole! {
    Search { age, wide }
    sound |it| it.age < WIDE_EVERY
}

impl Search {
    /// The largest of both statistics after another sample.
    #[inline]
    pub fn step(&mut self, scales: &Scales, history: &History, widest: usize) -> [Peak; 2] {
        let narrow = scales.narrow(history, widest);
        if self.age == 0 {
            self.wide = scales.wide(history, widest);
        }
        self.age = (self.age + 1) % WIDE_EVERY;
        [larger(narrow[0], self.wide[0]), larger(narrow[1], self.wide[1])]
    }
}

impl Scales {
    /// The largest of both statistics among the narrow windows: the rate function of a window is
    /// evaluated only if its bound exceeds the result of another one.
    fn narrow(&self, history: &History, widest: usize) -> [Peak; 2] {
        let (mut sums, mut largest) = ([0.0; VALUES], Largest::default());
        let (few, reach) = (history.few(), history.few().held().min(widest));
        self.few::<0>(few, reach, &mut sums, &mut largest);
        self.few::<1>(few, reach, &mut sums, &mut largest);
        self.few::<2>(few, reach, &mut sums, &mut largest);
        self.few::<3>(few, reach, &mut sums, &mut largest);
        self.few::<4>(few, reach, &mut sums, &mut largest);
        let (many, reach) = (history.many(), history.many().held().min(widest));
        self.many(WINDOWS_AT_REST, many, reach, &mut largest);
        self.many(WINDOWS_AT_REST + 1, many, reach, &mut largest);
        self.many(WINDOWS_AT_REST + 2, many, reach, &mut largest);
        largest.peaks
    }

    fn wide(&self, history: &History, widest: usize) -> [Peak; 2] {
        let mut largest = Largest::default();
        let (many, reach) = (history.many(), history.many().held().min(widest));
        for index in NARROW_WINDOWS..WIDTHS.len() {
            self.many(index, many, reach, &mut largest);
        }
        largest.peaks
    }

    /// Continues from the `sums` of the previous window. The index is a constant, so that the
    /// compiler unrolls the loop.
    #[inline(always)]
    fn few<const INDEX: usize>(
        &self,
        few: &Few,
        reach: usize,
        sums: &mut [f64; VALUES],
        largest: &mut Largest,
    ) {
        let from = if INDEX == 0 { 0 } else { WIDTHS[INDEX - 1] };
        if WIDTHS[INDEX] <= reach {
            (from..WIDTHS[INDEX]).for_each(|ago| *sums = add(*sums, few.ago(ago)));
            self.weigh(INDEX, *sums, largest);
        }
    }

    #[inline(always)]
    fn many(&self, index: usize, many: &Sums<MOVING>, reach: usize, largest: &mut Largest) {
        if WIDTHS[index] <= reach {
            self.weigh(index, many.newest(WIDTHS[index]), largest);
        }
    }

    #[inline(always)]
    fn weigh(&self, index: usize, sums: [f64; VALUES], largest: &mut Largest) {
        let (width, window) = (WIDTHS[index], &self.windows[index]);
        let beyond = window.beyond(sums);
        if window.root * beyond > largest.root {
            let nats = self.mean_nats(window, beyond);
            if nats > largest.peaks[0].nats {
                (largest.peaks[0], largest.root) = (Peak { nats, width }, libm::sqrt(nats));
            }
        }
        if window.line[0] * sums[1] - window.line[1] > largest.peaks[1].nats {
            let nats = self.square_nats(window, window.square_beyond(sums));
            largest.peaks[1] = larger(largest.peaks[1], Peak { nats, width });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::clip::Clip;
    use super::super::rate::{Magnitudes, Of, Rate};
    use super::super::samples::{Independence, Sample};
    use super::super::statistic::{Bands, DEAD_BAND, Dependence, INDEPENDENT};
    use super::super::wild::Outliers;
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const DEVIATION: f64 = 1e-4;

    fn random() -> ChaCha8Rng {
        ChaCha8Rng::seed_from_u64(9)
    }

    fn fitted(dependence: Dependence) -> Scales {
        let (mut rng, mut magnitudes) = (random(), Magnitudes::new(1e-6));
        for _ in 0..100_000 {
            let normal: f64 = StandardNormal.sample(&mut rng);
            magnitudes.add(DEVIATION * normal);
        }
        let rate = |what| {
            Rate::of(&magnitudes, what, DEVIATION, Outliers::USUAL).expect("there are samples")
        };
        let bands = Bands::new(DEVIATION, DEAD_BAND, [1e-4; 2], Outliers::USUAL);
        Scales::new(rate(Of::Mean), rate(Of::Square), dependence, bands)
    }

    /// Rates that no calibration gives, but a file may contain.
    fn odd(mean: &[f64], square: &[f64]) -> Scales {
        let [mean, square] = [mean, square].map(|values| Rate::new(3e-5, values));
        Scales::new(
            mean,
            square,
            INDEPENDENT,
            Bands::new(DEVIATION, 1e-6, [0.0; 2], Outliers::USUAL),
        )
    }

    /// Residuals: healthy, wild, displaced and noisy samples, at rest and in motion, and a lost
    /// bus.
    fn residuals(count: usize) -> Vec<(Sample, Independence)> {
        let mut rng = random();
        let one = |k: usize| {
            let normal: f64 = StandardNormal.sample(&mut rng);
            let residual = match (k / 700 % 4, rng.random_range(0..100)) {
                (1, _) => normal * DEVIATION + 1.5e-4,
                (2, _) => normal * 3.0 * DEVIATION,
                (_, 0) => -1e-2,
                // As readings that move in counts have them: windows that are as good as others.
                (3, _) => (2.0 * normal).round() * DEVIATION,
                _ => normal * DEVIATION,
            };
            let independence = match rng.random_range(0..10) {
                0 => Independence::Repeated,
                1 => Independence::AtRest,
                _ => Independence::InMotion,
            };
            // Every third place is not known for sure.
            let doubt = if k.is_multiple_of(3) { 1e-8 } else { 0.0 };
            (Sample { residual, share: rng.random_range(0.5..1.0), doubt }, independence)
        };
        (0..count).map(one).collect()
    }

    /// The search gives the same windows as the exhaustive one, and the same nats to the last
    /// digit.
    #[test]
    fn no_window_is_overlooked() {
        let twice = [[1.7; WIDTHS.len()], [2.3; WIDTHS.len()]];
        let stairs = [0.0, 0.0, 0.5, 0.5, 0.2, 3.0, 3.0];
        let all = [
            fitted(INDEPENDENT),
            fitted(twice),
            odd(&stairs, &stairs),
            odd(&[0.0, 1.0, 1.0], &[0.3, 0.4]),
            odd(&[0.7, 0.8], &[0.0, 0.0, 0.0]),
        ];
        let samples = residuals(6000);
        for (which, scales) in all.iter().enumerate() {
            let (clip, mut history) = (Clip::new(scales.bands()), History::default());
            let mut found = 0;
            for (k, (sample, independence)) in samples.iter().enumerate() {
                if k == 4000 {
                    history.clear();
                }
                history.push(*sample, &clip, *independence);
                for widest in [1, 6, 48, 1024] {
                    let narrow = scales.exhaustive(0..NARROW_WINDOWS, &history, widest);
                    let wide = scales.exhaustive(NARROW_WINDOWS..WIDTHS.len(), &history, widest);
                    assert_eq!(scales.narrow(&history, widest), narrow, "{which} {k} {widest}");
                    assert_eq!(scales.wide(&history, widest), wide, "{which} {k} {widest}");
                    found += usize::from(wide[0].nats > 1.0) + usize::from(wide[1].nats > 1.0);
                }
            }
            assert!(found > 1000, "{which}: {found}");
        }
    }

    #[test]
    fn wide_windows_are_looked_at_now_and_then_and_remembered() {
        let (mut history, scales) = (History::default(), fitted(INDEPENDENT));
        let (clip, mut search) = (Clip::new(scales.bands()), Search::default());
        let mut all: Vec<f64> = Vec::new();
        for k in 0..300_usize {
            history.push(
                Sample::at_rest(if k < 40 { 0.0 } else { 1.5e-4 }),
                &clip,
                Independence::InMotion,
            );
            all.push(scales.peaks(&history, 1024)[0].nats);
            let [found, _] = search.step(&scales, &history, 1024);
            let before = all[k.saturating_sub(WIDE_EVERY as usize - 1)];
            assert!(found.nats < all[k] + 1e-9 && found.nats > before - 1e-9, "{k}: {found:?}");
        }
        assert!(all[299] > 20.0, "{}", all[299]);
    }
}
