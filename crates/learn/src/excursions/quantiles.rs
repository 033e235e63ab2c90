//! Quantiles of the gamma and the Poisson distribution: upper bounds of a rate of which a number of events was seen, and of a
//! number of which the mean is known. Every input has a bounded answer, so that no recording stops the learning.

use statrs::distribution::{ContinuousCDF, DiscreteCDF, Gamma, Poisson};

/// Shapes and means beyond this are not those of a recording.
const LARGEST: f64 = 1e6;

/// The value that a gamma variable of scale 1 does not exceed with this `probability`. Its `shape` is limited to between 1/2 and a
/// million; NaN counts as the least shape, or probability.
pub fn gamma_quantile(probability: f64, shape: f64) -> f64 {
    let shape = if shape.is_nan() { 0.5 } else { shape.clamp(0.5, LARGEST) };
    let probability = if probability.is_nan() { 0.0 } else { probability.clamp(0.0, 1.0 - 1e-12) };
    Gamma::new(shape, 1.0).map_or(shape, |gamma| gamma.inverse_cdf(probability))
}

/// The least number that a Poisson variable of this `mean` does not exceed with this `probability`; `most` at most.
pub fn poisson_quantile(probability: f64, mean: f64, most: u32) -> u32 {
    if mean.is_nan() || mean <= 0.0 || probability.is_nan() || probability <= 0.0 {
        return 0;
    }
    if mean > LARGEST || probability >= 1.0 {
        return most;
    }
    let quantile = Poisson::new(mean).map_or(u64::from(most), |it| it.inverse_cdf(probability));
    u32::try_from(quantile).unwrap_or(most).min(most)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of `SciPy` 1.17: `scipy.stats.gamma.ppf(0.8, a)` and `scipy.stats.poisson.ppf(0.99, mean)`.
    #[test]
    fn as_scipy() {
        for (shape, expected) in [
            (1.0, 1.609_437_912_434_100_5),
            (1.5, 2.320_813_838_043_725),
            (2.0, 2.994_308_347_002_123_2),
            (4.5, 6.121_072_734_923_535),
            (26.0, 30.165_790_326_262_74),
            (46.0, 51.589_481_871_592_61),
            (150.5, 160.715_739_245_727_2),
            (4097.0, 4_150.770_814_014_309),
            (16_385.0, 16_492.632_432_482_51),
        ] {
            let quantile = gamma_quantile(0.8, shape);
            assert!((quantile / expected - 1.0).abs() < 1e-10, "{shape}: {quantile}");
        }
        for (mean, expected) in [
            (1e-3, 0),
            (0.01, 0),
            (0.02, 1),
            (0.5, 3),
            (1.0, 4),
            (1.755, 5),
            (5.0, 11),
            (20.0, 31),
            (300.5, 342),
            (4000.0, 4148),
            (100_000.0, 100_736),
        ] {
            assert_eq!(poisson_quantile(0.99, mean, 1_000_000), expected, "{mean}");
        }
    }

    #[test]
    fn every_number_has_a_bounded_answer() {
        let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -1.0, 1e-300, 1e300, 0.5];
        for one in odd {
            for other in odd {
                assert!(gamma_quantile(one, other).is_finite(), "{one} {other}");
                assert!(poisson_quantile(one, other, 7) <= 7);
            }
        }
        assert_eq!(poisson_quantile(0.99, 1e12, 16), 16);
        assert_eq!(poisson_quantile(0.99, 5.0, 4), 4);
    }
}
