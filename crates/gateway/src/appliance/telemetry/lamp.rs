//! The state of a transducer as a lamp, in the categories of NAMUR NE 107, which people in the field know.

use serde::{Deserialize, Serialize};
use tertius_core::alarm::status::Health;

/// A category of NE 107. *Unknown* is a state of its own: it is never shown as good.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Lamp {
    /// A warning stands that blames the transducer.
    Failure,
    /// Its device is not operational, as somebody who works on it leaves it, or its frames lack what is configured.
    CheckFunction,
    /// A warning stands that may be its fault.
    OutOfSpecification,
    /// Its readings on the stops drift.
    MaintenanceRequired,
    Good,
    /// The cylinder does not have it; no category of NE 107.
    NotFitted,
    /// There is no evidence either way, or a category that this version does not know.
    #[serde(other)]
    Unknown,
}

impl Lamp {
    /// The lamp of a transducer that is `health`, of which there is something to `check`, and which the stops say `drifts`.
    pub const fn new(health: Health, check: bool, drifts: bool) -> Self {
        match (health, check, drifts) {
            (Health::NotFitted, ..) => Self::NotFitted,
            (Health::Faulty, ..) => Self::Failure,
            (_, true, _) => Self::CheckFunction,
            (Health::Suspect, ..) => Self::OutOfSpecification,
            (Health::Healthy, _, true) => Self::MaintenanceRequired,
            (Health::Healthy, ..) => Self::Good,
            (Health::Unknown, ..) => Self::Unknown,
        }
    }

    /// Its number for programs: 0 is unknown, 1 is good.
    pub const fn number(self) -> u8 {
        match self {
            Self::Unknown => 0,
            Self::Good => 1,
            Self::MaintenanceRequired => 2,
            Self::OutOfSpecification => 3,
            Self::CheckFunction => 4,
            Self::Failure => 5,
            Self::NotFitted => 6,
        }
    }

    /// The category in words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Failure => "failure",
            Self::CheckFunction => "check function",
            Self::OutOfSpecification => "out of specification",
            Self::MaintenanceRequired => "maintenance required",
            Self::Good => "good",
            Self::NotFitted => "not fitted",
            Self::Unknown => "unknown",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_evidence_is_good_and_a_failure_outranks_all() {
        for (check, drifts) in [(false, false), (false, true), (true, false), (true, true)] {
            assert_eq!(Lamp::new(Health::Faulty, check, drifts), Lamp::Failure);
            assert_eq!(Lamp::new(Health::NotFitted, check, drifts), Lamp::NotFitted);
            for health in [Health::Unknown, Health::Suspect, Health::Healthy] {
                let good = health == Health::Healthy && !check && !drifts;
                assert_eq!(Lamp::new(health, check, drifts) == Lamp::Good, good);
            }
        }
        assert_eq!(Lamp::new(Health::Unknown, false, true), Lamp::Unknown);
        assert_eq!(Lamp::new(Health::Healthy, false, true), Lamp::MaintenanceRequired);
    }
}
