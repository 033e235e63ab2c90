//! The core: healthy residuals outside of excursions, as a histogram.
//!
//! A histogram takes the noise as it is. A fitted normal distribution would be wrong where readings are rounded.

/// Histogram of magnitudes; both signs are equally likely.
#[derive(Clone, Debug, PartialEq)]
pub struct CoreNoise {
    /// Width of a bin, m.
    pub bin: f64,
    /// Shares, which add up to 1; share i is at the magnitude (i + ½) `bin`.
    pub shares: Vec<f64>,
}

impl CoreNoise {
    /// The core of these numbers of samples by bins of `bin` m; `None` without a sample or without a width.
    pub fn of_counts(bin: f64, counts: &[u64]) -> Option<Self> {
        let total: f64 = counts.iter().map(|count| *count as f64).sum();
        let last = counts.iter().rposition(|count| *count > 0)?;
        let shares = counts[..=last].iter().map(|count| *count as f64 / total).collect();
        (bin > 0.0 && bin.is_finite()).then_some(Self { bin, shares })
    }

    /// Expectation of a function of the signed residual, m.
    pub fn expectation(&self, function: impl Fn(f64) -> f64) -> f64 {
        let at = |(i, share): (usize, &f64)| {
            let magnitude = (i as f64 + 0.5) * self.bin;
            0.5 * share * (function(magnitude) + function(-magnitude))
        };
        self.shares.iter().enumerate().map(at).sum()
    }

    /// Probability of a magnitude beyond `limit`, m.
    pub fn beyond(&self, limit: f64) -> f64 {
        self.expectation(|residual| f64::from(residual.abs() > limit)).min(1.0)
    }

    /// E exp(`rate` (ψ(residual + `shift`) − `clip`)), where ψ clips to ± `clip`; `rate` is in 1/m, not negative, `shift`
    /// and `clip` are in m. At most 1, so that it cannot overflow.
    ///
    /// Neighbouring bins differ by one factor. Therefore the bins inside of the clips are summed as a polynomial, which takes
    /// one multiplication a bin instead of an exponential.
    pub fn clipped_exponential(&self, rate: f64, shift: f64, clip: f64) -> f64 {
        let first = self.rank(-clip - shift);
        let last = self.rank(clip - shift).max(first);
        let half = self.shares.len();
        // Signed bins in ascending order: the negative ones come first, from the largest magnitude on.
        let negative = |range: std::ops::Range<usize>| {
            self.shares[half - range.end.min(half)..half - range.start.min(half)].iter().rev()
        };
        let positive = |range: std::ops::Range<usize>| {
            self.shares[range.start.saturating_sub(half)..range.end.saturating_sub(half)].iter()
        };
        let all = |range: std::ops::Range<usize>| negative(range.clone()).chain(positive(range));
        let (below, above): (f64, f64) = (all(0..first).sum(), all(last..2 * half).sum());
        let factor = (-rate * self.bin).exp();
        let step = |sum: f64, share: &f64| sum * factor + share;
        let inside = positive(first..last).fold(negative(first..last).fold(0.0, step), step);
        let top = (last as f64 - half as f64 - 0.5) * self.bin + shift - clip;
        let inside = if last > first { inside * (rate * top).min(0.0).exp() } else { 0.0 };
        0.5 * (below * (-2.0 * rate * clip).exp() + inside + above)
    }

    /// Number of signed bins with a centre at or below `residual`, m.
    fn rank(&self, residual: f64) -> usize {
        let half = self.shares.len();
        let rank = (residual / self.bin + half as f64 + 0.5).floor();
        // A negative number or none at all becomes 0.
        (rank as usize).min(2 * half)
    }
}

/// Distribution function of a core.
#[derive(Clone, Debug, PartialEq)]
pub struct Cumulative {
    bin: f64,
    /// Probability of a signed residual at or below the centre of each signed bin, in ascending order.
    sums: Vec<f64>,
}

impl Cumulative {
    /// The distribution function of `core`.
    pub fn of(core: &CoreNoise) -> Self {
        let signed = core.shares.iter().rev().chain(&core.shares);
        let sums = signed.scan(0.0, |sum, share| {
            *sum += 0.5 * share;
            Some(*sum)
        });
        Self { bin: core.bin, sums: sums.collect() }
    }

    /// Probability of a signed residual above `low` and not above `high`, m; an infinite `high` is none.
    pub fn between(&self, low: f64, high: f64) -> f64 {
        (self.up_to(high) - self.up_to(low)).clamp(0.0, 1.0)
    }

    /// Probability of a residual up to `residual`, m: straight lines between the sums at the centres of the bins.
    ///
    /// A sum at a centre has its whole bin. Residuals are thereby taken as half a bin lower than they are, which has to be
    /// little beside the drift that is added to them.
    fn up_to(&self, residual: f64) -> f64 {
        let place = residual / self.bin + 0.5 * self.sums.len() as f64 - 0.5;
        // Also where `residual` is no number.
        if place.is_nan() || place < 0.0 {
            return 0.0;
        }
        let Some(pair) = self.sums.get(place as usize..) else { return 1.0 };
        match *pair {
            [sum, next, ..] => sum + (next - sum) * place.fract(),
            _ => 1.0,
        }
    }
}
