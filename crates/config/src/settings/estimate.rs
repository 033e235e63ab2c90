//! The virtual third sensor.

use serde::Deserialize;

/// Settings of the estimates of each cylinder's length.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Estimate {
    /// Whether Fd_Estimate is sent for each cylinder in each cycle.
    pub send: bool,
    /// Largest standard deviation of a valid estimate, m.
    pub bound: f64,
}

impl Default for Estimate {
    /// A bound of a tenth of the difference at which the machine itself trips.
    fn default() -> Self {
        Self { send: false, bound: 5e-3 }
    }
}
