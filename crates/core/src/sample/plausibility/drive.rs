//! Where a command would have moved a rod whose reading stands.

use super::moment::Moment;
use crate::state::whole;

/// Where the command would have moved the rod while the reading was exactly constant. A command at rest in between, as at
/// each turn of a sea, does not begin it anew.
#[derive(Clone, Copy, Debug, Default)]
pub struct CommandWay {
    /// Number of cycles under a command that moves.
    pub cycles: u32,
    /// Integral of the command, m, and its extremes.
    at: f64,
    lowest: f64,
    highest: f64,
    /// Largest rise and largest fall of that integral, m. A command that only dithers has neither.
    pub ways: [f64; 2],
    /// Whether the rod has been beyond the reading by so much that no stop holds it there, above and below.
    pub is_free: [bool; 2],
}

whole! { CommandWay { cycles, at, lowest, highest, ways, is_free } }

impl CommandWay {
    #[cold]
    pub fn go_on(&mut self, position: f64, moment: &Moment, margin: f64) {
        if moment.push.is_none() {
            return;
        }
        let [lowest, highest] = moment.been;
        self.is_free = [highest > position + margin, lowest < position - margin];
        self.cycles = self.cycles.saturating_add(1);
        self.at += moment.way;
        self.lowest = self.lowest.min(self.at);
        self.highest = self.highest.max(self.at);
        let [rise, fall] = self.ways;
        self.ways = [rise.max(self.at - self.lowest), fall.max(self.highest - self.at)];
    }
}
