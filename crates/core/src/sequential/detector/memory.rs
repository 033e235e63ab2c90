//! State of a detector that outlives the program.

use super::Sequential;
use crate::sequential::{DwellHistory, Gauging};

impl Sequential {
    /// Readings on the stop so far.
    pub const fn dwells(&self) -> &DwellHistory {
        &self.dwells
    }

    /// Restores the dwells of a detector of the same cylinder, in which C2 is corrected by
    /// `corrected`, a and b of (5-20).
    pub fn restore(&mut self, dwells: DwellHistory, corrected: [f64; 2]) {
        self.dwells = dwells;
        let [one, two] = self.design.resolution;
        self.dwells.gauge(Gauging { count: one.max(two), corrected: Some(corrected) });
    }
}
