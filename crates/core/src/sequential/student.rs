//! Student's distribution with whole degrees of freedom.

use core::f64::consts::FRAC_2_PI;

/// No quantile that is asked for is larger: of one degree of freedom it is that of 2 / (π 10⁹).
const LARGEST: f64 = 1e9;

/// Halvings until neighbouring numbers are left.
const HALVINGS: usize = 100;

/// The quantile t that |T| exceeds with a probability of `tail`, with `freedom` degrees of freedom,
/// at least one.
///
/// It is found by bisection: it is needed seldom, and comes out the same everywhere.
pub fn two_sided(tail: f64, freedom: usize) -> f64 {
    let (mut low, mut high) = (0.0, LARGEST);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if beyond(middle, freedom) > tail { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// The probability of |T| beyond `t`; a finite sum (Abramowitz and Stegun, 26.7.3 and 26.7.4).
fn beyond(t: f64, freedom: usize) -> f64 {
    let n = freedom as f64;
    let hypotenuse = libm::sqrt(n + t * t);
    let (sine, cosine) = (t / hypotenuse, libm::sqrt(n) / hypotenuse);
    let is_odd = freedom % 2 == 1;
    let (mut sum, mut term) = (0.0, 1.0);
    for k in 1..=freedom / 2 {
        sum += term;
        let twice = 2.0 * k as f64;
        let ratio = if is_odd { twice / (twice + 1.0) } else { (twice - 1.0) / twice };
        term *= ratio * cosine * cosine;
    }
    if is_odd {
        1.0 - FRAC_2_PI * (libm::atan2(t, libm::sqrt(n)) + sine * cosine * sum)
    } else {
        1.0 - sine * sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{ContinuousCDF, StudentsT};

    #[test]
    fn quantiles_are_those_of_tables() {
        for (freedom, t) in
            [(1, 636.619), (2, 31.599), (3, 12.924), (10, 4.587), (30, 3.646), (120, 3.373)]
        {
            let found = two_sided(0.001, freedom);
            assert!((found - t).abs() < 6e-4, "{freedom}: {found}");
        }
    }

    #[test]
    fn the_tail_is_that_of_the_incomplete_beta_function() {
        for freedom in 1..=130 {
            let other = StudentsT::new(0.0, 1.0, freedom as f64).expect("they are sound");
            for t in [0.1, 1.0, 3.0, 10.0, 100.0] {
                let (ours, theirs) = (beyond(t, freedom), 2.0 * other.sf(t));
                assert!((ours - theirs).abs() < 1e-12, "{freedom}, {t}: {ours}, {theirs}");
            }
        }
    }
}
