//! Whom a finding may be about, and what tells which transducer has moved.

use crate::state::choice;

/// Suspect of a warning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Suspect {
    #[default]
    Undecided,
    C1,
    C2,
    /// Neither transducer: the cylinder, its valve or the model.
    Process,
}

choice! { Suspect { Undecided, C1, C2, Process } }

impl Suspect {
    /// All suspects, in the order of their numbers.
    pub const ALL: [Self; 4] = [Self::Undecided, Self::C1, Self::C2, Self::Process];

    /// Names in files and reports, in the order of the numbers.
    pub const NAMES: [&'static str; 4] = ["undecided", "c1", "c2", "process"];

    pub const fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }
}

/// What has told whose reading it is that has moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Testimony {
    /// The readings beside the command.
    Innovations,
    /// The mechanical stop.
    Stop,
    /// The oil that passes the valve.
    Flow,
    /// The attitude of the deck.
    Attitude,
    /// The rod's way by dead reckoning.
    Way,
}

choice! { Testimony { Innovations, Stop, Flow, Attitude, Way } }

impl Testimony {
    /// Whether it knows how the rod itself has moved, which the difference of the readings does not.
    pub const fn is_of_the_rod(self) -> bool {
        matches!(self, Self::Flow | Self::Attitude)
    }
}
