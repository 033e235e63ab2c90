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
    /// The cylinder does not have it. Fd_Status has two bits for a state, and tells this by another signal
    /// ([`Status::without_c2`]).
    NotFitted = 4,
}

choice! { Health { Unknown, Healthy, Suspect, Faulty, NotFitted } }

impl Health {
    /// All states, in the order of their numbers.
    pub const ALL: [Self; 5] =
        [Self::Unknown, Self::Healthy, Self::Suspect, Self::Faulty, Self::NotFitted];

    /// Names in files and reports, in the order of the numbers.
    pub const NAMES: [&'static str; 5] = ["unknown", "healthy", "suspect", "faulty", "not_fitted"];

    /// The state in the two bits of Fd_Status: what is not fitted is unknown there.
    pub const fn bits(self) -> u64 {
        match self {
            Self::NotFitted => Self::Unknown as u64,
            other => other as u64,
        }
    }
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

impl Mode {
    /// Names in files and reports, in the order of the numbers.
    pub const NAMES: [&'static str; 5] =
        ["starting", "monitoring", "gated", "degraded", "stopping"];
}

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

impl Status {
    /// The cylinder without C2 that the frame with this alive counter names, counted from 1: each in its turn; 0 where
    /// every cylinder has a C2.
    pub fn without_c2(&self, counter: u8) -> u64 {
        let lacks = |pair: &[Health; 2]| pair[1] == Health::NotFitted;
        let all = || (1..).zip(&self.transducers).filter(|(_, pair)| lacks(pair));
        let turn = usize::from(counter).checked_rem(all().count());
        turn.and_then(|turn| all().nth(turn)).map_or(0, |(n, _)| n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_cylinder_without_c2_has_its_turn() {
        let mut status = Status::default();
        assert_eq!([0, 1, 255].map(|counter| status.without_c2(counter)), [0; 3]);
        for index in [1, 2, 5] {
            status.transducers[index][1] = Health::NotFitted;
        }
        assert_eq!([0, 1, 2, 3, 4].map(|counter| status.without_c2(counter)), [2, 3, 6, 2, 3]);
    }
}
