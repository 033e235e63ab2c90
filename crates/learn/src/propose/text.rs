//! A proposal as the text of a configuration.

use super::{Certainty, NAMES, Proposal, quoted};
use crate::tables::provenance::one_line;

/// What a configuration says beside its proposal.
#[derive(Clone, Copy, Debug)]
pub struct Heading<'a> {
    /// Version of the program.
    pub version: &'a str,
    /// The machine's name.
    pub name: &'a str,
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
const TABLES: [&str; 5] = ["machine", "bus", "signals", "signals.cylinder", "comparator"];

impl Proposal {
    /// The text of the configuration.
    pub fn text(&self, heading: &Heading<'_>) -> String {
        let Heading { version, name, dbc, inputs } = *heading;
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
            let heads = match table {
                "machine" => format!("name = {}\n", quoted(&one_line(name))),
                "bus" => format!("dbc = {}\n", quoted(dbc)),
                _ => String::new(),
            };
            if heads.is_empty() && self.lines.iter().all(|line| line.table != table) {
                continue;
            }
            text += &format!("\n[{table}]\n{heads}");
            for line in self.lines.iter().filter(|line| line.table == table) {
                let (how, why) = (line.certainty.word(), one_line(&line.why));
                text += &format!("# {how}: {why}\n{} = {}\n", line.key, line.value);
            }
        }
        text += &self.cylinders();
        text
    }

    /// A table of each cylinder with its name, if the proposal has them.
    fn cylinders(&self) -> String {
        let (table, key) = NAMES;
        let Some(line) = self.line(table, key) else { return String::new() };
        let (how, why) = (line.certainty.word(), one_line(&line.why));
        let mut text = format!("\n# {how}: {why}");
        for (n, name) in (1..).zip(&self.names) {
            text += &format!("\n[[cylinder]]\nn = {n}\nname = {}\n", quoted(name));
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
