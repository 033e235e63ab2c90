//! Tests whether residuals are white: auto-correlation, cross-correlation with the input,
//! Ljung–Box.

use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::collections::VecDeque;

/// Number of lags, cycles: half a second at 50 Hz.
pub const LAGS: usize = 25;

/// Two-sided 99 % of the normal distribution.
const NORMAL_99: f64 = 2.575_829_303_548_900_4;

#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    count: u64,
    x: f64,
    y: f64,
    xy: f64,
}

impl Sum {
    fn add(&mut self, x: f64, y: f64) {
        self.count += 1;
        self.x += x;
        self.y += y;
        self.xy += x * y;
    }

    /// Σ(x − x̄)(y − ȳ) with the means over all values.
    fn centred(&self, mean_x: f64, mean_y: f64) -> f64 {
        self.xy - mean_x * self.y - mean_y * self.x + self.count as f64 * mean_x * mean_y
    }
}

/// Correlations of one residual with itself and with the input, over consecutive cycles.
#[derive(Clone, Debug)]
pub struct Correlator {
    /// Newest values first, at most `LAGS` + 1.
    newest: VecDeque<(f64, f64)>,
    residual: Sum,
    input: Sum,
    auto: [Sum; LAGS + 1],
    /// Sums of e(k) u(k − τ).
    after: [Sum; LAGS + 1],
    /// Sums of e(k − τ) u(k).
    before: [Sum; LAGS + 1],
}

/// The tests of Figure 4-9.
#[derive(Clone, Debug, PartialEq)]
pub struct Whiteness {
    pub count: u64,
    /// Auto-correlation r_ee(τ), τ = 0..[`LAGS`].
    pub auto: Vec<f64>,
    /// Cross-correlation r_eu(τ) of e(k) with u(k − τ), τ = −[`LAGS`]..[`LAGS`]. For positive τ the
    /// input came first; for negative τ it followed, as in a closed loop.
    pub cross: Vec<f64>,
    /// Bound of the correlations: 99 % of those of white noise lie within ± this.
    pub bound: f64,
    /// Q of Ljung and Box over [`LAGS`] lags.
    pub ljung_box: f64,
    /// Probability that white noise has a larger Q.
    pub p_value: f64,
}

impl Correlator {
    pub fn new() -> Self {
        Self {
            newest: VecDeque::with_capacity(LAGS + 2),
            residual: Sum::default(),
            input: Sum::default(),
            auto: [Sum::default(); LAGS + 1],
            after: [Sum::default(); LAGS + 1],
            before: [Sum::default(); LAGS + 1],
        }
    }

    /// Adds the residual and the input of the next cycle.
    pub fn add(&mut self, residual: f64, input: f64) {
        self.newest.push_front((residual, input));
        self.newest.truncate(LAGS + 1);
        self.residual.add(residual, residual);
        self.input.add(input, input);
        for (lag, (old_residual, old_input)) in self.newest.iter().enumerate() {
            self.auto[lag].add(residual, *old_residual);
            self.after[lag].add(residual, *old_input);
            self.before[lag].add(*old_residual, input);
        }
    }

    /// Reports that the next cycle does not follow.
    pub fn gap(&mut self) {
        self.newest.clear();
    }

    /// The tests; `None` for a constant, or with fewer than four times as many values as lags.
    pub fn whiteness(&self) -> Option<Whiteness> {
        let count = self.residual.count;
        let n = count as f64;
        let (mean_e, mean_u) = (self.residual.x / n, self.input.x / n);
        let energy_e = self.residual.centred(mean_e, mean_e);
        let energy_u = self.input.centred(mean_u, mean_u);
        if count < 4 * LAGS as u64 || !(energy_e > 0.0 && energy_u > 0.0) {
            return None;
        }
        let auto: Vec<f64> =
            self.auto.iter().map(|sum| sum.centred(mean_e, mean_e) / energy_e).collect();
        let size = (energy_e * energy_u).sqrt();
        let cross = |sum: &Sum| sum.centred(mean_e, mean_u) / size;
        let before = self.before[1..].iter().rev().map(cross);
        let cross: Vec<f64> = before.chain(self.after.iter().map(cross)).collect();
        let weighted = (1..).zip(&auto[1..]).map(|(lag, r)| r * r / (n - f64::from(lag)));
        let ljung_box = n * (n + 2.0) * weighted.sum::<f64>();
        let p_value = ChiSquared::new(LAGS as f64).ok()?.sf(ljung_box);
        Some(Whiteness { count, auto, cross, bound: NORMAL_99 / n.sqrt(), ljung_box, p_value })
    }
}

impl Default for Correlator {
    fn default() -> Self {
        Self::new()
    }
}

impl Whiteness {
    /// Number of auto-correlations beyond the bound; for white noise one in a hundred is.
    pub fn auto_beyond(&self) -> usize {
        self.auto[1..].iter().filter(|r| r.abs() > self.bound).count()
    }

    /// Number of cross-correlations beyond the bound, with inputs of the same or an earlier cycle.
    pub fn cross_beyond(&self) -> usize {
        self.cross[LAGS..].iter().filter(|r| r.abs() > self.bound).count()
    }

    /// Whether the residual passes for white noise at 1 %.
    pub fn is_white(&self) -> bool {
        self.p_value >= 0.01
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn noise(generator: &mut ChaCha8Rng) -> f64 {
        (0..12).map(|_| f64::from(generator.next_u32()) / f64::from(u32::MAX)).sum::<f64>() - 6.0
    }

    #[test]
    fn white_noise_passes_and_a_coloured_one_does_not() {
        let mut generator = ChaCha8Rng::seed_from_u64(9);
        let (mut white, mut coloured) = (Correlator::new(), Correlator::new());
        let mut slow = 0.0;
        for k in 0..20_000 {
            if k % 5000 == 0 {
                white.gap();
                coloured.gap();
            }
            let (e, u) = (noise(&mut generator), noise(&mut generator));
            slow = 0.6 * slow + e;
            white.add(e + 3.0, u);
            coloured.add(slow, u);
        }
        let white = white.whiteness().expect("enough");
        assert!(white.is_white() && white.auto_beyond() <= 2 && white.cross_beyond() <= 2);
        assert!((white.auto[0] - 1.0).abs() < 1e-12 && white.cross.len() == 2 * LAGS + 1);
        let coloured = coloured.whiteness().expect("enough");
        assert!(!coloured.is_white() && (coloured.auto[1] - 0.6).abs() < 0.03, "{coloured:?}");
        assert!((coloured.auto[3] - 0.216).abs() < 0.04, "{coloured:?}");
    }

    #[test]
    fn the_input_of_before_is_told_from_that_of_after() {
        let mut generator = ChaCha8Rng::seed_from_u64(3);
        let mut correlator = Correlator::new();
        let mut inputs = VecDeque::from([0.0; 4]);
        for _ in 0..5000 {
            inputs.push_front(noise(&mut generator));
            inputs.truncate(4);
            correlator.add(inputs[3], inputs[0]);
        }
        let found = correlator.whiteness().expect("enough");
        assert!((found.cross[LAGS + 3] - 1.0).abs() < 0.01, "{found:?}");
        assert!(found.cross[LAGS - 3].abs() < 0.05);
    }

    #[test]
    fn a_constant_has_no_answer() {
        let mut correlator = Correlator::new();
        (0..1000).for_each(|k| correlator.add(0.5, f64::from(k)));
        assert_eq!(correlator.whiteness(), None);
    }
}
