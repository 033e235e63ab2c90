//! Rate functions: the improbability of a mean on a healthy cylinder.

use super::wild::Outliers;
use alloc::vec;
use alloc::vec::Vec;

/// The bins of a [`Magnitudes`].
const BINS: usize = 512;

/// So many bins are one in [`Rate::seen`].
const SEEN: usize = 8;

/// Nodes of a [`Rate`] beside that at zero.
const NODES: usize = 48;

/// The largest tilt that is looked at, in units of 1/largest: beyond it the rate has its bound.
const STEEPEST: f64 = 200.0;

/// The distribution of the magnitude of healthy residuals, as bins that widen when they must.
/// Memory does not grow.
#[derive(Clone, Debug)]
pub struct Magnitudes {
    width: f64,
    counts: Vec<u64>,
    total: u64,
    squares: f64,
    largest: f64,
}

impl Magnitudes {
    /// A distribution whose bins begin with the width `width`, m.
    pub fn new(width: f64) -> Self {
        Self { width, counts: vec![0; BINS], total: 0, squares: 0.0, largest: 0.0 }
    }

    /// Takes a residual, m; one that is not finite is not taken.
    pub fn add(&mut self, residual: f64) {
        let magnitude = residual.abs();
        if !magnitude.is_finite() {
            return;
        }
        while magnitude >= self.width * BINS as f64 {
            for i in 0..BINS / 2 {
                self.counts[i] = self.counts[2 * i] + self.counts[2 * i + 1];
            }
            self.counts[BINS / 2..].fill(0);
            self.width *= 2.0;
        }
        self.counts[(magnitude / self.width) as usize] += 1;
        self.total += 1;
        self.squares += magnitude * magnitude;
        self.largest = self.largest.max(magnitude);
    }

    /// The bins that are not empty, in order: the middle, m, and the count.
    pub fn bins(&self) -> impl DoubleEndedIterator<Item = (f64, u64)> + '_ {
        let filled = self.counts.iter().enumerate().filter(|(_, count)| **count > 0);
        filled.map(|(i, count)| ((i as f64 + 0.5) * self.width, *count))
    }

    pub const fn total(&self) -> u64 {
        self.total
    }

    /// Largest magnitude, m.
    pub const fn largest(&self) -> f64 {
        self.largest
    }

    /// Root mean square, m.
    pub fn deviation(&self) -> f64 {
        libm::sqrt(self.squares / self.total.max(1) as f64)
    }
}

/// Chernoff's rate function I of the healthy residual, or of its square: the mean of w independent ones
/// is beyond x with a probability of at most exp(−w I(x)).
///
/// It is made from the residuals of a calibration, one more because the largest has not been seen,
/// and a share of wild ones ([`super::wild`]), all of them as far off as a sample counts. No
/// Gaussian is assumed: readings that move in counts have none. It is a table from 0 in steps of
/// `spacing`, with the last value beyond its end: a single sample, however far off, is at most as
/// much evidence as wild samples are rare.
#[derive(Clone, Debug, PartialEq)]
pub struct Rate {
    spacing: f64,
    /// Steps in a metre: multiplying takes a third of the time of dividing.
    density: f64,
    /// Values of √I, and the increment to the next node: between two nodes √I is nearly linear, as
    /// that of a normal distribution is.
    roots: Vec<[f64; 2]>,
    /// Length of the table, steps.
    end: f64,
    /// Value of I beyond the table, nats.
    bound: f64,
}

/// Quantity that is averaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Of {
    /// The residual, whose distribution is taken as symmetrical. x is the magnitude of the mean, m.
    Mean,
    /// The square of the residual. x is the root of the mean square, m.
    Square,
}

impl Rate {
    /// The table that begins with I(0) and has a value every `spacing`, m; nats, at least 2 of them
    /// and none negative.
    pub fn new(spacing: f64, values: &[f64]) -> Self {
        let root = |value: &f64| libm::sqrt(value.max(0.0));
        let next = values.iter().skip(1).chain(values.last()).map(root);
        let roots: Vec<[f64; 2]> =
            values.iter().map(root).zip(next).map(|(root, next)| [root, next - root]).collect();
        let bound = roots.last().map_or(0.0, |[root, _]| root * root);
        let end = roots.len().saturating_sub(1) as f64;
        Self { spacing, density: 1.0 / spacing, end, roots, bound }
    }

    /// The rate function of `magnitudes` of residuals that scatter by `noise` at rest, m, some of
    /// which may be `outliers`; `None` without magnitudes.
    pub fn of(magnitudes: &Magnitudes, what: Of, noise: f64, outliers: Outliers) -> Option<Self> {
        let farthest = outliers.reach() * noise;
        if magnitudes.total == 0 || farthest <= 0.0 {
            return None;
        }
        let part = (1.0 - outliers.share) / (magnitudes.total as f64 + 1.0);
        let mut points: Vec<(f64, f64)> = magnitudes
            .counts
            .iter()
            .enumerate()
            .filter(|(_, count)| **count > 0)
            // The outer edge of a bin: rather too wide than too narrow.
            .map(|(i, count)| ((i as f64 + 1.0) * magnitudes.width, *count as f64 * part))
            .filter(|(magnitude, _)| *magnitude < farthest)
            .collect();
        let near: f64 = points.iter().map(|(_, share)| share).sum();
        points.push((farthest, 1.0 - near));
        Some(Self::conjugate(&points, what, farthest))
    }

    /// The rate function of `magnitudes` that were seen so often that nothing else is expected;
    /// `None` without magnitudes.
    pub fn seen(magnitudes: &Magnitudes, what: Of) -> Option<Self> {
        let all = magnitudes.total as f64;
        let chunks = magnitudes.counts.chunks(SEEN).enumerate();
        let points: Vec<(f64, f64)> = chunks
            .map(|(i, counts)| (((i + 1) * SEEN) as f64 * magnitudes.width, counts.iter().sum()))
            .filter(|(_, count): &(f64, u64)| *count > 0)
            .map(|(magnitude, count)| (magnitude, count as f64 / all))
            .collect();
        let (farthest, _) = *points.last()?;
        Some(Self::conjugate(&points, what, farthest))
    }

    /// The rate function of magnitudes, m, and their shares, up to the `farthest`.
    fn conjugate(points: &[(f64, f64)], what: Of, farthest: f64) -> Self {
        let spacing = farthest / NODES as f64;
        let at = |x: f64| match what {
            Of::Mean => conjugate(points, x / farthest, farthest, |tilt, r| {
                0.5 * (libm::exp(tilt * (r - 1.0)) + libm::exp(-tilt * (r + 1.0)))
            }),
            Of::Square => {
                let share = x / farthest;
                let grown = |tilt: f64, r: f64| libm::exp(tilt * (r * r - 1.0));
                conjugate(points, share * share, farthest, grown)
            }
        };
        let mut values: Vec<f64> = (0..=NODES).map(|i| at(i as f64 * spacing)).collect();
        values[0] = 0.0;
        for i in 1..values.len() {
            values[i] = values[i].max(values[i - 1]);
        }
        Self::new(spacing, &values)
    }

    /// Distance between nodes, m.
    pub const fn spacing(&self) -> f64 {
        self.spacing
    }

    /// The table, nats; it begins with 0 and never falls.
    pub fn values(&self) -> Vec<f64> {
        self.roots.iter().map(|[root, _]| root * root).collect()
    }

    /// Value beyond which one sample is no more evidence, m.
    pub fn farthest(&self) -> f64 {
        self.spacing * (self.roots.len() - 1) as f64
    }

    /// Value x₀ up to which I is 0, m.
    pub fn silent(&self) -> f64 {
        let zeros = self.roots.iter().take_while(|[root, _]| *root == 0.0).count();
        self.spacing * zeros.saturating_sub(1) as f64
    }

    /// Largest ratio M of I(x) to x² − `from`², 1/m², where `from` is a node up to which I is 0, m;
    /// infinite where I(0) is not 0.
    ///
    /// √I = a + bx between two nodes, and the derivative of (a + bx)²/(x² − from²) has the sign of
    /// −(a + bx)(b·from² + ax). With a ≥ 0 the ratio falls, and with a < 0 it falls and then rises: so it
    /// is largest at one of both nodes, or nothing at `from` itself. Beyond the table it falls.
    pub fn steepest(&self, from: f64) -> f64 {
        if self.roots.first().is_some_and(|[root, _]| *root > 0.0) {
            return f64::INFINITY;
        }
        let beyond = (0..).zip(&self.roots).filter(|(_, [root, _])| *root > 0.0);
        let along = |(i, [root, _]): (u32, &[f64; 2])| {
            let x = f64::from(i) * self.spacing;
            root * root / (x * x - from * from)
        };
        beyond.map(along).fold(0.0, f64::max)
    }

    /// The least x with I(x) of `nats`, m; `None` if there is none.
    pub fn reaches(&self, nats: f64) -> Option<f64> {
        let wanted = libm::sqrt(nats.max(0.0));
        let node = self.roots.iter().position(|[root, _]| *root >= wanted)?;
        let Some([root, more]) = node.checked_sub(1).map(|before| self.roots[before]) else {
            return Some(0.0);
        };
        Some(self.spacing * (node as f64 - 1.0 + (wanted - root) / more))
    }

    /// The rate I(x), nats, at least 0; `x` in m, at least 0.
    #[inline]
    pub fn at(&self, x: f64) -> f64 {
        let along = x * self.density;
        if along >= self.end {
            return self.bound;
        }
        // As u32, which becomes a float again in one instruction, and a usize in six.
        let node = along as u32;
        let [root, more] = self.roots[node as usize];
        let root = root + (along - f64::from(node)) * more;
        root * root
    }
}

/// Supremum over λ > 0 of λx − ln E exp(λ …), by golden section: the function is concave.
/// Everything is in units of the farthest value or of its square; `grown` is the exponential less
/// exp(λ).
fn conjugate(points: &[(f64, f64)], x: f64, farthest: f64, grown: impl Fn(f64, f64) -> f64) -> f64 {
    let value = |tilt: f64| {
        // Without overflow: exp(λ) is taken out of the sum.
        let sum: f64 = points.iter().map(|(r, p)| p * grown(tilt, r / farthest)).sum();
        tilt * x - tilt - libm::log(sum)
    };
    let golden = 0.5 * (libm::sqrt(5.0) - 1.0);
    // The tilt that matters can be small against the tail: search its logarithm.
    let (mut low, mut high) = (libm::log(1e-4), libm::log(STEEPEST));
    for _ in 0..80 {
        let inner = [high - golden * (high - low), low + golden * (high - low)];
        if value(libm::exp(inner[0])) < value(libm::exp(inner[1])) {
            low = inner[0];
        } else {
            high = inner[1];
        }
    }
    value(libm::exp(0.5 * (low + high))).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    const USUAL: Outliers = Outliers::USUAL;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const SIGMA: f64 = 1e-4;

    fn normal(samples: u64) -> Magnitudes {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut magnitudes = Magnitudes::new(1e-6);
        for _ in 0..samples {
            let z: f64 = StandardNormal.sample(&mut rng);
            magnitudes.add(SIGMA * z);
        }
        magnitudes
    }

    /// For a normal distribution it is x²/2σ², less the effect of wild samples.
    #[test]
    fn of_a_normal_distribution_it_is_nearly_a_parabola() {
        let rate = Rate::of(&normal(200_000), Of::Mean, SIGMA, USUAL).expect("there are samples");
        for z in [0.3_f64, 0.5, 1.0, 1.5, 2.0] {
            let (found, expected) = (rate.at(z * SIGMA), z * z / 2.0);
            assert!((0.8..1.01).contains(&(found / expected)), "{z}: {found} for {expected}");
        }
    }

    /// For the square of a normal residual it is (ρ − 1 − ln ρ)/2 with ρ = mean square/σ², and
    /// nothing below 1.
    #[test]
    fn of_a_normal_distributions_square_it_is_less_than_that_of_its_variance() {
        let rate = Rate::of(&normal(200_000), Of::Square, SIGMA, USUAL).expect("there are samples");
        assert!(rate.at(0.97 * SIGMA) < 1e-3, "{}", rate.at(0.97 * SIGMA));
        for rho in [1.5_f64, 2.0, 3.0, 5.0] {
            let (found, expected) = (rate.at(rho.sqrt() * SIGMA), 0.5 * (rho - 1.0 - rho.ln()));
            assert!((0.3..1.01).contains(&(found / expected)), "{rho}: {found} for {expected}");
        }
    }

    #[test]
    fn one_sample_is_no_more_evidence_than_it_is_rare_to_be_wild() {
        let of = |what| Rate::of(&normal(200_000), what, SIGMA, USUAL).expect("there are samples");
        for x in [1e-3, 1.0, f64::INFINITY] {
            let (mean, square) = (of(Of::Mean).at(x), of(Of::Square).at(x));
            assert!((mean - (2.0 / USUAL.share).ln()).abs() < 0.2, "{mean}");
            assert!((square - (1.0 / USUAL.share).ln()).abs() < 0.2, "{square}");
        }
    }

    /// Wild samples that the calibration has seen are expected, too.
    #[test]
    fn wild_samples_that_were_seen_prove_less() {
        let mut magnitudes = normal(100_000);
        (0..5000).for_each(|_| magnitudes.add(5e-3));
        let rate = Rate::of(&magnitudes, Of::Mean, SIGMA, USUAL).expect("there are samples");
        let expected = (2.0_f64 / (USUAL.share + 5.0 / 105.0)).ln();
        assert!((rate.at(1.0) - expected).abs() < 0.05, "{} for {expected}", rate.at(1.0));
    }

    /// Of n samples none was wild, which says that one of n + 1 may be.
    #[test]
    fn few_samples_prove_little() {
        for samples in [1.0, 9.0, 99.0] {
            let rate = Rate::of(&normal(samples as u64), Of::Mean, SIGMA, USUAL);
            let (found, wild) = (rate.expect("there are samples").at(1.0), 1.0 / (samples + 1.0));
            let expected = (2.0 / (wild + USUAL.share * (1.0 - wild))).ln();
            assert!((found - expected).abs() < 0.05, "{samples}: {found} for {expected}");
        }
    }

    #[test]
    fn it_is_steepest_where_it_is_most_for_its_square() {
        let rate = Rate::new(0.5, &[0.0, 0.0, 0.25, 4.0, 4.5]);
        // At nodes of 1, 1.5 and 2 m: 1/3, 2 and 6/5 of what is beyond 0.5 m.
        for (from, expected) in [(0.5, 4.0 / (2.25 - 0.25)), (0.0, 4.0 / 2.25)] {
            assert!((rate.steepest(from) - expected).abs() < 1e-12, "{}", rate.steepest(from));
        }
        assert_eq!(Rate::new(0.5, &[0.1, 0.2]).steepest(0.0), f64::INFINITY);
        assert_eq!((rate.silent(), rate.farthest()), (0.5, 2.0));
    }

    #[test]
    fn where_it_reaches_what_it_is_there() {
        for what in [Of::Mean, Of::Square] {
            let rate = Rate::of(&normal(200_000), what, SIGMA, USUAL).expect("there are samples");
            for nats in [0.01, 1.0, 2.5, 4.0] {
                let x = rate.reaches(nats).expect("one sample is worth more");
                assert!((rate.at(x) - nats).abs() < 1e-9, "{nats}: {x}");
            }
            assert_eq!((rate.reaches(0.0), rate.reaches(9.0)), (Some(0.0), None));
        }
    }

    #[test]
    fn it_never_falls_and_nothing_gives_nothing() {
        let rate = Rate::of(&normal(1000), Of::Mean, SIGMA, USUAL).expect("there are samples");
        assert!(rate.values().is_sorted() && rate.values()[0] == 0.0);
        assert_eq!(Rate::of(&Magnitudes::new(1e-6), Of::Mean, SIGMA, USUAL), None);
    }

    #[test]
    fn wider_bins_lose_no_sample() {
        let mut magnitudes = Magnitudes::new(1e-6);
        [1e-7, 3e-4, 5.0, f64::NAN, -2e-3].into_iter().for_each(|r| magnitudes.add(r));
        assert_eq!(magnitudes.counts.iter().sum::<u64>(), 4);
        assert_eq!((magnitudes.total(), magnitudes.largest()), (4, 5.0));
    }
}
