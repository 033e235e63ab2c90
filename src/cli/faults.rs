//! The faults of a command line.

use super::Failure;
use super::machine::Machine;
use crate::inject::{Fault, MAX_FAULTS, PlaceError, Placed, Tally, place, table};
use crate::text::counted;
use crate::time::Span;
use clap::Args;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Faults on the command line and in a table.
#[derive(Args, Debug)]
pub struct FaultOptions {
    /// A fault; several act in this order where they meet
    #[arg(long = "fault", value_name = "SPEC")]
    faults: Vec<String>,
    /// A table of faults, which act before those of --fault
    #[arg(long = "faults", value_name = "FILE.csv")]
    table: Option<PathBuf>,
}

/// What can have a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Faulty {
    /// Readings in a recording or on a bus.
    Readings,
    /// These, and a simulated machine itself.
    Machine,
}

/// A fault with its text.
#[derive(Clone, Debug)]
pub struct Named {
    pub name: String,
    pub fault: Fault,
}

impl FaultOptions {
    /// Path of the table, if there is one.
    pub fn table(&self) -> Option<&Path> {
        self.table.as_deref()
    }

    /// Reads the faults of the table, then those of the command line, of what is `faulty`.
    ///
    /// # Errors
    /// The first thing wrong with them.
    pub fn read(&self, faulty: Faulty) -> Result<Vec<Named>, Failure> {
        let mut faults = match &self.table {
            Some(path) => read_table(path, faulty)?,
            None => Vec::new(),
        };
        for text in &self.faults {
            let name = format!("--fault {text:?}");
            match Fault::parse(text) {
                Ok(fault) => faults.push(Named { name, fault }),
                Err(error) => {
                    let error = match faulty {
                        Faulty::Machine => error,
                        Faulty::Readings => error.of_readings(),
                    };
                    return Err(Failure::Wrong(format!("{name}: {error}")));
                }
            }
        }
        if faults.len() > MAX_FAULTS {
            let message = format!("{} faults, expected at most {MAX_FAULTS}", faults.len());
            return Err(Failure::Wrong(message));
        }
        Ok(faults)
    }
}

/// Finds the signals of the faults.
///
/// # Errors
/// The first fault that cannot be placed on the machine.
pub fn place_all(faults: &[Named], machine: &Machine) -> Result<Vec<Placed>, Failure> {
    let placed = faults.iter().map(|named| {
        place(&named.fault, &machine.loaded.settings, &machine.database)
            .map_err(|error| Failure::Wrong(format!("{}: {error}", named.name)))
    });
    placed.collect()
}

/// Checks that the machine has the cylinders of faults that are its own.
///
/// # Errors
/// The first fault of a cylinder that it does not have.
pub fn on_the_machine(faults: &[Named], cylinders: u8) -> Result<(), Failure> {
    let stranger = faults.iter().find(|named| !(1..=cylinders).contains(&named.fault.cylinder));
    stranger.map_or(Ok(()), |named| {
        let error = PlaceError::Cylinder { given: named.fault.cylinder, cylinders };
        Err(Failure::Wrong(format!("{}: {error}", named.name)))
    })
}

/// Checks that faults begin while the machine is simulated, which ends after `end`.
///
/// # Errors
/// The first fault that begins later.
pub fn before_the_end(faults: &[Named], end: Span) -> Result<(), Failure> {
    let late = faults.iter().find(|named| named.fault.window.from >= end);
    late.map_or(Ok(()), |Named { name, fault }| {
        let (from, end) = (fault.window.from.as_seconds(), end.as_seconds());
        Err(Failure::Wrong(format!(
            "{name}: it begins at {from} s, and the simulation ends at {end} s; expected an earlier begin (at, or t0 in \
             a table), or a longer --duration"
        )))
    })
}

/// Reports what became of each fault, on standard error, since a recording may be on standard
/// output.
pub fn report(faults: &[Named], tallies: &[Tally]) {
    for (named, tally) in faults.iter().zip(tallies) {
        tell!("{}: {}", named.name, outcome(*tally));
    }
}

fn read_table(path: &Path, faulty: Faulty) -> Result<Vec<Named>, Failure> {
    let shown = path.display();
    let wrong = |what: String| Failure::Wrong(format!("{shown}: {what}"));
    let mut bytes = Vec::new();
    File::open(path)
        .and_then(|file| file.take(table::MAX_TEXT as u64 + 1).read_to_end(&mut bytes))
        .map_err(|error| wrong(format!("cannot be read: {error}")))?;
    let text =
        String::from_utf8(bytes).map_err(|_| wrong("not a table: its text is not UTF-8".into()))?;
    let faults = table::parse(&text).map_err(|error| match faulty {
        Faulty::Machine => wrong(error.to_string()),
        Faulty::Readings => wrong(error.of_readings().to_string()),
    })?;
    let named = faults
        .into_iter()
        .map(|(line, fault)| Named { name: format!("{shown}: line {line}"), fault });
    Ok(named.collect())
}

fn outcome(tally: Tally) -> String {
    if tally.frames == 0 && tally.absent == 0 {
        return "nothing: none of its frames came during the fault".to_owned();
    }
    let mut text =
        format!("{} of {} changed or lost", tally.altered, counted(tally.frames, "frame"));
    if tally.clamped > 0 {
        text += &format!(", {} clamped to what the signal can hold", tally.clamped);
    }
    if tally.absent > 0 {
        text += &format!(", {} without the signal", tally.absent);
    }
    text
}
