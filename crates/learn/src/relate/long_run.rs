//! The scatter of sums of values that depend on each other.

/// Blocks over which what is left may depend on itself: 12 s.
const LAGS: usize = 60;

/// The long-run covariance of the products of consecutive blocks by Bartlett's weights, times their number. Of each block,
/// `joined` has how many before it follow one another up to it.
pub(super) fn covariance<const N: usize>(products: &[[f64; N]], joined: &[usize]) -> [[f64; N]; N] {
    let mut sums = [[0.0; N]; N];
    for (at, product) in products.iter().enumerate() {
        for lag in 0..=LAGS.min(joined[at]) {
            let weight = 1.0 - lag as f64 / (LAGS + 1) as f64;
            let other = &products[at - lag];
            for (i, j) in (0..N).flat_map(|i| (i..N).map(move |j| (i, j))) {
                let both = if lag == 0 {
                    product[i] * product[j]
                } else {
                    product[i] * other[j] + other[i] * product[j]
                };
                sums[i][j] += weight * both;
            }
        }
    }
    // The lower half is the upper one's.
    std::array::from_fn(|i| std::array::from_fn(|j| sums[i.min(j)][i.max(j)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values that are the means of two independent ones have a long-run variance of theirs, and half of it themselves.
    #[test]
    fn neighbours_that_depend_on_each_other_count_and_those_over_a_gap_do_not() {
        let mut state = 7_u64;
        let mut drawn = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f64 / (1_u64 << 24) as f64 - 0.5
        };
        let independent: Vec<f64> = (0..40_001).map(|_| drawn()).collect();
        let mean = |pair: &[f64]| [0.5 * (pair[0] + pair[1]), pair[1] - pair[0]];
        let products: Vec<[f64; 2]> = independent.windows(2).map(mean).collect();
        let count = products.len() as f64;
        let joined: Vec<usize> = (0..products.len()).collect();
        let [[all, _], [mixed, difference]] = covariance(&products, &joined);
        let variance = 1.0 / 12.0;
        assert!((all / count / variance - 1.0).abs() < 0.15, "{}", all / count / variance);
        assert!(mixed.abs() / count < 0.1 * variance && difference / count < 0.1 * variance);
        let [[alone, _], _] = covariance(&products, &vec![0; products.len()]);
        assert!((alone / count / variance - 0.5).abs() < 0.02, "{}", alone / count / variance);
    }
}
