//! Whether a stretch is two excursions that overlap, one of each transducer.
//!
//! C1 up and C2 down at once add up in the difference: it stands on one level, on the sum of two, and
//! on the other one. Three plateaus are fitted by least squares over both inner edges.

/// Fewest samples of the outer plateaus: with one, a late edge would be a plateau.
const LEAST_OUTER: usize = 2;

/// Fewest samples of the middle plateau: up to two that are higher are wild.
const LEAST_MIDDLE: usize = 3;

/// Part of the size by which the middle plateau is higher than both others.
const LEAST_RISE: f64 = 0.6;

/// Difference between the middle plateau and the sum of the outer ones: this much, m…
const SUM_TOLERANCE: f64 = 0.15e-3;

/// …and this part of the middle one.
const SUM_TOLERANCE_PART: f64 = 0.1;

/// Two excursions that overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Overlap {
    /// Where the second one begins, and after which sample the first one has ended.
    pub edges: [usize; 2],
    /// Sizes of the first and the second one, m.
    pub sizes: [f64; 2],
}

/// The two excursions of which a stretch of these `values`, m, of the size `size`, m, is made;
/// `None` for any other stretch.
pub(super) fn overlap(values: &[f64], size: f64) -> Option<Overlap> {
    let count = values.len();
    if count < 2 * LEAST_OUTER + LEAST_MIDDLE {
        return None;
    }
    let mut sums = vec![0.0];
    let mut sum = 0.0;
    sums.extend(values.iter().map(|value| {
        sum += value;
        sum
    }));
    let edges = best_edges(&sums);
    let [outer, middle] = [edges[0].min(count - edges[1]), edges[1] - edges[0]];
    if outer < LEAST_OUTER || middle < LEAST_MIDDLE {
        return None;
    }
    let parts = [0..edges[0], edges[0]..edges[1], edges[1]..count];
    let totals = parts.clone().map(|part| sums[part.end] - sums[part.start]);
    let counts = parts.map(|part| part.len() as f64);
    let [first, middle, last] = [0, 1, 2].map(|part| totals[part] / counts[part]);
    let tolerance = SUM_TOLERANCE + SUM_TOLERANCE_PART * middle.abs();
    let is_sum = (first + last - middle).abs() < tolerance;
    (middle - first.max(last) > LEAST_RISE * size && is_sum)
        .then(|| Overlap { edges, sizes: sizes(totals, counts) })
}

/// Both inner edges with the least squares about three means, given the `sums` of the first 0, 1, …
/// of at least three values: with the largest sum of total² / count. Parts may be as short as one
/// sample: if they had to be longer, wild samples would be a plateau together with their neighbours.
fn best_edges(sums: &[f64]) -> [usize; 2] {
    let count = sums.len() - 1;
    let explained = |from: usize, to: usize| {
        let total = sums[to] - sums[from];
        total * total / (to - from) as f64
    };
    let mut best = ([1, 2], f64::NEG_INFINITY);
    for first in 1..count - 1 {
        let before = explained(0, first);
        for last in first + 1..count {
            let all = before + explained(first, last) + explained(last, count);
            if all > best.1 {
                best = ([first, last], all);
            }
        }
    }
    best.0
}

/// Least-squares sizes a and b, m, of plateaus a, a + b and b with these `totals` and `counts`.
fn sizes(totals: [f64; 3], counts: [f64; 3]) -> [f64; 2] {
    let [first, middle, last] = counts;
    let [a, b] = [totals[0] + totals[1], totals[1] + totals[2]];
    // Above 0, since no plateau is empty.
    let determinant = (first + middle) * (middle + last) - middle * middle;
    [
        ((middle + last) * a - middle * b) / determinant,
        ((first + middle) * b - middle * a) / determinant,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn levels(parts: &[(usize, f64)]) -> Vec<f64> {
        parts.iter().flat_map(|(count, level)| vec![*level; *count]).collect()
    }

    #[test]
    fn edges_and_sizes_of_two_that_differ() {
        let values = levels(&[(4, 3e-4), (6, 8e-4), (9, 5e-4)]);
        let Overlap { edges, sizes } = overlap(&values, 4e-4).expect("two that overlap");
        assert_eq!(edges, [4, 10]);
        assert!((sizes[0] - 3e-4).abs() < 1e-9 && (sizes[1] - 5e-4).abs() < 1e-9, "{sizes:?}");
    }

    #[test]
    fn all_else_is_one() {
        assert_eq!(overlap(&levels(&[(20, 4e-4)]), 4e-4), None);
        // Wild samples in the middle.
        assert_eq!(overlap(&levels(&[(5, 4e-4), (2, 8e-4), (5, 4e-4)]), 4e-4), None);
        // An edge that is late.
        assert_eq!(overlap(&levels(&[(1, 4e-4), (6, 8e-4), (5, 4e-4)]), 4e-4), None);
        // Not the sum of both.
        assert_eq!(overlap(&levels(&[(5, 4e-4), (5, 12e-4), (5, 4e-4)]), 4e-4), None);
        // Not much higher.
        assert_eq!(overlap(&levels(&[(5, 4e-4), (5, 6e-4), (5, 4e-4)]), 4e-4), None);
        assert_eq!(overlap(&[], 4e-4), None);
    }
}
