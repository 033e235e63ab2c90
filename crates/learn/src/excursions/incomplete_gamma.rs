//! Quantiles of the gamma and the Poisson distribution: how often something happens at most that was
//! seen so many times.

/// Most terms of a series or continued fraction; shapes up to a million converge with fewer.
const MOST_TERMS: u32 = 20_000;

/// Relative size of a term that changes nothing any more.
const NEGLIGIBLE: f64 = 1e-17;

/// What stands for 0 where it would divide.
const SMALLEST: f64 = 1e-300;

/// Halvings until two bounds are neighbours among floating-point numbers.
const HALVINGS: u32 = 200;

/// Coefficients of Lanczos's approximation with g = 7 (Godfrey).
const LANCZOS: [f64; 9] = [
    0.999_999_999_999_809_9,
    676.520_368_121_885_1,
    -1_259.139_216_722_402_8,
    771.323_428_777_653_1,
    -176.615_029_162_140_6,
    12.507_343_278_686_905,
    -0.138_571_095_265_720_12,
    9.984_369_578_019_572e-6,
    1.505_632_735_149_311_6e-7,
];

/// ln Γ(x), x at least 1/2.
fn ln_gamma(x: f64) -> f64 {
    let x = x - 1.0;
    let terms = LANCZOS.iter().enumerate().skip(1);
    let sum = terms.fold(LANCZOS[0], |sum, (k, coefficient)| sum + coefficient / (x + k as f64));
    let t = x + 7.5;
    0.5 * std::f64::consts::TAU.ln() + (x + 0.5) * t.ln() - t + sum.ln()
}

/// Regularised lower incomplete gamma function P(a, x): the chance that a gamma variable of shape
/// `a` ≥ 1/2 is at most `x` ≥ 0 (Press et al., *Numerical Recipes*, section 6.2).
fn lower_gamma(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    let part = if x < a + 1.0 { front * series(a, x) } else { 1.0 - front * fraction(a, x) };
    part.clamp(0.0, 1.0)
}

/// Σ xⁿ / (a (a + 1) … (a + n)).
fn series(a: f64, x: f64) -> f64 {
    let mut term = 1.0 / a;
    let mut sum = term;
    for n in 1..MOST_TERMS {
        term *= x / (a + f64::from(n));
        sum += term;
        if term < NEGLIGIBLE * sum {
            break;
        }
    }
    sum
}

/// Continued fraction of the upper incomplete gamma function, by Lentz's method; `x` ≥ `a` + 1.
fn fraction(a: f64, x: f64) -> f64 {
    let not_zero = |value: f64| if value.abs() < SMALLEST { SMALLEST } else { value };
    let mut term = x + 1.0 - a;
    let mut upper = 1.0 / SMALLEST;
    let mut lower = 1.0 / not_zero(term);
    let mut value = lower;
    for n in (1..MOST_TERMS).map(f64::from) {
        let numerator = n * (a - n);
        term += 2.0;
        lower = 1.0 / not_zero(numerator * lower + term);
        upper = not_zero(term + numerator / upper);
        let change = upper * lower;
        value *= change;
        if (change - 1.0).abs() < f64::EPSILON {
            break;
        }
    }
    value
}

/// The `value` within these limits; the lower one for what is no number.
fn limited(value: f64, least: f64, most: f64) -> f64 {
    if value.is_nan() { least } else { value.clamp(least, most) }
}

/// The value below which a gamma variable of scale 1 and of `shape`, limited to 1/2 to a million, is
/// with the chance `probability`, between 0 and 1.
pub fn gamma_quantile(probability: f64, shape: f64) -> f64 {
    let shape = limited(shape, 0.5, 1e6);
    let probability = limited(probability, 0.0, 1.0 - 1e-12);
    let mut low = 0.0;
    // 20 deviations and more: beyond any probability above.
    let mut high = shape + 20.0 * shape.sqrt() + 60.0;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if lower_gamma(shape, middle) < probability {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// The least number that a Poisson variable of this `mean` does not exceed with the chance
/// `probability`, and `most` at most, which is up to a million.
pub fn poisson_quantile(probability: f64, mean: f64, most: u32) -> u32 {
    if mean.is_nan() || mean <= 0.0 {
        return 0;
    }
    // Twenty deviations beyond `most`; the sums would be long, and their result is known.
    if mean > f64::from(most) + 20.0 * f64::from(most).sqrt() + 60.0 {
        return most;
    }
    // P(X ≤ q) = 1 − P(q + 1, mean).
    let suffices = |q: u32| 1.0 - lower_gamma(f64::from(q) + 1.0, mean) >= probability;
    let (mut low, mut high) = (0, most);
    while low < high {
        let middle = low + (high - low) / 2;
        if suffices(middle) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of `SciPy` 1.17: `scipy.special.gammaln`, `gammaincc`, `scipy.stats.gamma.ppf(0.8, a)`
    /// and `scipy.stats.poisson.ppf(0.99, mean)`.
    #[test]
    fn as_scipy() {
        let close = |one: f64, other: f64| (one - other).abs() <= 1e-12 * other.abs().max(1.0);
        for (x, expected) in [
            (0.5, 0.572_364_942_924_7),
            (1.0, 0.0),
            (3.5, 1.200_973_602_347_074_3),
            (10.0, 12.801_827_480_081_469),
            (171.5, 709.143_163_030_928_3),
            (20_000.0, 178_065.718_249_646_2),
        ] {
            assert!(close(ln_gamma(x), expected), "{x}: {}", ln_gamma(x));
        }
        for (a, x, expected) in [
            (1.0, 1.0, 0.367_879_441_171_442_45),
            (2.5, 7.25, 0.012_726_685_122_400_083),
            (10.0, 3.0, 0.998_897_511_869_884_5),
            (100.0, 110.0, 0.158_278_670_060_087_06),
            (5000.0, 4900.0, 0.922_055_043_773_486),
        ] {
            let upper = 1.0 - lower_gamma(a, x);
            assert!((upper - expected).abs() < 1e-11, "{a} {x}: {upper}");
        }
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
