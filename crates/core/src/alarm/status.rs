//! Contents of Fd_Status, which is sent every 100 ms.

use super::Level;
use crate::state::{choice, whole};

/// Number of cylinders that Fd_Status has room for.
pub const MAX_CYLINDERS: usize = 6;

/// State of one transducer. The numbers are those of Fd_Status.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Health {
    /// There is no evidence either way.
    #[default]
    Unknown = 0,
    Healthy = 1,
    /// A warning stands that may be its fault.
    Suspect = 2,
    /// A warning stands that blames it.
    Faulty = 3,
}

choice! { Health { Unknown, Healthy, Suspect, Faulty } }

impl Health {
    /// All states, in the order of their numbers.
    pub const ALL: [Self; 4] = [Self::Unknown, Self::Healthy, Self::Suspect, Self::Faulty];
}

/// State of the monitor as a whole. The numbers are those of Fd_Status.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Not everything has been judged yet.
    #[default]
    Starting = 0,
    Monitoring = 1,
    /// The platform is in a state in which FDE1 and FDE2 do not judge.
    Gated = 2,
    /// Something that should be judged cannot be.
    Degraded = 3,
    Stopping = 4,
}

choice! { Mode { Starting, Monitoring, Gated, Degraded, Stopping } }

/// The content of Fd_Status.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// State of C1 and C2 of each cylinder.
    pub transducers: [[Health; 2]; MAX_CYLINDERS],
    /// Highest level of the standing warnings.
    pub level: Level,
    pub mode: Mode,
    pub active_warnings: u32,
}

whole! { Status { transducers, level, mode, active_warnings } }
