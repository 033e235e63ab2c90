//! Dependence of the samples in a window.
//!
//! A nat of evidence is a factor of e in rarity if the samples of a window are independent. Samples
//! that repeat the previous one are left out ([`super::thinning`]). The dependence of the others,
//! where readings move in coarse counts, is measured by how much the evidence of healthy windows of
//! each width exceeds its rarity.
//!
//! Where readings are sometimes off for a fraction of a second, two or three such stretches may follow each other and fill
//! a window that one alone does not. The wider windows are therefore composed from the frequencies seen in windows as long
//! as one stretch. And one of C1 may coincide with an opposite one of C2: C1 − C2 is then off by twice as much, a few
//! times an hour on a machine, and hardly ever in the quarter of an hour that teaches. Without this, coarse transducers that
//! fluctuate had a false alarm every two hours.

use super::parameters::{DependenceParameters, EvidenceParameters};
use super::rate::{Magnitudes, Of, Rate};
use super::samples::History;
use super::statistic::{Bands, Dependence, INDEPENDENT, Scales};
use super::windows::WIDTHS;
use alloc::vec::Vec;

const P: &DependenceParameters = &EvidenceParameters::DEFAULT.dependence;

/// The first width of the bins of magnitudes, m.
const BIN: f64 = 1e-7;

/// Healthy windows of every width.
#[derive(Clone, Debug)]
pub struct Measuring {
    /// Means of the windows beyond their dead bands, m.
    means: Vec<Magnitudes>,
    /// Root mean squares of the windows, m.
    squares: Vec<Magnitudes>,
}

impl Default for Measuring {
    fn default() -> Self {
        let bins = || WIDTHS.iter().map(|_| Magnitudes::new(BIN)).collect();
        Self { means: bins(), squares: bins() }
    }
}

impl Measuring {
    /// Takes the windows that end with the newest sample.
    pub fn take(&mut self, history: &History, bands: &Bands) {
        let both = self.means.iter_mut().zip(&mut self.squares);
        for (index, (means, squares)) in both.enumerate() {
            let width = WIDTHS[index] as f64;
            let Some([sum, square, shares, ..]) = history.over(WIDTHS[index]) else { break };
            means.add(bands.beyond(index, sum / width, shares / width));
            squares.add(libm::sqrt((square / width).max(0.0)));
        }
    }

    /// The measured dependence, for evidence by `scales` that assume none; 1 where there were too
    /// few windows.
    pub fn dependence(&self, scales: &Scales) -> Dependence {
        let mut dependence = INDEPENDENT;
        for index in 0..WIDTHS.len() {
            let by_mean = |beyond: f64| scales.by_mean(index, beyond);
            let by_square = |root: f64| scales.by_square(index, root * root);
            dependence[0][index] = outgrown(&self.means[index], WIDTHS[index], by_mean);
            dependence[1][index] = outgrown(&self.squares[index], WIDTHS[index], by_square);
        }
        if let Some(stretch) = stretch(&dependence) {
            self.compose(&mut dependence, stretch, scales);
        }
        dependence
    }

    /// Takes into account that two stretches may coincide, and composes windows wider than that of the index `stretch` from
    /// several of it.
    fn compose(&self, dependence: &mut Dependence, stretch: usize, scales: &Scales) {
        let [means, squares] = dependence;
        for (index, (of_mean, of_square)) in
            means.iter_mut().zip(&mut *squares).enumerate().take(stretch + 1)
        {
            let by_mean = |beyond: f64| scales.by_mean(index, beyond);
            let by_square = |root: f64| scales.by_square(index, root * root);
            *of_mean = of_mean.max(coinciding(&self.means[index], WIDTHS[index], by_mean));
            *of_square = of_square.max(coinciding(&self.squares[index], WIDTHS[index], by_square));
        }
        let level = scales.bands().outliers().least_level();
        let mean = Composed::of(&self.means[stretch], Of::Mean, stretch);
        let square = Composed::of(&self.squares[stretch], Of::Square, stretch);
        let widths = means.iter_mut().zip(squares).enumerate().skip(stretch + 1);
        for (index, (of_mean, of_square)) in widths {
            let by_mean = |beyond: f64| scales.by_mean(index, beyond);
            let by_square = |root: f64| scales.by_square(index, root * root);
            if let Some(mean) = &mean {
                *of_mean = of_mean.max(mean.outgrown(level, index, by_mean));
            }
            if let Some(square) = &square {
                *of_square = of_square.max(square.outgrown(level, index, by_square));
            }
        }
    }
}

/// The index of the window as long as the stretches in which readings are off; `None` where there
/// are none, or they are longer than [`LONGEST`].
fn stretch(dependence: &Dependence) -> Option<usize> {
    let longest = |widths: &[f64; WIDTHS.len()]| {
        let most = widths.iter().copied().fold(1.0, f64::max);
        let last = widths.iter().rposition(|value| *value >= P.nearly * most);
        last.filter(|_| most >= P.stretch)
    };
    let stretch = dependence.iter().filter_map(longest).max();
    stretch.filter(|index| WIDTHS[*index] <= P.longest)
}

/// Windows of one width, of which wider ones are composed.
struct Composed {
    rate: Rate,
    width: usize,
    /// Value that at least a few of the windows had, m.
    largest: f64,
}

impl Composed {
    fn of(windows: &Magnitudes, what: Of, index: usize) -> Option<Self> {
        let (width, mut beyond) = (WIDTHS[index], 0.0);
        let least = P.rare * width as f64;
        let few = |(_, count): &(f64, u64)| {
            beyond += *count as f64;
            beyond >= least
        };
        let (largest, _) = windows.bins().rev().find(few)?;
        Some(Self { rate: Rate::seen(windows, what)?, width, largest })
    }

    /// Factor by which `evidence` of the window of `index` exceeds what its parts are worth, at
    /// this `level`, nats, where it matters.
    fn outgrown(&self, level: f64, index: usize, evidence: impl Fn(f64) -> f64) -> f64 {
        let parts = WIDTHS[index] as f64 / self.width as f64;
        let most = parts * self.rate.at(self.largest);
        if most >= level {
            return (evidence(self.at(level / parts)) / level).max(1.0);
        }
        // Stretches may fill the window, and others may coincide with them; but none is larger than the largest seen.
        let least = evidence(self.largest) / most;
        let both = if 2.0 * most < level {
            evidence(2.0 * self.largest) / (2.0 * most)
        } else {
            evidence(self.largest + self.at((level - most) / parts)) / level
        };
        least.max(both).max(1.0)
    }

    /// The value with a rarity of `nats`, m, at most the largest.
    fn at(&self, nats: f64) -> f64 {
        let (mut low, mut high) = (0.0, self.largest);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if self.rate.at(middle) < nats {
                low = middle;
            } else {
                high = middle;
            }
        }
        high
    }
}

/// Factor by which evidence grows faster than its rarity, in its tail and by its bulk.
fn outgrown(windows: &Magnitudes, width: usize, evidence: impl Fn(f64) -> f64) -> f64 {
    in_tail(windows, width, &evidence).max(by_bulk(windows, width, &evidence))
}

/// Largest ratio of evidence to its rarity, in nats: where readings are sometimes a few counts off
/// for a fraction of a second, all such windows are alike, and their tail says nothing of them.
fn by_bulk(windows: &Magnitudes, width: usize, evidence: &impl Fn(f64) -> f64) -> f64 {
    rarities(windows, width)
        .fold(1.0, |most, (magnitude, rarity)| most.max(evidence(magnitude) / rarity))
}

/// The same of one that coincides with the largest that was seen: as far off as both together, and as rare.
fn coinciding(windows: &Magnitudes, width: usize, evidence: impl Fn(f64) -> f64) -> f64 {
    let Some((largest, with_it)) = rarities(windows, width).next() else { return 1.0 };
    rarities(windows, width).fold(1.0, |most, (magnitude, rarity)| {
        most.max(evidence(largest + magnitude) / (with_it + rarity))
    })
}

/// Magnitudes that some of the windows exceed but not many, the largest first, and how rare it is that they do, nats.
fn rarities(windows: &Magnitudes, width: usize) -> impl Iterator<Item = (f64, f64)> + '_ {
    let all = windows.total() as f64;
    let least = P.rare * width as f64;
    let exceeded = windows.bins().rev().scan(0.0, |beyond, (magnitude, count)| {
        *beyond += count as f64;
        Some((magnitude, *beyond))
    });
    exceeded
        .take_while(move |(_, beyond)| *beyond <= P.most * all)
        .filter(move |(_, beyond)| *beyond >= least)
        .map(move |(magnitude, beyond)| (magnitude, libm::log(all / beyond)))
}

/// Mean excess of the evidence in its tail, nats; 1 for an exponential tail.
fn in_tail(windows: &Magnitudes, width: usize, evidence: &impl Fn(f64) -> f64) -> f64 {
    let all = windows.total() as f64;
    let part = (P.apart * width as f64 / all).clamp(P.tail, P.most);
    let (mut beyond, mut sum) = (0.0, 0.0);
    for (magnitude, count) in windows.bins().rev() {
        let (nats, count) = (evidence(magnitude), count as f64);
        if beyond + count > part * all {
            // The floor of the tail.
            return if beyond > 0.0 { (sum / beyond - nats).max(1.0) } else { 1.0 };
        }
        beyond += count;
        sum += nats * count;
    }
    1.0
}

#[cfg(test)]
mod tests {
    use super::super::clip::Clip;
    use super::super::rate::{Of, Rate};
    use super::super::samples::{Independence, Sample};
    use super::super::statistic::DEAD_BAND;
    use super::super::wild::Outliers;
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const DEVIATION: f64 = 1e-4;

    /// Residuals that stay as they are for `hold` samples.
    fn dependence(hold: usize) -> Dependence {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let (mut history, mut measuring) = (History::default(), Measuring::default());
        let mut magnitudes = Magnitudes::new(1e-6);
        let bands = Bands::new(DEVIATION, 1e-6, [0.0; 2], Outliers::USUAL);
        let clip = Clip::new(&bands);
        for _ in 0..200_000 / hold {
            let normal: f64 = StandardNormal.sample(&mut rng);
            for _ in 0..hold {
                magnitudes.add(DEVIATION * normal);
                history.push(Sample::at_rest(DEVIATION * normal), &clip, Independence::InMotion);
                measuring.take(&history, &bands);
            }
        }
        let [mean, square] = [Of::Mean, Of::Square]
            .map(|what| Rate::of(&magnitudes, what, DEVIATION, Outliers::USUAL));
        let (mean, square) = (mean.expect("there are some"), square.expect("there are some"));
        measuring.dependence(&Scales::new(mean, square, INDEPENDENT, bands))
    }

    /// Residuals that are sometimes off by five deviations for ten samples, in either direction.
    struct Fluctuating(ChaCha8Rng, u32, f64);

    impl Iterator for Fluctuating {
        type Item = f64;

        fn next(&mut self) -> Option<f64> {
            use rand::RngExt as _;
            let normal: f64 = StandardNormal.sample(&mut self.0);
            let chance: f64 = self.0.random();
            if self.1 == 0 && chance < 1e-3 {
                (self.1, self.2) = (10, if chance < 5e-4 { 5.0 } else { -5.0 });
            }
            let off = if self.1 > 0 { self.2 } else { 0.0 };
            self.1 = self.1.saturating_sub(1);
            Some(DEVIATION * (normal + off))
        }
    }

    /// Stretches seen in the first quarter of an hour are known afterwards, even where two or three
    /// of them coincide: in two hours there are hundreds of those.
    #[test]
    fn stretches_that_come_together_are_expected() {
        let bands = Bands::new(DEVIATION, DEAD_BAND, [0.0; 2], Outliers::USUAL);
        let clip = Clip::new(&bands);
        let (mut history, mut measuring) = (History::default(), Measuring::default());
        let mut magnitudes = Magnitudes::new(1e-6);
        let mut residuals = Fluctuating(ChaCha8Rng::seed_from_u64(8), 0, 0.0);
        let mut push = |history: &mut History| {
            let residual = residuals.next().expect("it never ends");
            history.push(Sample::at_rest(residual), &clip, Independence::InMotion);
            residual
        };
        for _ in 0..45_000 {
            magnitudes.add(push(&mut history));
            measuring.take(&history, &bands);
        }
        let [mean, square] = [Of::Mean, Of::Square]
            .map(|what| Rate::of(&magnitudes, what, DEVIATION, Outliers::USUAL));
        let (mean, square) = (mean.expect("there are some"), square.expect("there are some"));
        let scales =
            |dependence| Scales::new(mean.clone(), square.clone(), dependence, bands.clone());
        let dependence = measuring.dependence(&scales(INDEPENDENT));
        assert!(dependence[0][9] > 3.0, "{dependence:?}");
        assert!(dependence[0][19] < 2.0, "20 s are many of them: {dependence:?}");
        let scales = scales(dependence);
        let mut most = 0.0_f64;
        for k in 0..450_000 {
            push(&mut history);
            if k % 4 == 0 {
                let [mean, square] = scales.peaks(&history, 1024);
                most = most.max(mean.nats).max(square.nats);
            }
        }
        assert!((4.0..0.75 * Outliers::USUAL.least_level()).contains(&most), "{most}");
        // What stays is found within a second.
        for _ in 0..50 {
            history.push(Sample::at_rest(5.0 * DEVIATION), &clip, Independence::InMotion);
        }
        let [mean, _] = scales.peaks(&history, 1024);
        assert!(mean.nats > Outliers::USUAL.least_level(), "{mean:?}");
    }

    /// A hundred of ten thousand windows are 1 m off, nearly nothing the others.
    fn stretches() -> Magnitudes {
        let mut windows = Magnitudes::new(1e-3);
        (0..10_000).for_each(|k| windows.add(if k % 100 == 0 { 1.0 } else { 1e-3 }));
        windows
    }

    /// C1 up and C2 down at once: twice as far off and as rare as both, which nobody has seen yet.
    #[test]
    fn two_stretches_that_coincide_are_as_rare_as_both() {
        let (windows, evidence) = (stretches(), |x: f64| 9.0 * x * x);
        let rarity = 100_f64.ln();
        assert!((by_bulk(&windows, 1, &evidence) - 9.0 / rarity).abs() < 0.01);
        assert!((coinciding(&windows, 1, evidence) - 36.0 / (2.0 * rarity)).abs() < 0.02);
        let composed = Composed::of(&windows, Of::Mean, 5).expect("there are some");
        let most = 1.5 * composed.rate.at(composed.largest);
        // Half as long again as one of them: at a high level all that two of them show, at a low one a part of that.
        let [high, low] =
            [3.0 * most, 1.5 * most].map(|level| composed.outgrown(level, 6, evidence));
        assert!((high - evidence(2.0 * composed.largest) / (2.0 * most)).abs() < 1e-9, "{high}");
        let of_one = evidence(composed.largest) / most;
        assert!(of_one < low && low < evidence(2.0 * composed.largest) / (1.5 * most), "{low}");
    }

    #[test]
    fn independent_samples_are_all_news() {
        let [mean, square] = dependence(1);
        for (index, width) in WIDTHS.into_iter().enumerate().take(12) {
            assert!(mean[index] < 1.2 && square[index] < 1.3, "{width}: {mean:?} {square:?}");
        }
    }

    #[test]
    fn of_what_stays_for_five_samples_one_in_five_is_news() {
        let [mean, square] = dependence(5);
        for (index, width) in WIDTHS.into_iter().enumerate().skip(5).take(7) {
            assert!((2.5..6.0).contains(&mean[index]), "{width}: {mean:?}");
            assert!((2.0..6.0).contains(&square[index]), "{width}: {square:?}");
        }
        assert!(mean[0] < 1.2, "{mean:?}");
    }
}
