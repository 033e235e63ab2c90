//! What was judged of a cylinder, and what was not.

use super::blanks::Blanks;
use super::tally::Tally;
use crate::state::state;
use crate::time::Timestamp;

/// Accounts of one cylinder.
#[derive(Clone, Debug, Default)]
pub(super) struct Account {
    /// Whether each transducer was judged by its observer in the newest cycle.
    pub judged: [bool; 2],
    pub blanks: Blanks,
    pub tally: Tally,
}

state! {
    Account { judged, blanks, tally }
    sound |it| it.blanks.begin_before(it.tally.cycles)
}

impl Account {
    /// Counts anew, also what is not judged at present.
    pub fn count_anew(&mut self) {
        self.tally = Tally::default();
        self.blanks.count_anew();
    }

    /// Takes that time continues elsewhere than after `last`.
    pub fn interrupt(&mut self, last: Timestamp) {
        self.judged = [false; 2];
        self.blanks.interrupt(last, self.tally.cycles);
    }
}
