use clap::Parser;
use std::io::{self, Write};
use std::process::ExitCode;
use tertius::cli::Arguments;
use tertius::config::visible_lines;

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(refusal) => return refused(&refusal),
    };
    match arguments.run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.report();
            ExitCode::from(failure.exit_code())
        }
    }
}

/// Says why the call is refused, or what was asked for.
fn refused(refusal: &clap::Error) -> ExitCode {
    let text = refusal.render().to_string();
    match visible_lines(&text) {
        shown if shown == text => refusal.exit(),
        // What was given acts on a terminal, so that the colours are left out.
        shown => {
            _ = write!(io::stderr(), "{shown}");
            ExitCode::from(u8::try_from(refusal.exit_code()).unwrap_or(2))
        }
    }
}
