//! The log for systemd's journal, field by field.
//!
//! tracing-journald 0.3 also does this, but it sends from the thread that logs, by a blocking
//! `sendto`: if the journal does not read, about the tenth datagram (net.unix.max_dgram_qlen)
//! waits, and the data path with it. Its socket cannot be changed from outside, and a `tracing`
//! event cannot be passed to another thread. Therefore events are encoded here in the journal's own
//! protocol, without waiting, and the log's worker sends them.

use std::fmt::{self, Write as _};
use std::io::{self, Write};
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use tertius_config::visible;
use tracing::field::{Field, Visit};
use tracing::{Event, Level, Subscriber};
use tracing_subscriber::fmt::FmtContext;
use tracing_subscriber::fmt::format::{FormatEvent, FormatFields, Writer};
use tracing_subscriber::registry::LookupSpan;

/// Socket on which the journal listens.
pub(super) const SOCKET: &str = "/run/systemd/journal/socket";

/// A writer to the journal: each write is an entry.
#[derive(Debug)]
pub(super) struct JournalWriter {
    socket: UnixDatagram,
    path: PathBuf,
}

impl JournalWriter {
    /// # Errors
    /// If nobody listens at `path`.
    pub(super) fn new(path: &Path) -> io::Result<Self> {
        let socket = UnixDatagram::unbound()?;
        // The journal leaves out an entry without fields.
        socket.send_to(&[], path)?;
        Ok(Self { socket, path: path.to_owned() })
    }
}

impl Write for JournalWriter {
    /// Sends an entry. This may wait for the journal, so only the log's worker may call it.
    fn write(&mut self, entry: &[u8]) -> io::Result<usize> {
        // By path, so that a journal that was started anew is found.
        self.socket.send_to(entry, &self.path)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Formats an event as `KEY=value` lines. Each field of the message becomes a field with the prefix
/// TERTIUS_, and is also part of the message for people.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct JournalFormat;

impl<S, N> FormatEvent<S, N> for JournalFormat
where
    S: Subscriber + for<'a> LookupSpan<'a>,
    N: for<'a> FormatFields<'a> + 'static,
{
    fn format_event(
        &self,
        _: &FmtContext<'_, S, N>,
        mut writer: Writer<'_>,
        event: &Event<'_>,
    ) -> fmt::Result {
        let mut entry = Entry::default();
        event.record(&mut entry);
        let priority = match *event.metadata().level() {
            Level::ERROR => 3,
            Level::WARN => 4,
            Level::INFO => 6,
            _ => 7,
        };
        writeln!(writer, "PRIORITY={priority}")?;
        writeln!(writer, "SYSLOG_IDENTIFIER=tertius")?;
        writeln!(writer, "MESSAGE={}{}", entry.message, entry.spoken)?;
        writer.write_str(&entry.fields)
    }
}

/// An event's contents.
#[derive(Debug, Default)]
struct Entry {
    message: String,
    /// Fields as ` key=value` each, for the message.
    spoken: String,
    /// Fields as one line each.
    fields: String,
}

impl Visit for Entry {
    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        // A line break would end the field, and begin another of the text's choosing.
        let text = format!("{value:?}");
        let text = visible(&text);
        if field.name() == "message" {
            self.message = text.into_owned();
            return;
        }
        _ = write!(self.spoken, " {}={text}", field.name());
        _ = writeln!(self.fields, "TERTIUS_{}={text}", field.name().to_ascii_uppercase());
    }

    fn record_str(&mut self, field: &Field, value: &str) {
        self.record_debug(field, &format_args!("{value}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;
    use tracing::{info, warn};
    use tracing_appender::non_blocking::NonBlockingBuilder;
    use tracing_subscriber::fmt;

    /// A journal for this test.
    fn journal() -> (tempfile::TempDir, UnixDatagram, PathBuf) {
        let folder = tempfile::tempdir().expect("a temporary directory");
        let path = folder.path().join("socket");
        let journal = UnixDatagram::bind(&path).expect("it is free");
        (folder, journal, path)
    }

    fn entry(journal: &UnixDatagram) -> String {
        let mut bytes = [0; 4096];
        let length = journal.recv(&mut bytes).expect("it was sent");
        String::from_utf8_lossy(&bytes[..length]).into_owned()
    }

    #[test]
    fn an_event_is_an_entry_with_its_fields() {
        let (_folder, journal, path) = journal();
        let writer = JournalWriter::new(&path).expect("the journal listens");
        let (writer, _guard) = NonBlockingBuilder::default().finish(writer);
        let log = fmt().with_writer(writer).event_format(JournalFormat).finish();
        tracing::subscriber::with_default(log, || {
            warn!(cylinder = 3, detector = "fde1", residual_mm = Some(1.25), "raised");
            info!(reason = "one\nPRIORITY=0", "two\nlines");
        });
        assert_eq!(entry(&journal), "", "asks whether it listens");
        assert_eq!(
            entry(&journal),
            "PRIORITY=4\nSYSLOG_IDENTIFIER=tertius\n\
             MESSAGE=raised cylinder=3 detector=fde1 residual_mm=1.25\n\
             TERTIUS_CYLINDER=3\nTERTIUS_DETECTOR=fde1\nTERTIUS_RESIDUAL_MM=1.25\n"
        );
        assert_eq!(
            entry(&journal),
            "PRIORITY=6\nSYSLOG_IDENTIFIER=tertius\n\
             MESSAGE=two\\nlines reason=one\\nPRIORITY=0\nTERTIUS_REASON=one\\nPRIORITY=0\n"
        );
    }

    #[test]
    fn a_journal_that_does_not_read_holds_nobody_up() {
        let (_folder, journal, path) = journal();
        let writer = JournalWriter::new(&path).expect("the journal listens");
        let builder = NonBlockingBuilder::default().lossy(true).buffered_lines_limit(8);
        let (writer, guard) = builder.finish(writer);
        let lost = writer.error_counter();
        let log = fmt().with_writer(writer).event_format(JournalFormat).finish();
        // Far more than the kernel's and the worker's queues hold together; it would wait for ever.
        let many = 10_000;
        tracing::subscriber::with_default(log, || (0..many).for_each(|i| info!(i, "event")));
        assert!(lost.dropped_lines() > 0, "they were lost instead");
        // Its end does not wait for the journal either.
        drop(guard);
        journal.set_read_timeout(Some(Duration::from_secs(10))).expect("a time that it takes");
        assert_eq!(entry(&journal), "");
        assert!(entry(&journal).contains("MESSAGE=event i=0\n"), "the oldest are kept");
    }

    #[test]
    fn without_a_journal_there_is_no_writer() {
        let folder = tempfile::tempdir().expect("a temporary directory");
        let error = JournalWriter::new(&folder.path().join("socket")).expect_err("nobody listens");
        assert_eq!(error.kind(), io::ErrorKind::NotFound);
    }
}
