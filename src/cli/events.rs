//! `tertius events`: what the event store of a box has.

use super::Failure;
use super::overriding::SetOptions;
use super::replay::zone;
use crate::appliance::store::{
    EventEntry, EventKind, ExportFormat, Filter, StoreReader, Trouble, export,
};
use crate::appliance::telemetry::clock::{Clock, SystemClock};
use crate::config;
use crate::config::visible;
use crate::report::Zone;
use crate::text::counted;
use crate::time::Timestamp;
use clap::{Args, ValueEnum};
use jiff::tz::TimeZone;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Lists incidents and events that the gateway has kept (`store.file`), the newest first. The gateway may run
/// meanwhile.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  tertius events --config /etc/tertius/machine.toml
  tertius events --config machine.toml --search 'frozen C2' --cylinder 5
  tertius events --config machine.toml --format csv > events.csv")]
pub struct Events {
    /// The machine's configuration
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    #[command(flatten)]
    set: SetOptions,
    /// Only what has these words; their beginnings are enough
    #[arg(long, value_name = "WORDS", default_value = "")]
    search: String,
    /// Only what is about this cylinder
    #[arg(long, value_name = "N")]
    cylinder: Option<u8>,
    /// Only events of this kind
    #[arg(long, value_name = "KIND", value_parser = kind)]
    kind: Option<EventKind>,
    /// Text of the newest, or all as lines of JSON or as CSV
    #[arg(long, value_enum, default_value_t = Format::Human)]
    format: Format,
    /// Most lines of the text
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u16).range(1..=500))]
    most: u16,
    /// Time zone of the text, by its name in the IANA database
    #[arg(long, value_name = "NAME", default_value = "UTC", value_parser = zone)]
    time_zone: TimeZone,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    Human,
    Jsonl,
    Csv,
}

impl Events {
    /// Runs the command.
    ///
    /// # Errors
    /// A wrong configuration, or one without a store; a store that cannot be read.
    pub fn run(self) -> Result<(), Failure> {
        let loaded = config::load_with(&self.config, &self.set.overrides()?)?;
        let Some(path) = loaded.store_path else {
            return Err(Failure::Wrong(format!(
                "{}: nothing is kept; `file = \"FILE\"` in [store] makes the gateway keep its events",
                self.config.display()
            )));
        };
        let refused = |trouble: Trouble| refusal(&path, &trouble);
        let reader = StoreReader::open(&path).map_err(refused)?;
        let filter = Filter {
            text: self.search.clone(),
            cylinder: self.cylinder,
            kind: self.kind,
            limit: usize::from(self.most),
            ..Filter::default()
        };
        let (now, names) = (SystemClock::new().system(), loaded.settings.names());
        let mut out = BufWriter::new(io::stdout().lock());
        let written = match self.format {
            Format::Human => {
                let found = reader.search(&filter, now).map_err(refused)?;
                self.list(&found.entries, &mut out).map(|()| found.damaged)
            }
            Format::Jsonl => export(&reader, &filter, ExportFormat::Jsonl, &names, now, &mut out),
            Format::Csv => export(&reader, &filter, ExportFormat::Csv, &names, now, &mut out),
        };
        let damaged =
            written.and_then(|damaged| out.flush().map(|()| damaged).map_err(Trouble::from));
        let damaged = damaged.map_err(refused)?;
        if damaged > 0 {
            tell!(
                "{}: {} with bytes that are no UTF-8, shown as \u{fffd}: the file was damaged; look at the disk, and keep a \
                 copy of the file",
                path.display(),
                counted(damaged as u64, "row"),
            );
        }
        Ok(())
    }

    fn list(&self, entries: &[EventEntry], out: &mut impl Write) -> Result<(), Trouble> {
        let zone = Zone::new(self.time_zone.clone(), Timestamp::default(), f64::MAX);
        if entries.is_empty() {
            writeln!(out, "Nothing of that kind is kept.")?;
        }
        for entry in entries {
            let (at, id, text) = (zone.moment(entry.at_s), entry.id, visible(&entry.text));
            match &entry.incident {
                Some(incident) => {
                    let state = incident.state.replace('_', ", ");
                    writeln!(out, "{at}  incident {id}: {text} [{state}]")?;
                }
                None => writeln!(out, "{at}  {}: {text}", visible(&entry.kind.replace('_', " ")))?,
            }
        }
        Ok(())
    }
}

fn refusal(path: &Path, trouble: &Trouble) -> Failure {
    match trouble {
        Trouble::Output(error) if error.kind() == io::ErrorKind::BrokenPipe => {
            Failure::OutputClosed
        }
        Trouble::Output(error) => Failure::writing("standard output", error),
        trouble => Failure::Wrong(format!("{}: {trouble}", path.display())),
    }
}

fn kind(name: &str) -> Result<EventKind, String> {
    let found = EventKind::ALL.into_iter().find(|kind| kind.name() == name);
    found.ok_or_else(|| {
        let names = EventKind::ALL.map(EventKind::name).join(", ");
        format!("expected one of {names}")
    })
}
