//! Where and what the store keeps.

use std::path::PathBuf;
use tertius_config::MachineNames;
use tertius_core::time::Timestamp;

/// Why a monitor begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The program started.
    Start,
    /// The configuration was read again.
    Reload,
}

impl Cause {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::Reload => "reload",
        }
    }
}

/// The store of a machine, by its configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct StorePlan {
    /// Path of the database.
    pub path: PathBuf,
    /// Largest size of the database, bytes.
    pub size: u64,
    /// Age from which closed incidents and events give way, days.
    pub days: u32,
    /// Name of the machine.
    pub machine: String,
    /// How its cylinders and transducers are called.
    pub names: MachineNames,
    /// Identity of the configuration, see [`tertius_config::Fingerprints`].
    pub configuration: String,
    /// Sample time, s.
    pub sample_time: f64,
}

/// The store of a monitor that begins.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plan {
    pub store: StorePlan,
    pub cause: Cause,
    pub at: Timestamp,
    /// Whether the monitor goes on with the incidents of the one before, because its state was taken up.
    pub continues: bool,
}
