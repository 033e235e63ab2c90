//! The commands.

mod broadcast;
mod calibrate;
mod check;
#[cfg(feature = "parquet")]
mod columns;
#[cfg(not(feature = "parquet"))]
#[path = "without_columns.rs"]
mod columns;
mod commission;
mod config;
mod convert;
mod demo;
mod doctor;
mod eds;
mod evaluate;
mod events;
mod faults;
mod files;
mod fleet;
mod history;
mod identify;
mod init;
mod inject;
mod learnt_file;
mod machine;
mod monitor;
mod node;
mod output;
mod overriding;
mod packed;
mod passing;
mod plant;
mod player;
mod progress;
mod proxy;
mod recorded;
mod replay;
mod run;
mod simulate;
mod simulation;
mod stage;
mod state;
mod survey;
mod tables;
mod token;
mod tune;
mod update;
mod virtual_bus;

pub use crate::failure::Failure;
use clap::{Parser, Subcommand};

/// The third vote for redundant position transducers: monitors the cylinders of motion-compensated
/// gangways from their CAN bus. It only advises; the machine's own safety system acts.
#[derive(Debug, Parser)]
#[command(name = "tertius", version, about, max_term_width = 100)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Demo(demo::Demo),
    Init(init::Init),
    Run(run::Run),
    Replay(replay::Replay),
    Check(check::Check),
    Config(config::Config),
    Doctor(doctor::Doctor),
    Monitor(monitor::Monitor),
    Eds(eds::Eds),
    Events(events::Events),
    Convert(convert::Convert),
    Fleet(fleet::Fleet),
    Inject(inject::Inject),
    Commission(commission::Commission),
    Identify(identify::Identify),
    Simulate(simulate::Simulate),
    Evaluate(evaluate::Evaluate),
    Calibrate(calibrate::Calibrate),
    Tune(tune::Tune),
    Token(token::Token),
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A message for a person, with the exit code.
    pub fn run(self) -> Result<(), Failure> {
        match self.command {
            Command::Demo(demo) => demo.run(),
            Command::Init(init) => init.run(),
            Command::Run(run) => run.run(),
            Command::Replay(replay) => replay.run(),
            Command::Check(check) => check.run(),
            Command::Config(config) => config.run(),
            Command::Doctor(doctor) => doctor.run(),
            Command::Monitor(monitor) => monitor.run(),
            Command::Eds(eds) => eds.run(),
            Command::Events(events) => events.run(),
            Command::Convert(convert) => convert.run(),
            Command::Fleet(fleet) => fleet.run(),
            Command::Inject(inject) => inject.run(),
            Command::Commission(commission) => commission.run(),
            Command::Identify(identify) => identify.run(),
            Command::Simulate(simulate) => simulate.run(),
            Command::Evaluate(evaluate) => evaluate.run(),
            Command::Calibrate(calibrate) => calibrate.run(),
            Command::Tune(tune) => tune.run(),
            Command::Token(token) => token.run(),
        }
    }
}

/// Help for an argument that names recordings, which may also be `packed` so.
fn recordings(packed: &str) -> String {
    let formats = crate::bus::format_names();
    format!("Recordings, read in turn, in any of these formats: {formats}; may be .gz{packed}")
}
