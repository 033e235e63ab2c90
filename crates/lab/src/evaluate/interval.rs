//! How far a count can be believed: exact intervals for probabilities and rates.

use statrs::distribution::{Beta, ChiSquared, ContinuousCDF};

/// Confidence of every interval and bound.
pub const CONFIDENCE: f64 = 0.95;

/// The Clopper-Pearson interval of a probability when `count` of `of` trials succeeded; [0, 1]
/// where nothing was tried. Each side is exact: its tail is (1 − `confidence`)/2 at most.
pub fn clopper_pearson(count: u64, of: u64, confidence: f64) -> [f64; 2] {
    let count = count.min(of);
    let tail = (1.0 - confidence) / 2.0;
    let (seen, unseen) = (count as f64, (of - count) as f64);
    let quantile = |a: f64, b: f64, p: f64| Beta::new(a, b).ok().map(|beta| beta.inverse_cdf(p));
    let low = if count == 0 { None } else { quantile(seen, unseen + 1.0, tail) };
    let high = if count == of { None } else { quantile(seen + 1.0, unseen, 1.0 - tail) };
    [low.unwrap_or(0.0), high.unwrap_or(1.0)]
}

/// The exact one-sided upper bound of the expected number of events where `events` were seen. With
/// no events it is the rule of three: −ln 0.05 = 2.996.
pub fn poisson_upper(events: u64, confidence: f64) -> f64 {
    if events == 0 {
        return -(-confidence).ln_1p();
    }
    let freedom = 2.0 * (events as f64 + 1.0);
    // More than 0 degrees of freedom, always.
    ChiSquared::new(freedom).map_or(f64::INFINITY, |chi| chi.inverse_cdf(confidence) / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const REFERENCE_INTERVALS: [(u64, u64, f64, f64); 7] = [
        (0, 200, 0.0, 0.018275340355148807),
        (200, 200, 0.9817246596448512, 1.0),
        (1, 200, 0.00012658102800940386, 0.027541898457558386),
        (197, 200, 0.9567917180822902, 0.9968958923784449),
        (37, 96, 0.28782302980608243, 0.4902813701463526),
        (599, 600, 0.9907492277210855, 0.9999578045436127),
        (5000, 100_000, 0.04865725520723964, 0.05136892088058044),
    ];

    const REFERENCE_BOUNDS: [(u64, f64); 6] = [
        (0, 2.9957322735539895),
        (1, 4.743864518390577),
        (2, 6.295793621871988),
        (10, 16.962219235721903),
        (137, 157.8742516698695),
        (5000, 5117.886079407686),
    ];

    #[track_caller]
    fn close(found: f64, expected: f64) {
        assert!((found - expected).abs() <= 1e-8 * expected.max(1.0), "{found}, not {expected}");
    }

    /// scipy.stats.binomtest(k, n).proportion_ci(0.95, "exact").
    #[test]
    fn probabilities_have_the_intervals_of_scipy() {
        for (count, of, low, high) in REFERENCE_INTERVALS {
            let [found_low, found_high] = clopper_pearson(count, of, 0.95);
            close(found_low, low);
            close(found_high, high);
        }
        assert_eq!(clopper_pearson(0, 0, 0.95), [0.0, 1.0]);
    }

    /// scipy.stats.chi2.ppf(0.95, 2 (n + 1)) / 2.
    #[test]
    fn rates_have_the_bounds_of_scipy() {
        for (events, bound) in REFERENCE_BOUNDS {
            close(poisson_upper(events, 0.95), bound);
        }
    }
}
