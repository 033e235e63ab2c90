//! The log of the live gateway.

use super::journald::{JournalFormat, JournalWriter, SOCKET};
use crate::failure::Failure;
use clap::ValueEnum;
use std::io;
use std::path::Path;
use tracing_appender::non_blocking::{NonBlocking, NonBlockingBuilder, WorkerGuard};
use tracing_subscriber::fmt;

/// Most lines that wait for a slow reader of the log; more are dropped, since the gateway never
/// waits.
const WAITING_LINES: usize = 1024;

/// Format of the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LogFormat {
    Text,
    Json,
    Journal,
}

/// Why the log cannot be started.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    #[error(
        "--log journal, but systemd's journal does not listen at {SOCKET}: {0}; use --log json, \
         which a service manager's journal takes from standard error"
    )]
    NoJournal(#[source] io::Error),
    #[error("the log cannot be started: {0}")]
    Started(#[source] Box<dyn std::error::Error + Send + Sync>),
}

impl From<LogError> for Failure {
    fn from(error: LogError) -> Self {
        match error {
            LogError::NoJournal(_) => Self::Wrong(error.to_string()),
            LogError::Started(_) => Self::Failed(error.to_string()),
        }
    }
}

/// Starts the log on standard error or in the journal. A worker writes it, so that the data path
/// never waits for its reader. The log ends with the guard.
///
/// # Errors
/// A log already exists, or there is no journal.
pub fn start(format: LogFormat) -> Result<WorkerGuard, LogError> {
    if format == LogFormat::Journal {
        let journal = JournalWriter::new(Path::new(SOCKET)).map_err(LogError::NoJournal)?;
        let (writer, guard) = worker(journal);
        let log = fmt().with_writer(writer).event_format(JournalFormat);
        log.try_init().map_err(LogError::Started)?;
        return Ok(guard);
    }
    let (writer, guard) = worker(io::stderr());
    let log = fmt().with_writer(writer).with_target(false).with_ansi(false);
    match format {
        LogFormat::Json => log.json().try_init(),
        LogFormat::Text | LogFormat::Journal => log.try_init(),
    }
    .map_err(LogError::Started)?;
    Ok(guard)
}

fn worker(out: impl io::Write + Send + 'static) -> (NonBlocking, WorkerGuard) {
    NonBlockingBuilder::default().lossy(true).buffered_lines_limit(WAITING_LINES).finish(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_journal_is_a_wrong_call() {
        let failure = Failure::from(LogError::NoJournal(io::ErrorKind::NotFound.into()));
        assert_eq!(failure.exit_code(), 2);
        assert!(failure.to_string().contains("use --log json"), "{failure}");
    }
}
