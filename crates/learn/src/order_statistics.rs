//! Order statistics: medians and quantiles, upper ends of equal parts, and mean excess.

use std::cmp::Ordering;

/// Largest numbers, one part in this many, from whose mean excess a tail follows.
const TAIL_PART: usize = 5;

/// Of fewer numbers the largest fifth is one, and has no mean excess.
const FEW: usize = 5;

/// Mean excess of so few, as a part of the largest.
const EXCESS_OF_FEW: f64 = 0.3;

/// The median of `values`, the mean of both middle ones of an even number; 0 of none.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    quantile(&values, 0.5)
}

/// The quantile of `sorted` values, linear between them, at `share`; 0 of none.
pub(crate) fn quantile(sorted: &[f64], share: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return 0.0 };
    let place = share.clamp(0.0, 1.0) * last as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(last);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

/// The value with the part `share` of `values` below it, of two in the middle the upper one; none of none. It does
/// not sort all, as there may be millions, and changes their order.
pub(crate) fn ranked<T: Copy>(
    values: &mut [T],
    share: f64,
    order: fn(&T, &T) -> Ordering,
) -> Option<T> {
    let last = values.len().checked_sub(1)?;
    let place = ((share * values.len() as f64) as usize).min(last);
    Some(*values.select_nth_unstable_by(place, order).1)
}

/// The median as a value that occurred, of two in the middle the lower one: the mean of a pause and of a cycle is
/// neither. None of none.
pub(crate) fn lower_median(values: &[f64]) -> Option<f64> {
    let mut values = values.to_vec();
    let middle = values.len().checked_sub(1)? / 2;
    Some(*values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Upper ends of `parts` parts of equal number of the `sorted` values; none of none.
pub(crate) fn upper_ends(sorted: &[f64], parts: usize) -> Vec<f64> {
    let end = |part: usize| sorted[(part * sorted.len()).div_ceil(parts) - 1];
    if sorted.is_empty() { Vec::new() } else { (1..=parts).map(end).collect() }
}

/// Mean excess of the largest fifth of the `sorted` values beyond those below; of up to five, a part
/// of the largest.
pub(crate) fn mean_excess(sorted: &[f64]) -> f64 {
    let count = sorted.len();
    let Some(largest) = sorted.last() else { return 0.0 };
    if count <= FEW {
        return EXCESS_OF_FEW * largest;
    }
    let (below, beyond) = sorted.split_at(count - count / TAIL_PART);
    let floor = below.last().copied().unwrap_or(0.0);
    beyond.iter().map(|value| value - floor).sum::<f64>() / beyond.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_ten_numbers() {
        let ten: Vec<f64> = (1..=10_u32).map(f64::from).collect();
        assert_eq!(
            (median(ten.clone()), quantile(&ten, 0.9), quantile(&ten, 1.0)),
            (5.5, 9.1, 10.0)
        );
        let at = |share| ranked(&mut ten.clone(), share, f64::total_cmp);
        assert_eq!([at(0.5), at(0.1), at(1.0)], [6.0, 2.0, 10.0].map(Some));
        assert_eq!(lower_median(&ten), Some(5.0));
        assert_eq!(upper_ends(&ten, 10), ten);
        assert_eq!(upper_ends(&ten, 4), [3.0, 5.0, 8.0, 10.0]);
        assert_eq!(upper_ends(&ten[..1], 4), [1.0; 4]);
        // 9 and 10 beyond 8.
        assert!((mean_excess(&ten) - 1.5).abs() < 1e-12);
        assert!((mean_excess(&ten[..5]) - 1.5).abs() < 1e-12);
        assert!((mean_excess(&ten[..6]) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn of_none() {
        assert_eq!((median(Vec::new()), quantile(&[], 0.5), mean_excess(&[])), (0.0, 0.0, 0.0));
        assert_eq!((ranked(&mut [], 0.5, f64::total_cmp), lower_median(&[])), (None, None));
        assert!(upper_ends(&[], 3).is_empty());
    }
}
