//! Assessment of a monitor.
//!
//! - [`evaluate`]: Monte Carlo on the simulator.
//! - [`commission`]: everything that learns from a recording in turn, a trial on what was held back, and
//!   whether the machine can be watched by it.

pub mod commission;
pub mod evaluate;
mod flaws;
