//! The history of the stops that a replay continues.

use super::Failure;
use super::machine::Machine;
use crate::appliance::history::HistoryFile;
use crate::monitor::Monitor;
use crate::monitor::cylinder::CylinderDesign;
use crate::sample::Transducer;
use crate::sequential::Archive;
use std::path::Path;

/// A history and the file that it is kept in.
#[derive(Debug)]
pub struct History {
    file: HistoryFile,
    archive: Archive,
}

impl History {
    /// The history of `machine` in `path`, empty if the file does not exist.
    ///
    /// # Errors
    /// The file is something else, which stays untouched; or nothing is read on the stops
    /// of this machine.
    pub fn read(path: &Path, machine: &Machine) -> Result<Self, Failure> {
        if let Some(lack) = lack(machine) {
            return Err(Failure::Wrong(format!("--history cannot be used here: {lack}")));
        }
        let about = &machine.loaded.settings.machine;
        let file = HistoryFile::new(path.to_owned());
        let read = file.read(&about.name, about.cylinders).map_err(|error| {
            let path = path.display();
            Failure::Wrong(format!(
                "{path}: {error}. Nothing was changed; name another file, or move this one away to \
                 begin a new history"
            ))
        });
        let archive = read?.unwrap_or_else(|| Archive::new(&about.name, about.cylinders));
        Ok(Self { file, archive })
    }

    pub const fn archive(&self) -> &Archive {
        &self.archive
    }

    /// Writes the history with what `monitor` has read since.
    ///
    /// # Errors
    /// The file cannot be written; the previous one then remains.
    pub fn write(mut self, monitor: &Monitor) -> Result<(), Failure> {
        monitor.save(&mut self.archive);
        let path = self.file.path().display().to_string();
        self.file.write(&self.archive).map_err(|error| Failure::writing(&path, &error))
    }
}

/// What the configuration lacks for reading on the stops, and what to do.
pub fn lack(machine: &Machine) -> Option<String> {
    let name = machine.loaded.document.name();
    if machine.loaded.settings.sequential.stop_states.is_none() {
        return Some(format!(
            "{name} has no `sequential.stop_states`, the states in which the rods stand on their stops; add for \
             example stop_states = [\"settled\"] to [sequential]"
        ));
    }
    let is_read = |it: &CylinderDesign| it.sequential.is_some() || !it.has(Transducer::C2);
    (!machine.design.cylinders.iter().any(is_read)).then(|| {
        format!(
            "{name} has no cylinder with `sequential`, the tables of `tertius calibrate`; write them with --into {name}"
        )
    })
}
