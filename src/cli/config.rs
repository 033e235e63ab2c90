//! `tertius config`: the configuration's keys, as a file to begin with and as a schema for editors.

use super::Failure;
use crate::config::json_schema;
use clap::Args;
use std::io::Write;

/// The default configuration, in which every key has its comment.
const DEFAULTS: &str = include_str!("../../config/e-type.toml");

/// Prints what a configuration may contain: a commented file with every key and its default, or a JSON Schema by which
/// an editor completes and checks it.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  tertius config --defaults\n  tertius config --schema > tertius.schema.json\n\nTaplo, \
                        and editors with it, check a file that begins with\n  #:schema ./tertius.schema.json"
)]
#[group(required = true, multiple = false)]
pub struct Config {
    /// Prints the configuration of the default machine: every key, its default and its purpose
    #[arg(long)]
    defaults: bool,
    /// Prints the JSON Schema (draft 7) of a configuration
    #[arg(long)]
    schema: bool,
}

impl Config {
    /// Runs the command.
    ///
    /// # Errors
    /// Standard output cannot be written.
    pub fn run(self) -> Result<(), Failure> {
        let text = match (self.schema, self.defaults) {
            (true, _) => json_schema(),
            (false, _) => DEFAULTS.to_owned(),
        };
        let mut out = std::io::stdout();
        out.write_all(text.as_bytes()).map_err(|error| Failure::writing("standard output", &error))
    }
}
