//! The log of the live gateway.

use super::journald::{JournalFormat, JournalWriter, SOCKET};
use clap::ValueEnum;
use std::io;
use std::path::Path;
use tertius_config::visible;
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
    let (writer, guard) = worker(Plain(io::stderr()));
    let log = fmt().with_writer(writer).with_target(false).with_ansi(false);
    match format {
        // A script that asks for more than the text also wants the module.
        LogFormat::Json => log.json().with_target(true).try_init(),
        LogFormat::Text | LogFormat::Journal => log.try_init(),
    }
    .map_err(LogError::Started)?;
    Ok(guard)
}

/// Takes a line of the log with each write, in which nothing acts on a terminal and nothing begins another line.
struct Plain<W>(W);

impl<W: io::Write> io::Write for Plain<W> {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        let text = String::from_utf8_lossy(line.strip_suffix(b"\n").unwrap_or(line));
        self.0.write_all(format!("{}\n", visible(&text)).as_bytes())?;
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

fn worker(out: impl io::Write + Send + 'static) -> (NonBlocking, WorkerGuard) {
    NonBlockingBuilder::default().lossy(true).buffered_lines_limit(WAITING_LINES).finish(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn a_line_is_one_and_does_nothing_to_a_terminal() {
        let mut out = Plain(Vec::new());
        out.write_all("INFO open\u{1b}[2J\u{9b}m\nINFO forged\n".as_bytes()).expect("it is memory");
        assert_eq!(out.0, b"INFO open\\u001b[2J\\u009bm\\nINFO forged\n");
    }
}
