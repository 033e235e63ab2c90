//! The alarm levels of Table 2-1.

use crate::state::choice;

/// An alarm level, mildest first. Tertius only advises: the operator or the machine acts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    #[default]
    None,
    /// Continue operation.
    Yellow,
    /// Finish operation in 60 seconds.
    Orange,
    /// Shut-down through software in 5 seconds.
    Red,
    /// Shut-down through hardware in 5 seconds.
    Black,
}

choice! { Level { None, Yellow, Orange, Red, Black } }

impl Level {
    /// All levels, in the order of their numbers.
    pub const ALL: [Self; 5] = [Self::None, Self::Yellow, Self::Orange, Self::Red, Self::Black];

    /// Names in files and reports, in the order of the numbers.
    pub const NAMES: [&'static str; 5] = ["none", "yellow", "orange", "red", "black"];

    pub const fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }
}

/// Alarm level of each finding.
#[derive(Clone, Debug, PartialEq)]
pub struct Levels {
    /// Level where one transducer is blamed by its FDE.
    pub located: Level,
    /// Level where R3 is beyond its bound and the location is undecided.
    pub undecided: Level,
    /// Level where both observers disagree with readings that agree with each other.
    pub process: Level,
    /// Level of a reading that is stale, out of range, frozen or has a broken wire.
    pub implausible: Level,
    /// Level where neither transducer of a cylinder can be relied on.
    pub both: Level,
    /// Level where the machine trips, or the supply no longer carries the load, within [`super::Deadlines::soon`].
    pub soon: Level,
    /// The same within [`super::Deadlines::at_once`].
    pub at_once: Level,
    /// Level of a measured C1 − C2 beyond the critical limit, where the machine itself trips.
    pub critical: Level,
}

impl Default for Levels {
    fn default() -> Self {
        Self {
            located: Level::Yellow,
            undecided: Level::Yellow,
            process: Level::Yellow,
            implausible: Level::Orange,
            both: Level::Black,
            soon: Level::Orange,
            at_once: Level::Red,
            critical: Level::Black,
        }
    }
}
