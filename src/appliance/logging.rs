//! The log of the live gateway.

use clap::ValueEnum;
use std::io;
use tracing_appender::non_blocking::{NonBlockingBuilder, WorkerGuard};
use tracing_subscriber::fmt;

/// Lines that wait for a slow reader of the log at most; more are dropped, the gateway never waits.
const WAITING_LINES: usize = 1024;

/// The form of the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LogFormat {
    Text,
    Json,
}

/// Starts the log on standard error, written by a worker of its own, so that the data path never
/// waits for whoever reads it. The log ends with the guard.
///
/// # Errors
/// If there is a log already.
pub fn start(format: LogFormat) -> Result<WorkerGuard, Box<dyn std::error::Error + Send + Sync>> {
    let builder = NonBlockingBuilder::default().lossy(true).buffered_lines_limit(WAITING_LINES);
    let (writer, guard) = builder.finish(io::stderr());
    let log = fmt().with_writer(writer).with_target(false).with_ansi(false);
    match format {
        LogFormat::Text => log.try_init()?,
        LogFormat::Json => log.json().try_init()?,
    }
    Ok(guard)
}
