//! Columns of rows as they are read.

use crate::alarm_list::{Alarm, AlarmCondition, Standing};
use rusqlite::Row;
use rusqlite::types::ValueRef;
use tertius_core::alarm::Level;
use tertius_core::time::Timestamp;

/// A text of a row. Bytes that are no UTF-8, as damage leaves them, become the replacement character.
pub(super) fn text(row: &Row<'_>, at: usize) -> rusqlite::Result<String> {
    match row.get_ref(at)? {
        ValueRef::Text(bytes) => Ok(String::from_utf8_lossy(bytes).into_owned()),
        _ => row.get(at),
    }
}

/// As [`text`], where there may be none.
pub(super) fn some_text(row: &Row<'_>, at: usize) -> rusqlite::Result<Option<String>> {
    match row.get_ref(at)? {
        ValueRef::Null => Ok(None),
        _ => text(row, at).map(Some),
    }
}

/// Levels in the order of their numbers.
const LEVELS: [Level; 5] = [Level::None, Level::Yellow, Level::Orange, Level::Red, Level::Black];

/// Level of that number.
pub(super) fn level(number: u8) -> Level {
    LEVELS.get(usize::from(number)).copied().unwrap_or_default()
}

/// Columns from which [`alarm`] is read.
pub(super) const ALARM: &str = "condition, acknowledged, shelved_until_ns, level";

/// An incident's alarm, from the columns [`ALARM`] that begin at `at`.
pub(super) fn alarm(row: &Row<'_>, at: usize) -> rusqlite::Result<Alarm> {
    let condition = text(row, at)?;
    let all = [AlarmCondition::Active, AlarmCondition::Returned, AlarmCondition::Interrupted];
    let condition = all.into_iter().find(|it| it.name() == condition).unwrap_or_default();
    let shelved: Option<i64> = row.get(at + 2)?;
    Ok(Alarm {
        standing: Standing { condition, acknowledged: row.get(at + 1)? },
        shelved_until: shelved.map(Timestamp::from_nanos),
        level: level(row.get(at + 3)?),
    })
}

/// The machine, where a cylinder has its number.
pub(super) const MACHINE: u8 = 0;

/// The cylinder of an incident by its column.
pub(super) fn cylinder(row: &Row<'_>, at: usize) -> rusqlite::Result<Option<u8>> {
    Ok(Some(row.get(at)?).filter(|number| *number != MACHINE))
}
