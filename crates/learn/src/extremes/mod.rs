//! How large a healthy residual gets, and how seldom: what thresholds are made of.
//!
//! Residuals of neighbouring cycles depend on each other, and one burst is one alarm. So what is
//! counted are the maxima of blocks about as long as a warning lasts ([`Maxima`]). The largest of
//! them are extrapolated by a tail ([`Tail`]). All of it streams: memory does not grow.

mod maxima;
mod sketch;
mod slope;
mod tail;
mod thinned;

pub use maxima::Maxima;
pub use sketch::Sketch;
pub use slope::{Asked, LARGEST_LEVEL, levels};
pub use tail::{LEAST_BLOCKS, Pareto, Tail, common_level};
pub use tertius_core::time::{HOURS_PER_YEAR, per_second};
pub use thinned::Thinned;
