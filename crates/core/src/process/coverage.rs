//! For how long a process detector judged.

use super::detector::RELATIONS;
use crate::state::whole;

/// Number of monitored cycles, and of those in which each relation was judged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProcessCoverage {
    pub monitored: u64,
    knows: [bool; RELATIONS],
    judged: [u64; RELATIONS],
}

whole! { ProcessCoverage { monitored, knows, judged } }

impl ProcessCoverage {
    /// Of a detector that knows these relations, before any cycle.
    pub const fn new(knows: [bool; RELATIONS]) -> Self {
        Self { monitored: 0, knows, judged: [0; RELATIONS] }
    }

    /// Counts a monitored cycle, in which each relation was judged or not.
    #[inline]
    pub fn count(&mut self, judged: [bool; RELATIONS]) {
        self.monitored += 1;
        for (count, judged) in self.judged.iter_mut().zip(judged) {
            *count += u64::from(judged);
        }
    }

    /// Cycles that were judged by spool, chambers, flow, friction and supply; `None` without the relation.
    pub fn judged(&self) -> [Option<u64>; RELATIONS] {
        core::array::from_fn(|which| self.knows[which].then_some(self.judged[which]))
    }
}
