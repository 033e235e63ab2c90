//! The generalised Pareto distribution, fitted to excesses by maximum likelihood (Coles, *An Introduction to Statistical
//! Modeling of Extreme Values*, section 4.3).

/// Range of shapes. Outside it the likelihood has no meaningful maximum: below, it grows without
/// bound at the largest excess; above, the tail has no mean, and some tens of peaks cannot tell one
/// such tail from another.
const SHAPES: std::ops::RangeInclusive<f64> = -0.5..=1.5;

/// The generalised Pareto distribution of excesses: P(X > x) = (1 + ξ x / σ)^(−1/ξ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pareto {
    /// Shape ξ; above 0 the tail is heavier than an exponential one.
    pub shape: f64,
    /// Scale σ, in the unit of the excesses.
    pub scale: f64,
    /// Maximum of the log-likelihood.
    pub likelihood: f64,
}

impl Pareto {
    /// The maximum-likelihood fit to `excesses`, none negative; `None` where all are zero.
    ///
    /// With τ = ξ/σ the best ξ is the mean of ln(1 + τ x) (Grimshaw 1993), so that only τ is
    /// searched; τ max x = eᶻ − 1 puts all of them on one line with the exponential at z = 0.
    pub fn fit(excesses: &[f64]) -> Option<Self> {
        let largest = excesses.iter().copied().fold(0.0, f64::max);
        if !(largest > 0.0 && largest.is_finite()) {
            return None;
        }
        let at = |z: f64| Self::profile(excesses, z.exp_m1() / largest);
        let grid = (-50..=200).map(|i| 0.1 * f64::from(i));
        let better = |a: &f64, b: &f64| at(*a).likelihood.total_cmp(&at(*b).likelihood);
        let best = grid.max_by(better)?;
        Some(at(golden(best - 0.1, best + 0.1, |z| at(z).likelihood)))
    }

    fn profile(excesses: &[f64], tau: f64) -> Self {
        let count = excesses.len() as f64;
        let mean = excesses.iter().sum::<f64>() / count;
        if (tau * mean).abs() < 1e-9 {
            return Self { shape: 0.0, scale: mean, likelihood: -count * (mean.ln() + 1.0) };
        }
        let shape = excesses.iter().map(|x| (tau * x).ln_1p()).sum::<f64>() / count;
        let scale = shape / tau;
        let likelihood = -count * (scale.ln() + shape + 1.0);
        let sound = SHAPES.contains(&shape) && likelihood.is_finite();
        Self { shape, scale, likelihood: if sound { likelihood } else { f64::NEG_INFINITY } }
    }

    /// The excess that is exceeded with a probability of exp(−`nats`).
    pub(super) fn excess(&self, nats: f64) -> f64 {
        let straight = self.shape.abs() < 1e-12;
        let times = if straight { nats } else { (self.shape * nats).exp_m1() / self.shape };
        self.scale * times
    }

    /// Log-probability ln P(X > x).
    pub(super) fn log_beyond(&self, excess: f64) -> f64 {
        if self.shape.abs() < 1e-12 {
            return -excess / self.scale;
        }
        let inside = self.shape * excess / self.scale;
        if inside <= -1.0 { f64::NEG_INFINITY } else { -inside.ln_1p() / self.shape }
    }
}

/// The place of the maximum of `f` between `low` and `high`, as near as it was tried: where `f` ends in −∞ right beside
/// its maximum, a place between two that were tried may be beyond the edge.
fn golden(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let part = (5_f64.sqrt() - 1.0) / 2.0;
    let (mut left, mut right) = (high - part * (high - low), low + part * (high - low));
    let (mut f_left, mut f_right) = (f(left), f(right));
    while high - low > 1e-9 {
        if f_left < f_right {
            (low, left, f_left) = (left, right, f_right);
            right = low + part * (high - low);
            f_right = f(right);
        } else {
            (high, right, f_right) = (right, left, f_left);
            left = high - part * (high - low);
            f_left = f(left);
        }
    }
    if f_left < f_right { right } else { left }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Peaks that are as likely anywhere up to an end have the least shape there is, at which the likelihood is cut off. On
    /// which side of it rounding falls decides nothing.
    #[test]
    fn rounding_decides_nothing_at_the_least_shape() {
        for count in 50..350_u32 {
            let excesses = |scale: f64| -> Vec<f64> {
                (0..count).map(|k| scale * (f64::from(k) + 0.5) / f64::from(count)).collect()
            };
            for scale in [1.0, 1.0 + 1e-14, 3e-4] {
                let fit = Pareto::fit(&excesses(scale)).expect("not all are zero");
                assert!(
                    SHAPES.contains(&fit.shape) && fit.likelihood.is_finite(),
                    "{count}: {fit:?}"
                );
                assert!((fit.shape - SHAPES.start()).abs() < 1e-6, "{count}: {fit:?}");
            }
        }
    }
}
