//! Excursions that touch each other by chance, and look like one long or one large excursion.
//!
//! The limits are computed with chains of excursions. If a chain in the recording were taken
//! for one excursion, it would be chained again, and a chance of the recording be learnt as a length.

use super::quantiles::poisson_quantile;
use crate::order_statistics::quantile;

/// Samples by which excursions may be apart, or overlap, and still be found as one.
const TOUCHING: f64 = 3.0;

/// Chance that there are not more chains than are expected.
const CHAIN_QUANTILE: f64 = 0.99;

/// The quantile to which entries are compared.
const ORDINARY: f64 = 0.9;

/// Least multiple of that quantile of a length that is halved.
pub(super) const LEAST_LENGTH_RATIO: f64 = 1.15;

/// Least multiple of that quantile of a size that is halved; sizes vary more.
pub(super) const LEAST_SIZE_RATIO: f64 = 1.5;

/// Largest multiple: more is not two.
pub(super) const LARGEST_RATIO: f64 = 2.3;

/// Most of `entries` excursions of a mean of `length` samples that touch another one, where
/// `chance` is the mean chance of one transducer and direction.
pub(super) fn most_chains(entries: usize, chance: f64, length: f64) -> usize {
    let mean = entries as f64 * 2.0 * chance * (length + TOUCHING);
    poisson_quantile(CHAIN_QUANTILE, mean, entries as u32) as usize
}

/// Whether an entry of `value` may be two at once, from `least` times the ordinary of `sorted`.
pub(super) fn may_be_two(sorted: &[f64], value: f64, least: f64) -> bool {
    let ordinary = quantile(sorted, ORDINARY);
    (least * ordinary..=LARGEST_RATIO * ordinary).contains(&value)
}

/// Halves those of the `most` largest of the `sorted` values that may be two; `split` says into
/// what. The result is sorted.
pub(super) fn halve(
    sorted: &[f64],
    most: usize,
    least: f64,
    split: impl Fn(f64) -> [f64; 2],
) -> Vec<f64> {
    let (rest, largest) = sorted.split_at(sorted.len() - most.min(sorted.len()));
    let mut halved = rest.to_vec();
    for value in largest {
        if may_be_two(sorted, *value, least) {
            halved.extend(split(*value));
        } else {
            halved.push(*value);
        }
    }
    halved.sort_unstable_by(f64::total_cmp);
    halved
}

/// Two lengths, whole samples, that add up to `length`.
pub(super) fn half_lengths(length: f64) -> [f64; 2] {
    let longer = (0.5 * length).ceil();
    [length - longer, longer]
}

/// Two sizes that add up to `size`.
pub(super) fn half_sizes(size: f64) -> [f64; 2] {
    [0.5 * size; 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two on each other's end are 20 samples: they become two of 10 if two are expected to meet.
    #[test]
    fn chains_become_two_as_far_as_they_are_expected() {
        let mut lengths = vec![10.0; 270];
        lengths.extend([20.0, 21.0, 24.0]);
        // 273 × 2 × 2.5e-4 × 13.1 = 1.79, of which 6 are the 99 % quantile.
        assert_eq!(most_chains(273, 2.5e-4, 10.1), 6);
        let of = |most| halve(&lengths, most, LEAST_LENGTH_RATIO, half_lengths);
        let mut two = vec![10.0; 273];
        two.extend([11.0, 24.0]);
        assert_eq!(of(6), two);
        assert_eq!(of(0), lengths);
        // The longest is not two; the next one is.
        assert_eq!(of(2)[270..], [10.0, 11.0, 20.0, 24.0]);
        assert_eq!(most_chains(0, 2.5e-4, 0.0), 0);
        assert_eq!(most_chains(10, 0.0, 10.0), 0);
        assert!(halve(&[], 3, LEAST_SIZE_RATIO, half_sizes).is_empty());
    }
}
