//! Names beside the numbers of cylinders; absent where none are given.

use crate::story;
use serde::Serialize;
use tertius_config::MachineNames;
use tertius_core::verdict::Suspect;

/// Names of the cylinder that a line is about, and of the transducer that is suspected.
#[derive(Serialize)]
pub(in crate::report) struct NameFields<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub suspect_name: Option<&'a str>,
}

impl<'a> NameFields<'a> {
    pub fn new(names: &'a MachineNames, cylinder: Option<u8>, suspect: Suspect) -> Self {
        let suspected = story::transducer(suspect);
        Self {
            name: cylinder.and_then(|number| names.of_cylinder(number)),
            suspect_name: cylinder
                .zip(suspected)
                .and_then(|(number, it)| names.of_transducer(number, it)),
        }
    }
}
