//! What a detector knows from before it started.

use super::Sequential;
use crate::sequential::DwellHistory;

impl Sequential {
    /// What was read on the stop so far.
    pub const fn dwells(&self) -> &DwellHistory {
        &self.dwells
    }

    /// Goes on with the dwells of a detector of the same cylinder.
    pub fn inherit(&mut self, dwells: DwellHistory) {
        self.dwells = dwells;
    }
}
