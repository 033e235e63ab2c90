//! The commands.

// What they share is there as a whole, although the demonstration alone does not use all of it.
#![cfg_attr(not(feature = "cli"), allow(dead_code))]

#[cfg(feature = "cli")]
mod behind;
#[cfg(feature = "cli")]
mod broadcast;
#[cfg(feature = "cli")]
mod calibrate;
#[cfg(feature = "cli")]
mod check;
#[cfg(feature = "parquet")]
mod columns;
#[cfg(all(feature = "cli", not(feature = "parquet")))]
#[path = "without_columns.rs"]
mod columns;
#[cfg(feature = "cli")]
mod commands;
#[cfg(feature = "cli")]
mod commission;
#[cfg(feature = "cli")]
mod config;
#[cfg(feature = "cli")]
mod convert;
mod demo;
#[cfg(feature = "cli")]
mod differences;
#[cfg(feature = "cli")]
mod doctor;
#[cfg(feature = "cli")]
mod eds;
#[cfg(feature = "cli")]
mod evaluate;
#[cfg(feature = "cli")]
mod events;
#[cfg(feature = "cli")]
mod faults;
mod files;
#[cfg(feature = "cli")]
mod fleet;
mod gateway;
#[cfg(feature = "cli")]
mod history;
#[cfg(feature = "cli")]
mod identify;
#[cfg(feature = "cli")]
mod init;
#[cfg(feature = "cli")]
mod inject;
#[cfg(feature = "cli")]
mod learnt_file;
mod machine;
#[cfg(feature = "cli")]
mod monitor;
mod node;
#[cfg(feature = "cli")]
mod output;
mod overriding;
#[cfg(feature = "cli")]
mod packed;
#[cfg(feature = "cli")]
mod passing;
mod plant;
mod player;
#[cfg(feature = "cli")]
mod progress;
#[cfg(feature = "cli")]
mod proxy;
#[cfg(feature = "cli")]
mod recorded;
#[cfg(feature = "cli")]
mod recording_options;
#[cfg(feature = "cli")]
mod replay;
#[cfg(feature = "cli")]
mod run;
#[cfg(feature = "cli")]
mod simulate;
mod simulation;
mod stage;
#[cfg(feature = "cli")]
mod state;
#[cfg(feature = "cli")]
mod survey;
#[cfg(feature = "cli")]
mod tables;
#[cfg(feature = "cli")]
mod tls;
#[cfg(feature = "cli")]
mod token;
#[cfg(feature = "cli")]
mod tune;
#[cfg(feature = "cli")]
mod update;
#[cfg(feature = "cli")]
mod virtual_bus;

pub use crate::failure::Failure;
use clap::{Parser, Subcommand};

/// The third vote for redundant position transducers: monitors the cylinders of motion-compensated
/// gangways from their CAN bus. It only advises; the machine's own safety system acts.
#[derive(Debug, Parser)]
#[command(name = "tertius", version, about, max_term_width = 100)]
#[cfg_attr(
    not(feature = "cli"),
    command(after_help = "This program was built with its demonstration alone. In a clone, \
                          `cargo run --release -- --help` shows all commands.")
)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Demo(demo::Demo),
    #[cfg(feature = "cli")]
    #[command(flatten)]
    Other(Box<commands::Command>),
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A message for a person, with the exit code.
    pub fn run(self) -> Result<(), Failure> {
        match self.command {
            Command::Demo(demo) => demo.run(),
            #[cfg(feature = "cli")]
            Command::Other(command) => command.run(),
        }
    }
}
