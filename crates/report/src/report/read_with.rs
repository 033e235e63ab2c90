//! The configuration that recordings were read with, in the reports of the commands that learn.

use std::fmt;
use tertius_config::{Fingerprints, Loaded, MachineNames};
use tertius_core::sample::Transducer;

/// A configuration by its identity, with the names by which the numbers of the report are known on the machine.
#[derive(Clone, Debug, Default)]
pub struct ReadWith {
    fingerprints: Fingerprints,
    names: MachineNames,
    cylinders: u8,
}

impl From<&Loaded> for ReadWith {
    fn from(loaded: &Loaded) -> Self {
        let settings = &loaded.settings;
        let cylinders = settings.machine.cylinders;
        Self { fingerprints: loaded.fingerprints(), names: settings.names(), cylinders }
    }
}

/// In words: `configuration 0fe1d2c3, not calibrated`; with names also `; cylinder 1 (FwdPort), cylinder 2, C1
/// (LT-102A)`.
impl fmt::Display for ReadWith {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.fingerprints)?;
        let names = &self.names;
        for n in 1..=self.cylinders {
            let tags = [Transducer::C1, Transducer::C2].into_iter();
            let tags: Vec<String> = tags
                .filter(|it| names.of_transducer(n, *it).is_some())
                .map(|it| names.transducer(n, it))
                .collect();
            if names.of_cylinder(n).is_some() || !tags.is_empty() {
                let parts = [vec![names.cylinder(n)], tags].concat();
                write!(f, "; {}", parts.join(", "))?;
            }
        }
        Ok(())
    }
}
