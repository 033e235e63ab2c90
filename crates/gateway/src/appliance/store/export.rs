//! Export as CSV and as lines of JSON, page by page.

use super::query::{Filter, MOST_FOUND};
use super::reader::{EventEntry, StoreReader};
use super::trouble::Trouble;
use serde::Serialize;
use std::io::Write;
use tertius_config::{MachineNames, visible};
use tertius_core::time::Timestamp;
use tertius_report::report::csv::{NameColumn, field};

/// Form of an export.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExportFormat {
    /// Comma-separated values with a header, for spreadsheets.
    Csv,
    /// Lines of JSON, an object each.
    Jsonl,
}

/// Columns of a CSV, beside that of the cylinder's name.
pub const EXPORT_COLUMNS: [&str; 17] = [
    "id", "at_utc", "at_s", "kind", "cylinder", "level", "suspect", "fault", "state", "ending",
    "end_s", "size_m", "quantity", "peak_m", "limit_m", "about", "text",
];

/// Writes the entries for which `filter` holds to `out`, the newest first, whatever its limit, and returns how many of
/// them are damaged ([`EventPage::damaged`](super::EventPage)). Cylinders are called by their `names` of today. Memory is that
/// of a page; what is written meanwhile comes in no page.
///
/// # Errors
/// The store cannot be read, or `out` not be written.
pub fn export(
    reader: &StoreReader,
    filter: &Filter,
    format: ExportFormat,
    names: &MachineNames,
    now: Timestamp,
    out: &mut impl Write,
) -> Result<usize, Trouble> {
    let column = NameColumn::new(names);
    let mut damaged = 0;
    let mut page = Filter { limit: MOST_FOUND, ..filter.clone() };
    if format == ExportFormat::Csv {
        writeln!(out, "{}", column.among(EXPORT_COLUMNS))?;
    }
    loop {
        let found = reader.search(&page, now)?;
        damaged += found.damaged;
        for entry in &found.entries {
            match format {
                ExportFormat::Csv => writeln!(out, "{}", row(entry, &column).join(","))?,
                ExportFormat::Jsonl => {
                    let name = entry.cylinder.and_then(|number| names.of_cylinder(number));
                    let line = serde_json::to_string(&NamedEntry { entry, name });
                    let line = line.map_err(|error| Trouble::Other(error.to_string()))?;
                    writeln!(out, "{}", visible(&line))?;
                }
            }
        }
        page.before = found.next;
        if found.next.is_none() {
            return Ok(damaged);
        }
    }
}

/// An entry with the name of its cylinder.
#[derive(Serialize)]
struct NamedEntry<'a> {
    #[serde(flatten)]
    entry: &'a EventEntry,
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<&'a str>,
}

/// Fields in the order of [`EXPORT_COLUMNS`]; behind the number of the cylinder is its name.
fn row(entry: &EventEntry, column: &NameColumn) -> [String; 17] {
    let incident = entry.incident.as_ref();
    let number_of = |cylinder: Option<u8>| cylinder.map_or(String::new(), |it| it.to_string());
    let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    let text = |value: Option<&str>| value.map_or(String::new(), field);
    [
        entry.id.to_string(),
        utc(entry.at_s),
        entry.at_s.to_string(),
        field(&entry.kind),
        number_of(entry.cylinder) + column.after(entry.cylinder),
        text(entry.level),
        text(entry.suspect.as_deref()),
        text(incident.map(|it| it.fault.as_str())),
        text(incident.map(|it| it.state)),
        text(incident.and_then(|it| it.ending.as_deref())),
        number(incident.and_then(|it| it.end_s)),
        number(incident.and_then(|it| it.size_m)),
        text(incident.and_then(|it| it.quantity.as_deref())),
        number(incident.and_then(|it| it.peak_m)),
        number(incident.and_then(|it| it.limit_m)),
        entry.about.map_or(String::new(), |id| id.to_string()),
        field(&entry.text),
    ]
}

/// Date and time, as RFC 3339 has them.
fn utc(at: Timestamp) -> String {
    let at = jiff::Timestamp::from_nanosecond(i128::from(at.as_nanos()));
    at.map_or(String::new(), |at| at.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_as_rfc_3339_has_them() {
        assert_eq!(
            utc(Timestamp::from_nanos(1_700_000_000_250_000_000)),
            "2023-11-14T22:13:20.25Z"
        );
    }
}
