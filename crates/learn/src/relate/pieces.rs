//! The pieces of a curve that is learnt: where the outermost knots are, and how many samples taught each piece.

use crate::order_statistics::ranked;
use tertius_core::process::curve;

/// Part of the samples beyond the outermost knots, on both sides together.
const BEYOND: f64 = 1e-4;

/// The size that hardly any of these exceeds; `None` without any.
pub(super) fn limit(mut sizes: Vec<f32>) -> Option<f64> {
    ranked(&mut sizes, 1.0 - BEYOND, f32::total_cmp).map(f64::from)
}

/// Part of values beyond each end of what is taught.
const ENDS: f64 = 1e-3;

/// What hardly any of these values is below, and above; `None` without any.
pub(super) fn ends(mut values: Vec<f64>) -> Option<[f64; 2]> {
    values.sort_unstable_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    let beyond = (ENDS * last as f64) as usize;
    Some([values[beyond], values[last - beyond]])
}

/// Samples in each of so many `pieces`, of those `values` that lie between the outermost knots.
pub(super) fn samples(values: impl Iterator<Item = f64>, limit: f64, pieces: usize) -> Vec<u64> {
    let mut samples = vec![0; pieces];
    for value in values.filter(|value| value.abs() <= limit) {
        samples[curve::place(limit, pieces, value).0] += 1;
    }
    samples
}
