//! How the cylinders and transducers of a machine are called.

use super::settings::Settings;
use serde::{Deserialize, Serialize};
use tertius_core::sample::Transducer;

/// The names of a machine's cylinders and transducers. Where none is given it is the number alone, as ever.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct MachineNames {
    /// Of each cylinder, from the first.
    cylinders: Vec<CylinderNames>,
}

/// Names of one cylinder and its transducers, as in the configuration.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CylinderNames {
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    c1_name: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    c2_name: Option<String>,
}

impl Settings {
    /// How cylinders and transducers are called.
    pub fn names(&self) -> MachineNames {
        let of = |n: u8| {
            let cylinder = self.cylinder.iter().find(|cylinder| cylinder.n == n);
            cylinder.map_or_else(CylinderNames::default, |it| CylinderNames {
                name: it.name.clone(),
                c1_name: it.c1_name.clone(),
                c2_name: it.c2_name.clone(),
            })
        };
        MachineNames { cylinders: (1..=self.machine.cylinders).map(of).collect() }
    }
}

impl MachineNames {
    /// Whether there is no name at all.
    pub fn is_empty(&self) -> bool {
        self.cylinders.iter().all(|it| *it == CylinderNames::default())
    }

    /// The name of cylinder `n`, from 1, if it has one.
    pub fn of_cylinder(&self, n: impl Into<usize>) -> Option<&str> {
        self.of(n.into())?.name.as_deref()
    }

    /// The name of a transducer of cylinder `n`, if it has one.
    pub fn of_transducer(&self, n: impl Into<usize>, transducer: Transducer) -> Option<&str> {
        let names = self.of(n.into())?;
        match transducer {
            Transducer::C1 => names.c1_name.as_deref(),
            Transducer::C2 => names.c2_name.as_deref(),
        }
    }

    /// In a sentence: `cylinder 3 (FwdPort)`, `cylinder 3`.
    pub fn cylinder(&self, n: impl Into<usize>) -> String {
        let n = n.into();
        called(&format!("cylinder {n}"), self.of_cylinder(n))
    }

    /// In a column or where else there is little room: `3 FwdPort`, `3`.
    pub fn short(&self, n: impl Into<usize>) -> String {
        let n = n.into();
        self.of_cylinder(n).map_or_else(|| n.to_string(), |name| format!("{n} {name}"))
    }

    /// In a sentence: `C1 (LT-101A)`, `C1`.
    pub fn transducer(&self, n: impl Into<usize>, transducer: Transducer) -> String {
        called(transducer.label(), self.of_transducer(n, transducer))
    }

    /// All names of cylinder `n`, from 1.
    pub fn of(&self, n: usize) -> Option<&CylinderNames> {
        self.cylinders.get(n.checked_sub(1)?)
    }
}

/// What has a number and perhaps a name: the number always stays.
fn called(numbered: &str, name: Option<&str>) -> String {
    name.map_or_else(|| numbered.to_owned(), |name| format!("{numbered} ({name})"))
}
