//! Kinds of the values that `tertius calibrate` writes.

use crate::schema::{Kind, Limits, Scalar};
use tertius_core::sequential::windows::WIDTHS;

/// What is expected of a value that nobody writes by hand.
pub(super) const FITTED: &str = "`tertius calibrate` writes it";

/// From `least` to `most` numbers.
pub(super) const fn fitted(least: usize, most: usize) -> Kind {
    Kind::List { least, most, of: Scalar::Number(Limits::finite(FITTED)) }
}

/// One number for each width of a window.
pub(super) const fn dependence() -> Kind {
    let one = Limits::least(1.0, "how many samples carry as much information as one");
    Kind::List { least: WIDTHS.len(), most: WIDTHS.len(), of: Scalar::Number(one) }
}
