//! Extremes of healthy residuals and how often they occur, from which thresholds follow.
//!
//! Residuals of neighbouring cycles depend on each other, and one burst is one alarm. Therefore the
//! maxima of blocks about as long as a warning lasts are counted ([`Maxima`]), and the largest of
//! them are extrapolated by a tail ([`Tail`]). Everything streams: memory does not grow.

mod digits;
mod maxima;
mod pareto;
mod sketch;
mod slope;
mod tail;
mod thinned;

pub use digits::{false_alarms, four_digits, times};
pub use maxima::Maxima;
pub use pareto::Pareto;
pub use sketch::Sketch;
pub use slope::{Asked, LARGEST_LEVEL, levels};
pub use tail::{LEAST_BLOCKS, LEAST_PEAKS, Tail, common_level};
pub use tertius_core::time::{HOURS_PER_YEAR, per_second};
pub use thinned::Thinned;
