//! `tertius init`: proposes a configuration from a DBC and recordings.

mod asking;
mod dbc;
mod reading;

use super::Failure;
use super::files::{self, Claimed, Inputs, Mark, Overwriting};
use super::machine::Machine;
use super::recording_options::{StampOption, recordings};
use crate::bus::{Interfaces, Options};
use crate::config::design;
use crate::dbc::Database;
use crate::failure::print;
use crate::propose::{Certainty, Heading, Proposal};
use clap::Args;
use comfy_table::{ContentArrangement, Table, presets};
use console::Term;
use reading::Read;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

/// The interface of a machine whose recording does not tell one.
const USUAL_INTERFACE: &str = "can0";

/// Width of the table where there is no terminal, columns.
const WIDTH: u16 = 110;

/// Proposes a configuration: which signals of a DBC are positions, velocities, commands and states, by what a
/// recording shows and by names. Says of each line whether it is sure or a guess.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  tertius init machine.dbc monday.log.zst --output machine.toml\n  tertius init \
                        machine.dbc monday.log.zst --yes --output machine.toml\n\nThe recording should show the \
                        machine in motion: some minutes are enough. Without --output the configuration is written \
                        to standard output. The model, the correction of C2 and the thresholds are not proposed: \
                        `tertius commission` learns them."
)]
pub struct Init {
    /// The DBC of the machine's bus
    #[arg(value_name = "DBC")]
    dbc: PathBuf,
    #[arg(value_name = "LOG", help = recordings(" or .zst"))]
    logs: Vec<PathBuf>,
    /// Writes the configuration to this file [default: standard output]
    #[arg(long, short, value_name = "FILE.toml")]
    output: Option<PathBuf>,
    /// Takes the proposal without asking; necessary for --output where there is no terminal to ask at
    #[arg(long, short)]
    yes: bool,
    /// The machine's name [default: that of the DBC file]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Reads this interface of the recordings, by its name or number, and writes its name into the configuration
    /// [default: that of the recordings, or can0]
    #[arg(long, value_name = "NAME", visible_alias = "channel")]
    interface: Option<String>,
    /// Reads so many minutes from the first frame on
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = minutes)]
    minutes: u16,
    /// The meaning of the time stamps of a console recording
    #[arg(long, value_enum, default_value_t = StampOption::Auto)]
    time_stamps: StampOption,
    #[command(flatten)]
    overwriting: Overwriting,
}

/// Longest part of recordings that is read, minutes: a day.
const LONGEST: u16 = 1440;

fn minutes(text: &str) -> Result<u16, String> {
    let minutes = text.parse().ok().filter(|minutes| (1..=LONGEST).contains(minutes));
    minutes.ok_or_else(|| format!("expected whole minutes, 1 to {LONGEST}"))
}

impl Init {
    /// Runs the command.
    ///
    /// # Errors
    /// A wrong call or file; no pair of transducers with a command; nobody to ask.
    pub fn run(self) -> Result<(), Failure> {
        let asks = !self.yes && std::io::stdin().is_terminal() && std::io::stderr().is_terminal();
        let claimed = self.claim()?;
        let database = dbc::read(&self.dbc)?;
        let read = self.read(&database)?;
        let mut proposal = read.proposal;
        if !proposal.lines.is_empty() {
            let (name, line) = interface(read.interface, self.interface.as_deref());
            proposal.add_interface(&name, line);
        }
        tell!("{}", page(&proposal, &self.dbc, &read.told));
        if proposal.lines.is_empty() {
            return Err(nothing(&proposal));
        }
        if asks && claimed.is_some() {
            asking::ask(&mut proposal, &mut std::io::stdin().lock())?;
        }
        let place = self.output.as_deref().unwrap_or(Path::new("-"));
        let stem = self.dbc.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        let heading = Heading {
            version: env!("CARGO_PKG_VERSION"),
            name: self.name.as_deref().or(stem.as_deref()).unwrap_or("machine"),
            dbc: &dbc::relative(&self.dbc, files::folder(place)),
            inputs: &read.told,
        };
        let text = proposal.text(&heading);
        review(place, &text);
        let Some(claimed) = claimed else {
            return print(&text);
        };
        if !self.yes && !asks {
            return Err(Failure::Wrong(format!(
                "{} was not written: there is no terminal to ask at; take the proposal with --yes, or leave \
                 --output out to see it",
                place.display()
            )));
        }
        if asks && !asking::confirm(place, &mut std::io::stdin().lock())? {
            return Err(Failure::Failed("nothing was written".to_owned()));
        }
        claimed.write(&text)?;
        let file = place.display();
        tell!("\n{file}: written");
        let guesses = proposal.guesses();
        if !guesses.is_empty() {
            tell!("guessed, and to be looked at in the file: {}", guesses.join(", "));
        }
        tell!(
            "next: tertius check {file}\nthen: tertius commission {} --config {file}",
            self.healthy()
        );
        Ok(())
    }

    /// The recordings as `commission` takes them, for a person.
    fn healthy(&self) -> String {
        let names: Vec<String> = self.logs.iter().map(|log| log.display().to_string()).collect();
        if names.is_empty() { "healthy.log".to_owned() } else { names.join(" ") }
    }

    fn claim(&self) -> Result<Option<Claimed>, Failure> {
        let logs = self.logs.iter().map(PathBuf::as_path);
        let inputs = Inputs::new(logs.chain([self.dbc.as_path()]));
        let [claimed] = inputs.claim([(self.output.as_deref(), Mark::Whole)], self.overwriting)?;
        Ok(claimed)
    }

    fn read(&self, database: &Database) -> Result<Read, Failure> {
        let interfaces = match &self.interface {
            Some(name) if !self.logs.is_empty() => Interfaces::Only(name.clone()),
            _ => Interfaces::One(USUAL_INTERFACE.to_owned()),
        };
        let options = Options { time_stamps: self.time_stamps.into(), interfaces };
        reading::read(database, &self.logs, &options, f64::from(self.minutes) * 60.0)
    }
}

/// The interface of the bus, and how it was found: `recorded`, or `asked` for, or the usual one.
fn interface(recorded: Option<String>, asked: Option<&str>) -> (String, (Certainty, &'static str)) {
    match (recorded, asked) {
        (Some(name), _) => (name, (Certainty::Sure, "that of the recording")),
        (None, Some(name)) => (name.to_owned(), (Certainty::Sure, "as asked for")),
        (None, None) => {
            let why = "the usual name; correct it if the gateway's bus has another one";
            (USUAL_INTERFACE.to_owned(), (Certainty::Guessed, why))
        }
    }
}

fn nothing(proposal: &Proposal) -> Failure {
    let lacks: String = proposal.lacks.iter().map(|lack| format!("\n  {lack}")).collect();
    Failure::Failed(format!(
        "no pair of transducers found; looked for two signals of one unit (m, mm, or none that says otherwise) that \
         agree while they move, or are named like two positions of one cylinder, and for a command that leads \
         their motion{lacks}"
    ))
}

/// The proposal as a table.
fn page(proposal: &Proposal, dbc: &Path, told: &str) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_content_arrangement(ContentArrangement::Dynamic);
    table.set_width(Term::stderr().size_checked().map_or(WIDTH, |(_, columns)| columns));
    for line in &proposal.lines {
        let key = format!("{}.{}", line.table, line.key);
        let certainty = line.certainty.word();
        table.add_row([&key, &line.value, certainty, &line.why]);
    }
    let from = if told.is_empty() { "no recording" } else { told };
    let mut text = format!("{} with {from}\n", dbc.display());
    if !proposal.lines.is_empty() {
        text += &format!("\n{table}\n");
        for lack in &proposal.lacks {
            text += &format!("\nnot found: {lack}");
        }
    }
    text
}

/// Tells what `check` would refuse, as the configuration is written all the same: a person has to correct it.
fn review(place: &Path, text: &str) {
    if let Err(failure) = Machine::of_text(place, text, design::surveying) {
        tell!("\nto be corrected before it can be used:");
        failure.report();
    }
}
