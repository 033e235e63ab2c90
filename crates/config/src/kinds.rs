//! Kinds of values that many keys have.

use super::schema::{Kind, Limits, Scalar, WholeLimits};
use super::text::TextRule;

/// Most cylinders: Fd_Status has two state bits for each transducer of six.
pub(super) const MOST_CYLINDERS: u8 = tertius_core::alarm::status::MAX_CYLINDERS as u8;

pub(super) const DURATION: &str = "a duration in seconds";
pub(super) const FINITE: &str = "nan and inf cannot be computed with";
pub(super) const THRESHOLD: &str = "a threshold in metres; residuals are compared by their size";

pub(super) const fn text(rule: TextRule) -> Kind {
    Kind::One(Scalar::Text(rule))
}

pub(super) const fn number(limits: Limits) -> Kind {
    Kind::One(Scalar::Number(limits))
}

pub(super) const fn numbers(count: usize, limits: Limits) -> Kind {
    Kind::List { least: count, most: count, of: Scalar::Number(limits) }
}

pub(super) const fn whole(low: i128, high: i128, why: &'static str) -> Kind {
    Kind::One(Scalar::Whole(WholeLimits::new(low, high, why)))
}

pub(super) const fn counts(least: usize, most: usize) -> Kind {
    let limits = WholeLimits::new(i64::MIN as i128, i64::MAX as i128, "raw counts of a signal");
    Kind::List { least, most, of: Scalar::Whole(limits) }
}
