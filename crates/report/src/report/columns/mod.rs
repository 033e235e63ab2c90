//! Results of a replay as columns: tables in Parquet files, partitioned by machine and day.
//!
//! Each column is declared once ([`TableColumn`]): its name, unit and meaning, and how it is had from a row. The schema
//! and the metadata of the files follow. A value is that of the lines of JSON, to the bit; times are whole nanoseconds.

mod column;
mod cylinders;
mod events;
mod minutes;
mod notices;
mod summary;

pub use column::{ColumnDescription, TableRow, encode, meaning_key, unit_key};
pub use cylinders::{CylinderRow, StopTrendRow};
pub use events::{DwellRow, IncidentRow, WarningRow};
pub use minutes::{MinuteRow, Minutes};
pub use notices::NoticeRow;
pub use summary::{SummaryFacts, SummaryRow};

use jiff::fmt::strtime;
use jiff::tz::TimeZone;
use tertius_core::time::Timestamp;

/// Name of a partition whose value is empty, as Hive has it.
const UNNAMED: &str = "__HIVE_DEFAULT_PARTITION__";

/// All columns of all tables.
pub fn column_descriptions() -> Vec<ColumnDescription> {
    let events = column::told::<WarningRow>().chain(column::told::<IncidentRow>());
    let events = events.chain(column::told::<NoticeRow>()).chain(column::told::<DwellRow>());
    let events = events.chain(column::told::<MinuteRow>());
    let summaries = column::told::<CylinderRow>().chain(column::told::<StopTrendRow>());
    events.chain(summaries).chain(column::told::<SummaryRow>()).collect()
}

/// Names of all tables.
pub const TABLES: [&str; 8] = [
    WarningRow::TABLE,
    IncidentRow::TABLE,
    NoticeRow::TABLE,
    DwellRow::TABLE,
    MinuteRow::TABLE,
    CylinderRow::TABLE,
    StopTrendRow::TABLE,
    SummaryRow::TABLE,
];

/// The folder of a table's partition: `warnings/machine=A%201/day=2026-03-14`. What may not be in a name is encoded as
/// in an address, which readers of such folders undo.
pub fn partition(table: &str, machine: &str, day: &str) -> String {
    format!("{}/day={day}", machine_folder(table, machine))
}

/// The folder of all days of a machine.
pub fn machine_folder(table: &str, machine: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_.".contains(&byte);
    let encoded: String = machine
        .bytes()
        .map(|byte| if plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") })
        .collect();
    format!("{table}/machine={}", if encoded.is_empty() { UNNAMED } else { &encoded })
}

/// The day of `at` in UTC: `2026-03-14`.
pub fn day(at: Timestamp) -> String {
    written("%Y-%m-%d", at)
}

/// The name of the files of a recording whose first frame is stamped `first`: `20260314T120000.000000000Z`.
pub fn file_name(first: Timestamp) -> String {
    written("%Y%m%dT%H%M%S%.9fZ", first)
}

fn written(format: &str, at: Timestamp) -> String {
    // All that fits into 64 bits of nanoseconds is a date between 1677 and 2262.
    let at = jiff::Timestamp::from_nanosecond(i128::from(at.as_nanos())).unwrap_or_default();
    strtime::format(format, &at.to_zoned(TimeZone::UTC)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use tertius_core::time::Span;

    #[test]
    fn partitions_are_named_as_other_readers_expect() {
        let at = Timestamp::from_nanos(1_700_006_399_999_999_999);
        assert_eq!(
            partition("minutes", "A 1/ä", &day(at)),
            "minutes/machine=A%201%2F%C3%A4/day=2023-11-14"
        );
        assert_eq!(file_name(at), "20231114T235959.999999999Z");
        assert_eq!(day(at.after(Span::from_nanos(1))), "2023-11-15");
        assert_eq!(day(Timestamp::from_nanos(-1)), "1969-12-31");
        assert_eq!(machine_folder("minutes", ""), "minutes/machine=__HIVE_DEFAULT_PARTITION__");
        // Nobody leaves the folder by a name.
        assert_eq!(machine_folder("minutes", ".."), "minutes/machine=..");
    }

    #[test]
    fn no_column_is_there_twice_and_each_is_told() {
        let mut all = column_descriptions();
        assert!(all.iter().all(|column| !column.meaning.is_empty()));
        assert!(TABLES.iter().all(|table| all.iter().any(|column| column.table == *table)));
        let many = all.len();
        all.sort_by_key(|column| (column.table, column.name));
        all.dedup_by_key(|column| (column.table, column.name));
        assert_eq!(all.len(), many);
    }
}
