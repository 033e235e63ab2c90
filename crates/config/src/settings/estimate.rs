//! The virtual third sensor.

use serde::Deserialize;

/// What is told of each cylinder's length.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Estimate {
    /// Fd_Estimate is sent, for each cylinder in each cycle.
    pub send: bool,
    /// An estimate with a larger standard deviation is not valid, m.
    pub bound: f64,
}

impl Default for Estimate {
    /// A tenth of the difference at which the machine itself trips.
    fn default() -> Self {
        Self { send: false, bound: 5e-3 }
    }
}
