//! `tertius fleet`: many machines, each with its recordings.

mod beside;
mod listing;
mod plan;
mod recordings;
mod roster;
mod step;

use super::Failure;
use super::replay::processors;
use crate::failure::print;
use clap::{Args, ValueEnum};
use listing::{lines, shell, text};
use plan::FleetPlan;
use roster::Roster;
use std::path::PathBuf;

/// Most machines that are replayed at a time.
const MOST_JOBS: usize = 1024;

/// Lists the recordings of many machines in the order in which they have to be replayed, or replays them: those of a
/// machine one after the other, each going on from the state that the one before has left; machines beside each other.
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
  tertius fleet plan FLEET.toml --format jsonl > plan.jsonl
  tertius fleet run FLEET.toml --output results --jobs 4")]
pub struct Fleet {
    /// What to do
    #[arg(value_enum)]
    action: FleetAction,
    /// The machines
    #[arg(value_name = "FLEET.toml")]
    fleet: PathBuf,
    /// For plan: a list for people, a line of JSON for each job, or a shell command for each machine [default: human]
    #[arg(long, value_enum)]
    format: Option<PlanFormat>,
    /// Reads only the first frame of each recording, not all of it: recordings that overlap are then refused by the
    /// replay of the later one
    #[arg(long)]
    quick: bool,
    /// For run: the folder of the results. What is done there already is not done again
    #[arg(long, value_name = "FOLDER", required_if_eq("action", "run"))]
    output: Option<PathBuf>,
    /// For run: machines that are replayed at a time, each on one thread. The results are the same [default: as many as
    /// there are processors]
    #[arg(long, value_name = "N", value_parser = jobs)]
    jobs: Option<usize>,
}

fn jobs(text: &str) -> Result<usize, String> {
    let wanted = text.parse().ok().filter(|wanted| (1..=MOST_JOBS).contains(wanted));
    wanted.ok_or_else(|| format!("expected a number of machines, 1 to {MOST_JOBS}"))
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FleetAction {
    /// Lists what has to be replayed, in order
    Plan,
    /// Replays what is not done yet
    Run,
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
        self.refuse_of_the_other()?;
        let roster = Roster::read(&self.fleet)?;
        let fleet = FleetPlan::new(&roster, self.quick)?;
        let (text, result) = match (self.output, self.format) {
            (Some(output), _) => beside::run(&fleet, &output, self.jobs.unwrap_or_else(processors)),
            (None, None | Some(PlanFormat::Human)) => (text(&fleet), Ok(())),
            (None, Some(PlanFormat::Jsonl)) => (lines(&fleet), Ok(())),
            (None, Some(PlanFormat::Shell)) => (shell(&fleet), Ok(())),
        };
        let written = print(&text);
        result.and(written)
    }

    /// Refuses an option that only the other action has.
    fn refuse_of_the_other(&self) -> Result<(), Failure> {
        let (action, given) = match self.action {
            FleetAction::Plan => {
                let given = self.output.is_some().then_some("--output");
                ("run", given.or(self.jobs.is_some().then_some("--jobs")))
            }
            FleetAction::Run => ("plan", self.format.is_some().then_some("--format")),
        };
        match given {
            Some(option) => {
                Err(Failure::Wrong(format!("{option} is an option of `tertius fleet {action}`")))
            }
            None => Ok(()),
        }
    }
}
