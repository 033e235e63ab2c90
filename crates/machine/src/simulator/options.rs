//! What a simulation has beside its tables.

use crate::controller::State;
use crate::inject::{Fault, Placed};
use tertius_core::time::Timestamp;

/// Default opening of the first cycle: 14 November 2023, 22:13:20 UTC.
pub const EPOCH: Timestamp = Timestamp::from_nanos(1_700_000_000_000_000_000);

/// Options of a simulation beside its tables.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    pub seed: u64,
    /// Significant wave height, m, and peak period, s; `None`: those of the table.
    pub sea: Option<[f64; 2]>,
    /// State in which the machine starts.
    pub start: State,
    /// Number of sub-steps of the plant in a sample.
    pub sub_steps: u32,
    /// Whether the controller reads C1 with its faults.
    pub in_loop: bool,
    /// Faults of readings.
    pub faults: Vec<Placed>,
    /// Faults of the machine itself; others among them do nothing.
    pub ailments: Vec<Fault>,
    /// Opening of the first cycle.
    pub epoch: Timestamp,
}

/// Default number of sub-steps in a sample of 20 ms: 2 ms each.
pub const SUB_STEPS: u32 = 10;

impl Default for Options {
    fn default() -> Self {
        Self {
            seed: 0,
            sea: None,
            start: State::Engaged,
            sub_steps: SUB_STEPS,
            in_loop: false,
            faults: Vec::new(),
            ailments: Vec::new(),
            epoch: EPOCH,
        }
    }
}
