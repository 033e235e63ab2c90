//! The alarm levels of Table 2-1.

use serde::Deserialize;

/// A level, mildest first. Tertius only advises: the action is the operator's or the machine's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "lowercase")]
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
