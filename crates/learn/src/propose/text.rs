//! A proposal as the text of a configuration.

use super::{Certainty, Proposal, quoted};
use crate::tables::provenance::one_line;

/// What a configuration says beside its proposal.
#[derive(Clone, Copy, Debug)]
pub struct Heading<'a> {
    /// Version of the program.
    pub version: &'a str,
    /// The machine's name.
    pub name: &'a str,
    /// Network interface of the bus.
    pub interface: &'a str,
    /// Path of the DBC from the folder of the configuration.
    pub dbc: &'a str,
    /// The recordings, and how much of them was read, in words; empty without any.
    pub inputs: &'a str,
}

const ABOUT: &str = "\
# Each line says how it was found. sure: the recording shows it. guessed: by a name or a custom alone; look at it.
# What belongs to this machine alone is not here yet: its model, the correction of C2, weights and thresholds.
# `tertius commission` learns them from healthy recordings and adds them to this file. Without them R1 and R2 are
# judged by the model and the thresholds of another machine (thesis, Table 4-1). The order is:
#   tertius check, tertius commission, tertius replay, tertius doctor, tertius run
";

/// Tables of a proposal, in the order of the file.
const TABLES: [&str; 3] = ["machine", "signals", "signals.cylinder"];

impl Proposal {
    /// The text of the configuration.
    pub fn text(&self, heading: &Heading<'_>) -> String {
        let Heading { version, name, interface, dbc, inputs } = *heading;
        let mut text = String::new();
        text += &format!("# By tertius {version} init, for {}.\n", one_line(name));
        if !inputs.is_empty() {
            text += &format!("# From {}\n", one_line(inputs));
        }
        text += ABOUT;
        for lack in &self.lacks {
            text += &format!("# not found: {}\n", one_line(lack));
        }
        for table in TABLES {
            text += &format!("\n[{table}]\n");
            if table == "machine" {
                text += &format!("name = {}\n", quoted(&one_line(name)));
            }
            for line in self.lines.iter().filter(|line| line.table == table) {
                let (how, why) = (line.certainty.word(), one_line(&line.why));
                text += &format!("# {how}: {why}\n{} = {}\n", line.key, line.value);
            }
            if table == "machine" {
                let (interface, dbc) = (quoted(interface), quoted(dbc));
                text += &format!("\n[bus]\ninterface = {interface}\ndbc = {dbc}\n");
                text += "# guessed: the usual rate; correct it if the bus has another one\nbitrate = 500000\n";
            }
        }
        text
    }
}

impl Certainty {
    /// In a word.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Guessed => "guessed",
            Self::Sure => "sure",
        }
    }
}
