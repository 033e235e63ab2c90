//! The alarm levels of Table 2-1.

/// A level, mildest first. Tertius only advises: the action is the operator's or the machine's.
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

impl Level {
    /// The name in files and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Yellow => "yellow",
            Self::Orange => "orange",
            Self::Red => "red",
            Self::Black => "black",
        }
    }
}

/// Which finding has which level.
#[derive(Clone, Debug, PartialEq)]
pub struct Levels {
    /// One transducer is blamed by its FDE.
    pub located: Level,
    /// R3 beyond its bound and no decision on the location.
    pub undecided: Level,
    /// Both observers disagree with readings that agree with each other.
    pub process: Level,
    /// A reading is stale, out of range, frozen or has a broken wire.
    pub implausible: Level,
    /// Neither transducer of a cylinder can be relied on.
    pub both: Level,
    /// The measured C1 − C2 beyond the critical limit, where the machine itself trips.
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
            critical: Level::Black,
        }
    }
}
