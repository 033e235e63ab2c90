//! For how long a process detector judged.

use super::relation::RELATIONS;
use crate::state::whole;

/// Number of monitored cycles, and of those in which each relation was judged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProcessCoverage {
    pub monitored: u64,
    knows: [bool; RELATIONS],
    /// Monitored cycles by the bits of the relations by which they were judged, so that a cycle is counted once.
    by: [u64; 1 << RELATIONS],
}

whole! { ProcessCoverage { monitored, knows, by } }

impl ProcessCoverage {
    /// Of a detector that knows these relations, before any cycle.
    pub const fn new(knows: [bool; RELATIONS]) -> Self {
        Self { monitored: 0, knows, by: [0; 1 << RELATIONS] }
    }

    /// Counts a monitored cycle, with a bit for each relation by which it was judged.
    #[inline]
    pub fn count(&mut self, judged: u8) {
        self.monitored += 1;
        self.by[usize::from(judged) % self.by.len()] += 1;
    }

    /// Cycles that were judged by spool, chambers, flow, friction and supply; `None` without the relation.
    pub fn judged(&self) -> [Option<u64>; RELATIONS] {
        core::array::from_fn(|which| {
            let cycles = self.by.iter().enumerate().filter(|(bits, _)| bits >> which & 1 != 0);
            self.knows[which].then(|| cycles.map(|(_, count)| count).sum())
        })
    }
}
