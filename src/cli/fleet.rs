//! `tertius fleet`: many machines, each with its recordings.

mod listing;
mod plan;
mod recordings;
mod roster;

use super::Failure;
use clap::{Args, ValueEnum};
use listing::{lines, shell, text};
use plan::FleetPlan;
use roster::Roster;
use std::io::Write;
use std::path::PathBuf;

/// Lists the recordings of many machines in the order in which they have to be replayed: those of a machine one after
/// the other, each going on from the state that the one before has left; machines beside each other.
#[derive(Args, Debug)]
#[command(after_help = "Example of FLEET.toml, whose paths are relative to it:
  [[machine]]
  name = \"A1\"
  config = \"a1/machine.toml\"
  recordings = [\"a1/2026-*.log.zst\", \"a1/extra\"]

Recordings are files, patterns with * and ?, and folders; or URLs, in order. A machine may have an
interface, and a history of the stops to begin with.

Examples:
  tertius fleet plan FLEET.toml
  tertius fleet plan FLEET.toml --format jsonl > plan.jsonl")]
pub struct Fleet {
    /// What to do
    #[arg(value_enum)]
    action: FleetAction,
    /// The machines
    #[arg(value_name = "FLEET.toml")]
    fleet: PathBuf,
    /// A list for people, a line of JSON for each job, or a shell command for each machine
    #[arg(long, value_enum, default_value_t = PlanFormat::Human)]
    format: PlanFormat,
    /// Reads only the first frame of each recording, not all of it: recordings that overlap are then refused by the
    /// replay of the later one
    #[arg(long)]
    quick: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FleetAction {
    /// Lists what has to be replayed, in order
    Plan,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum PlanFormat {
    Human,
    Jsonl,
    Shell,
}

impl Fleet {
    /// Runs the command.
    ///
    /// # Errors
    /// A wrong FLEET.toml, configuration or recording.
    pub fn run(self) -> Result<(), Failure> {
        let FleetAction::Plan = self.action;
        let roster = Roster::read(&self.fleet)?;
        let fleet = FleetPlan::new(&roster, self.quick)?;
        let text = match self.format {
            PlanFormat::Human => text(&fleet),
            PlanFormat::Jsonl => lines(&fleet),
            PlanFormat::Shell => shell(&fleet),
        };
        let mut out = std::io::stdout();
        out.write_all(text.as_bytes()).map_err(|error| Failure::writing("standard output", &error))
    }
}
