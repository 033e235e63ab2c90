//! Correlated errors, made independent of each other.
//!
//! A valve that differs from its drive does so for several cycles, so that the second error of the same sign
//! proves little. Linear prediction (Levinson, 1947; Durbin, 1960) subtracts from each error what the ones
//! before it predict of it.

/// Number of errors that the next one is predicted from.
pub const ORDER: usize = 6;

/// A linear predictor of the next error by the newest ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Whitening {
    /// Weight of the error so many cycles before, from one on.
    coefficients: [f64; ORDER],
    /// Variance that is left by the variance before, 0 to 1.
    left: f64,
}

impl Whitening {
    /// No prediction: the errors are independent already.
    pub const NONE: Self = Self { coefficients: [0.0; ORDER], left: 1.0 };

    /// Predictor of errors with this `correlation` between those that are 1, 2, … cycles apart; `None` if
    /// no errors can have it, because the ones before would predict the next one exactly or better.
    pub fn of(correlation: &[f64; ORDER]) -> Option<Self> {
        let mut whitening = Self::NONE;
        for order in 0..ORDER {
            let known = &whitening.coefficients[..order];
            let predicted: f64 =
                known.iter().zip(correlation[..order].iter().rev()).map(|(c, r)| c * r).sum();
            let reflection = (correlation[order] - predicted) / whitening.left;
            if reflection.is_nan() || reflection.abs() >= 1.0 {
                return None;
            }
            let before = whitening.coefficients;
            for (place, coefficient) in whitening.coefficients[..order].iter_mut().enumerate() {
                *coefficient -= reflection * before[order - 1 - place];
            }
            whitening.coefficients[order] = reflection;
            whitening.left *= 1.0 - reflection * reflection;
        }
        Some(whitening)
    }

    /// Variance of the unpredicted part as a fraction of the variance of the errors, 0 to 1.
    pub const fn left(&self) -> f64 {
        self.left
    }

    /// The part of the error `now` that the ones before do not predict; `before` gives the one so many
    /// cycles before.
    pub fn unpredicted(&self, now: f64, before: impl Fn(usize) -> f64) -> f64 {
        let terms = (1..).zip(self.coefficients);
        terms.fold(now, |rest, (cycles, coefficient)| rest - coefficient * before(cycles))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// Correlation of the values that are so many places apart.
    fn correlation(values: &[f64], apart: usize) -> f64 {
        let products = |apart: usize| -> f64 {
            values.iter().zip(&values[apart..]).map(|(one, other)| one * other).sum()
        };
        products(apart) / products(0)
    }

    #[test]
    fn errors_that_swing_are_made_independent() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut errors = vec![0.0; 20_000];
        for k in 2..errors.len() {
            let noise: f64 = StandardNormal.sample(&mut rng);
            errors[k] = 1.2 * errors[k - 1] - 0.6 * errors[k - 2] + noise;
        }
        let correlations = core::array::from_fn(|place| correlation(&errors, place + 1));
        let whitening = Whitening::of(&correlations).expect("they are of such errors");
        let [first, second, ..] = whitening.coefficients;
        assert!((first - 1.2).abs() < 0.03 && (second + 0.6).abs() < 0.03, "{whitening:?}");
        let rests: Vec<f64> = (ORDER..errors.len())
            .map(|k| whitening.unpredicted(errors[k], |cycles| errors[k - cycles]))
            .collect();
        let variance = |values: &[f64]| {
            values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64
        };
        assert!((variance(&rests) - 1.0).abs() < 0.03, "{}", variance(&rests));
        assert!((variance(&rests) / variance(&errors) - whitening.left()).abs() < 0.01);
        for apart in 1..=ORDER {
            assert!(correlation(&rests, apart).abs() < 0.03, "{apart}");
        }
    }

    #[test]
    fn independent_errors_are_left_as_they_are() {
        let whitening = Whitening::of(&[0.0; ORDER]).expect("there are such errors");
        assert_eq!(whitening, Whitening::NONE);
        assert_eq!(whitening.unpredicted(0.3, |_| 7.0), 0.3);
    }

    #[test]
    fn correlations_that_nothing_has_are_refused() {
        for first in [1.0, -1.0, 1.5, f64::NAN] {
            assert_eq!(Whitening::of(&[first, 0.0, 0.0, 0.0, 0.0, 0.0]), None, "{first}");
        }
        // Alike from one cycle to the next, but not two cycles apart.
        assert_eq!(Whitening::of(&[0.9, -0.9, 0.0, 0.0, 0.0, 0.0]), None);
    }
}
