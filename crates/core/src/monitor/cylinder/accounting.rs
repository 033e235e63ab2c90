//! What is counted of a cycle of a cylinder: what was judged, and why something was not.

use super::account::Account;
use super::blanks::{Blank, NotJudged};
use super::{Cycle, Cylinder};
use crate::monitor::gate::Opening;
use crate::sample::{Quality, Transducer};
use crate::time::Timestamp;

impl Cylinder {
    /// Takes that an observer judges again, or no more.
    #[cold]
    pub(super) fn note_blank(&mut self, cycle: &Cycle) {
        let judged = self.account.judged;
        // This one has been counted.
        let before = self.account.tally.cycles - 1;
        let reasons =
            [0, 1].map(|i| self.has(Transducer::ALL[i]).then(|| self.not_judged(i, cycle)));
        self.account.blanks.change(judged, cycle.now.opened, before, reasons);
    }

    fn not_judged(&self, i: usize, cycle: &Cycle) -> NotJudged {
        match self.readings.quality(i) {
            Quality::Missing | Quality::Stale => NotJudged::NoReadings,
            Quality::Doubtful => NotJudged::Doubtful,
            quality if !quality.is_good() => NotJudged::Implausible,
            _ if cycle.now.gate == Opening::Closed => NotJudged::State,
            _ if !self.design.observes => NotJudged::NoBaseline,
            _ if self.command.is_absent() => NotJudged::NoCommand,
            _ => NotJudged::Settling,
        }
    }

    /// The longest times in which the observers did not judge, those that last until `newest` among them.
    pub fn blanks(&self, newest: Timestamp) -> impl Iterator<Item = Blank> {
        self.account.blanks.longest(newest)
    }

    /// Cycles that the observers of C1 and C2 did not judge; `None` for a transducer that is not configured.
    pub fn unjudged(&self) -> [Option<u64>; 2] {
        let Account { blanks, tally, .. } = &self.account;
        core::array::from_fn(|i| {
            self.has(Transducer::ALL[i]).then(|| blanks.count(i, tally.cycles))
        })
    }
}
