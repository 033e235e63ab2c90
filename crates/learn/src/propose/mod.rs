//! From a DBC and a recording to a proposal for a configuration: which signals are what, and how sure that is.
//!
//! Evidence counts before names. Two signals that agree to millimetres while they move are the two transducers of a
//! cylinder; the signal that leads their motion is its command; one that is their derivative is a velocity. Names
//! decide what no motion shows: status bits, pressures, the platform's state. Where the recording shows nothing, as
//! on a machine at rest, names alone give a guess; where neither shows a pair of transducers with a command, there
//! is no proposal.
//!
//! A recording is read twice: [`BusTally`] first, which takes memory by the signals of the DBC, and then
//! [`Tracks`] of the signals that move, bounded in number and cycles.

mod catalogue;
mod cylinders;
mod finding;
mod guessing;
mod likeness;
mod machine;
mod naming;
mod pairing;
mod pattern;
mod tally;
#[cfg(test)]
mod tests;
mod text;
mod track;
mod words;

pub use catalogue::Catalogue;
pub use finding::{Finder, find};
pub use tally::BusTally;
pub use text::Heading;
pub use track::Tracks;

/// Most cylinders of a machine.
const MOST_CYLINDERS: usize = tertius_core::alarm::status::MAX_CYLINDERS;

/// How sure a part of a proposal is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Certainty {
    /// By a name or a custom alone.
    Guessed,
    /// The recording shows it.
    Sure,
}

/// One line of a proposed configuration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProposedLine {
    /// Table of the key, for example `signals.cylinder`.
    pub table: &'static str,
    pub key: &'static str,
    /// Value as TOML.
    pub value: String,
    pub certainty: Certainty,
    /// Evidence, for a person.
    pub why: String,
}

/// A proposal for the configuration of a machine.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Proposal {
    /// Lines by table, in the order of the configuration. Empty if no cylinder was found.
    pub lines: Vec<ProposedLine>,
    /// What was looked for and not found, or cannot be used yet, for a person.
    pub lacks: Vec<String>,
    /// Names of the cylinders, which are those of one line; empty where they have none.
    names: Vec<String>,
}

/// Table and key of the line with the names of all cylinders, which the file has in a table of each.
const NAMES: (&str, &str) = ("cylinder", "name");

impl Proposal {
    /// Adds the line of the bus's interface.
    pub fn add_interface(&mut self, name: &str, (certainty, why): (Certainty, &str)) {
        let place = self.lines.iter().position(|line| line.table == "bus");
        let (table, key, value, why) = ("bus", "interface", quoted(name), why.to_owned());
        let line = ProposedLine { table, key, value, certainty, why };
        self.lines.insert(place.unwrap_or(self.lines.len()), line);
    }

    /// Full names of the keys whose values are guesses.
    pub fn guesses(&self) -> Vec<String> {
        let guessed = self.lines.iter().filter(|line| line.certainty == Certainty::Guessed);
        guessed.map(|line| format!("{}.{}", line.table, line.key)).collect()
    }

    /// The line of a key, for example of `signals.cylinder` and `c1`.
    pub fn line(&self, table: &str, key: &str) -> Option<&ProposedLine> {
        self.lines.iter().find(|line| line.table == table && line.key == key)
    }
}

/// A text as TOML.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// A value with its unit, millimetres where they read better.
fn shown(value: f64, unit: &str) -> String {
    let (value, unit) = match unit {
        "m" if value.abs() < 0.1 => (value * 1e3, "mm"),
        _ => (value, unit),
    };
    let digits = (2 - value.abs().max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
    format!("{value:.digits$} {unit}").trim_end().to_owned()
}
