//! How much of a window is news.
//!
//! A nat of evidence is a factor of e in rarity, if the samples of a window are independent. What
//! repeats the sample before is left out ([`super::novelty`]); how much the others of readings that move in
//! coarse counts have in common is measured, by how much the evidence of healthy windows of each width
//! outgrows its rarity.

use super::rate::Magnitudes;
use super::samples::History;
use super::statistic::{Bands, Dependence, INDEPENDENT, Scales};
use super::windows::WIDTHS;

/// The tail that is looked at: this part of the windows, …
const TAIL: f64 = 0.001;

/// … or what thirty windows without a sample in common have, but no more than this.
const APART: f64 = 30.0;
const MOST: f64 = 0.2;

/// What fewer windows without a sample in common have seen is chance.
const RARE: f64 = 3.0;

/// The first width of the bins of magnitudes, m.
const BIN: f64 = 1e-7;

/// Healthy windows of every width.
#[derive(Clone, Debug)]
pub struct Measuring {
    /// What their means are beyond their dead bands, m.
    means: Vec<Magnitudes>,
    /// Their root mean squares, m.
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
            squares.add((square / width).max(0.0).sqrt());
        }
    }

    /// What came of it, for evidence by `scales` that know no dependence; 1 where there was too
    /// little.
    pub fn dependence(&self, scales: &Scales) -> Dependence {
        let mut dependence = INDEPENDENT;
        for index in 0..WIDTHS.len() {
            let by_mean = |beyond: f64| scales.by_mean(index, beyond);
            let by_square = |root: f64| scales.by_square(index, root * root);
            dependence[0][index] = outgrown(&self.means[index], WIDTHS[index], by_mean);
            dependence[1][index] = outgrown(&self.squares[index], WIDTHS[index], by_square);
        }
        dependence
    }
}

/// How much faster evidence grows than its rarity, in its tail and by its bulk.
fn outgrown(windows: &Magnitudes, width: usize, evidence: impl Fn(f64) -> f64) -> f64 {
    in_tail(windows, width, &evidence).max(by_bulk(windows, width, &evidence))
}

/// The most evidence by the rarity of as much, nats by nats: where readings are a few counts off now and
/// then, for a fraction of a second, all such windows are alike, and their tail says nothing of them.
fn by_bulk(windows: &Magnitudes, width: usize, evidence: &impl Fn(f64) -> f64) -> f64 {
    let all = windows.total() as f64;
    let least = RARE * width as f64;
    let (mut beyond, mut most) = (0.0, 1.0_f64);
    for (magnitude, count) in windows.bins().rev() {
        beyond += count as f64;
        if beyond > MOST * all {
            break;
        }
        if beyond >= least {
            most = most.max(evidence(magnitude) / (all / beyond).ln());
        }
    }
    most
}

/// The mean excess of the evidence in its tail, nats; that of an exponential tail is 1.
fn in_tail(windows: &Magnitudes, width: usize, evidence: &impl Fn(f64) -> f64) -> f64 {
    let all = windows.total() as f64;
    let part = (APART * width as f64 / all).clamp(TAIL, MOST);
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
    use super::super::novelty::News;
    use super::super::rate::{Of, Rate};
    use super::super::samples::Sample;
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
        let bands = Bands::new(DEVIATION, 1e-6, [0.0; 2]);
        let clip = Clip::new(&bands);
        for _ in 0..200_000 / hold {
            let normal: f64 = StandardNormal.sample(&mut rng);
            for _ in 0..hold {
                magnitudes.add(DEVIATION * normal);
                history.push(Sample::at_rest(DEVIATION * normal), &clip, News::InMotion);
                measuring.take(&history, &bands);
            }
        }
        let [mean, square] =
            [Of::Mean, Of::Square].map(|what| Rate::of(&magnitudes, what, DEVIATION));
        let (mean, square) = (mean.expect("there are some"), square.expect("there are some"));
        measuring.dependence(&Scales::new(mean, square, INDEPENDENT, bands))
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
