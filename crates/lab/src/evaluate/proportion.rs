//! A proportion: a count out of a total.

use super::interval::{CONFIDENCE, clopper_pearson};
use serde::Serialize;

/// A count out of a total, with what it says of the probability behind it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Proportion {
    pub count: u64,
    pub of: u64,
    /// Estimated probability; `None` where nothing was tried.
    pub probability: Option<f64>,
    /// Exact interval of [`CONFIDENCE`].
    pub interval: [f64; 2],
}

impl Proportion {
    pub fn new(count: u64, of: u64) -> Self {
        Self {
            count,
            of,
            probability: (of > 0).then(|| count as f64 / of as f64),
            interval: clopper_pearson(count, of, CONFIDENCE),
        }
    }

    /// The proportion of `all` for which `so` holds.
    pub fn counting<T>(all: &[T], so: impl Fn(&T) -> bool) -> Self {
        Self::new(all.iter().filter(|one| so(one)).count() as u64, all.len() as u64)
    }
}
