//! For how long a process detector judged.

use super::detector::RELATIONS;
use crate::state::whole;

/// Number of monitored cycles, and of those in which each relation was judged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProcessCoverage {
    pub monitored: u64,
    /// By spool, by chambers and by flow; `None` without the relation.
    pub judged: [Option<u64>; RELATIONS],
}

whole! { ProcessCoverage { monitored, judged } }

impl ProcessCoverage {
    /// Counts a monitored cycle, in which each relation was judged or not, if there is one.
    pub fn count(&mut self, judged: [Option<bool>; RELATIONS]) {
        self.monitored += 1;
        for (count, judged) in self.judged.iter_mut().zip(judged) {
            if let Some(judged) = judged {
                *count.get_or_insert_default() += u64::from(judged);
            }
        }
    }
}
