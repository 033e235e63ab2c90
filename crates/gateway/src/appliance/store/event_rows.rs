//! Events as rows, and the words by which they are found.

use super::note::EventKind;
use rusqlite::{Transaction, params};
use tertius_config::MachineNames;
use tertius_core::incident::Cylinders;
use tertius_core::time::Timestamp;

/// A fact about an event, by which it is found.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Facets {
    pub cylinder: Option<u8>,
    /// All cylinders that it concerns, where these are others.
    pub cylinders: Cylinders,
    pub level: Option<u8>,
    pub suspect: Option<&'static str>,
    pub incident: Option<i64>,
}

/// Writes notes of the run `run`.
pub(super) struct Rows<'a> {
    pub step: &'a Transaction<'a>,
    /// Run of the monitor; 0 before the first.
    pub run: i64,
    /// How cylinders and transducers are called in that run.
    pub names: MachineNames,
}

impl Rows<'_> {
    /// Adds an event, and returns its number.
    pub fn put(
        &self,
        (kind, at): (EventKind, Timestamp),
        facets: Facets,
        text: &str,
    ) -> rusqlite::Result<i64> {
        let Facets { cylinder, level, suspect, incident, .. } = facets;
        self.step.execute(
            "INSERT INTO events (at_ns, run, kind, cylinder, level, suspect, incident, text)
             VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
            params![at.as_nanos(), self.run, kind.name(), cylinder, level, suspect, incident, text],
        )?;
        let id = self.step.last_insert_rowid();
        self.index(id, kind, facets, text)?;
        Ok(id)
    }

    /// Makes the event `id` known by its words, in place of what it was known by.
    pub fn index(
        &self,
        id: i64,
        kind: EventKind,
        facets: Facets,
        text: &str,
    ) -> rusqlite::Result<()> {
        let mut known = format!("kind{}", compact(kind.name()));
        let others = facets.cylinders.numbers().filter(|number| Some(*number) != facets.cylinder);
        known.extend(facets.cylinder.into_iter().chain(others).map(|it| format!(" cylinder{it}")));
        known.extend(facets.level.map(|level| format!(" level{level}")));
        known.extend(facets.suspect.map(|suspect| format!(" suspect{suspect}")));
        self.step.execute(
            "INSERT OR REPLACE INTO words (rowid, text, facets) VALUES (?, ?, ?)",
            params![id, text, known],
        )?;
        Ok(())
    }
}

/// A name as one word of the index, which takes an underscore for the end of one.
pub(super) fn compact(name: &str) -> String {
    name.replace('_', "")
}
