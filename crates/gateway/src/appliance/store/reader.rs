//! Reading the store: what a page or a script shows.

use super::columns::{MACHINE, text};
use super::entries::{
    ALARM_COLUMNS, ENTRY_COLUMNS, alarm_entry, entry, hour_entry, incident_page, is_damaged,
    seconds, stop_entry, warning_entry,
};
pub use super::entries::{
    ActEntry, AlarmEntry, EventEntry, HourEntry, IncidentFields, IncidentPage, Revision, StopEntry,
    WarningEntry,
};
use super::query::Filter;
use super::schema;
use super::trouble::Trouble;
use crate::alarm_list::{AlarmCondition, LONGEST_SHELVING};
use rusqlite::{Connection, OptionalExtension, Row, params, params_from_iter};
use serde::Serialize;
use std::path::Path;
use tertius_core::time::Timestamp;

/// Most alarms of an overview, the worst first.
const ALARMS: usize = 200;

/// Most rows of each list of an incident's page, and of the stops.
const ROWS: usize = 500;

/// Most bytes of text in a page of a search, which then has fewer entries: people write notes of two kilobytes.
const MOST_TEXT: usize = 256 * 1024;

/// Most hours that are returned: those of a month, of all residuals of a cylinder.
const HOURS: usize = 3 * 24 * 31;

/// A connection of its own, which reads only. Opening one takes about a millisecond, so that each request may have
/// its own: it then sees a file that was set aside as little as one that was replaced.
#[derive(Debug)]
pub struct StoreReader(Connection);

/// The alarm list and what led to it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AlarmOverview {
    /// Alarms that a person has to deal with: active ones first, then by level, then the newest.
    pub alarms: Vec<AlarmEntry>,
    pub counts: Counts,
    /// The program and the configuration that wrote last; `None` for a store without a run.
    pub run: Option<RunEntry>,
}

/// Numbers of listed alarms; a shelved one counts as such only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    pub unacknowledged: u64,
    pub acknowledged: u64,
    /// Returned, not acknowledged.
    pub returned: u64,
    /// Interrupted, not acknowledged.
    pub interrupted: u64,
    pub shelved: u64,
}

/// A run of the monitor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunEntry {
    pub run: i64,
    /// Time of its begin, s since 1970.
    pub begin_s: f64,
    /// `start` or `reload`
    pub cause: String,
    pub version: String,
    pub machine: String,
    pub configuration: String,
}

/// A page of a search.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EventPage {
    /// The newest first.
    pub entries: Vec<EventEntry>,
    /// [`Filter::before`] of the next page; `None` on the last.
    pub next: Option<i64>,
    /// Number of entries with bytes that are no UTF-8, which are shown with the replacement character.
    #[serde(skip_serializing_if = "is_zero")]
    pub damaged: usize,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
const fn is_zero(count: &usize) -> bool {
    *count == 0
}

impl StoreReader {
    /// Opens the store at `path`.
    ///
    /// # Errors
    /// There is none, or it cannot be read.
    pub fn open(path: &Path) -> Result<Self, Trouble> {
        schema::open_to_read(path).map(Self)
    }

    pub(super) const fn connection(&self) -> &Connection {
        &self.0
    }

    /// The alarm list at `now`; `gated`: the monitor does not judge by design.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn overview(&self, now: Timestamp, gated: bool) -> Result<AlarmOverview, Trouble> {
        let sql = format!(
            "SELECT {ALARM_COLUMNS} FROM incidents i JOIN events e ON e.id = i.id
             WHERE listed = 1 ORDER BY i.active DESC, i.level DESC, i.id DESC LIMIT {ALARMS}"
        );
        let alarms = self.list(&sql, params![], |row| alarm_entry(row, now, gated))?;
        let counts = self.counts(now)?;
        let run = self.0.query_row(
            "SELECT id, begin_ns, cause, version, machine, configuration FROM runs
             ORDER BY id DESC LIMIT 1",
            [],
            |row| {
                Ok(RunEntry {
                    run: row.get(0)?,
                    begin_s: seconds(row.get(1)?),
                    cause: text(row, 2)?,
                    version: text(row, 3)?,
                    machine: text(row, 4)?,
                    configuration: text(row, 5)?,
                })
            },
        );
        Ok(AlarmOverview { alarms, counts, run: run.optional()? })
    }

    /// Counts that the database keeps, less those that are shelved.
    fn counts(&self, now: Timestamp) -> Result<Counts, Trouble> {
        let kept = "SELECT condition, acknowledged, count FROM tallies";
        let shelved = "SELECT condition, acknowledged, count(*) FROM incidents
             WHERE shelved_until_ns > ?1 AND shelved_until_ns <= ?1 + ?2 AND listed = 1 GROUP BY 1, 2";
        let tally = |row: &Row<'_>| Ok((text(row, 0)?, row.get(1)?, row.get(2)?));
        let kept: Vec<(String, bool, i64)> = self.list(kept, [], tally)?;
        let until = params![now.as_nanos(), LONGEST_SHELVING.as_nanos()];
        let shelved: Vec<(String, bool, i64)> = self.list(shelved, until, tally)?;
        let of = |condition: AlarmCondition, acknowledged| {
            let is = |it: &&(String, bool, i64)| it.0 == condition.name() && it.1 == acknowledged;
            let sum = |all: &[(String, bool, i64)]| all.iter().find(is).map_or(0, |it| it.2);
            (sum(&kept) - sum(&shelved)).max(0).cast_unsigned()
        };
        Ok(Counts {
            unacknowledged: of(AlarmCondition::Active, false),
            acknowledged: of(AlarmCondition::Active, true),
            returned: of(AlarmCondition::Returned, false),
            interrupted: of(AlarmCondition::Interrupted, false),
            shelved: shelved.iter().map(|it| it.2.max(0).cast_unsigned()).sum(),
        })
    }

    /// Incidents and events for which `filter` holds, the newest first; states as they are at `now`.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn search(&self, filter: &Filter, now: Timestamp) -> Result<EventPage, Trouble> {
        let conditions = filter.conditions(&self.0)?;
        // One more says whether there are more.
        let limit = filter.limit();
        let sql = format!("SELECT {ENTRY_COLUMNS} FROM {} LIMIT {}", conditions.sql, limit + 1);
        let values = params_from_iter(conditions.values);
        let mut query = self.0.prepare(&sql)?;
        let rows = query.query_map(values, |row| Ok((entry(row, now)?, is_damaged(row))))?;
        let mut rows = rows.collect::<rusqlite::Result<Vec<(EventEntry, bool)>>>()?;
        let mut room = MOST_TEXT;
        let is_room = |(entry, _): &&(EventEntry, bool)| {
            room = room.saturating_sub(entry.text.len());
            room > 0
        };
        let shown = rows.iter().take(limit).take_while(is_room).count().max(1);
        let more = rows.len() > shown;
        rows.truncate(shown);
        let damaged = rows.iter().filter(|(_, is_damaged)| *is_damaged).count();
        let entries: Vec<EventEntry> = rows.into_iter().map(|(entry, _)| entry).collect();
        let next = entries.last().filter(|_| more).map(|last| last.id);
        Ok(EventPage { entries, next, damaged })
    }

    /// All that is known of the incident `id`; `None` if there is none.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn incident(&self, id: i64, now: Timestamp) -> Result<Option<IncidentPage>, Trouble> {
        let sql = format!(
            "SELECT {ALARM_COLUMNS}, number, i.run, onset_ns, gain, size_m, peak_ns, detectors,
                 evidence, advice, course, i.begin_ns
             FROM incidents i JOIN events e ON e.id = i.id WHERE i.id = ?"
        );
        let found = |row: &Row<'_>| {
            Ok((incident_page(row, now)?, row.get::<_, i64>(31)?, row.get::<_, i64>(22)?))
        };
        let Some((mut page, begin, run)) = self.0.query_row(&sql, [id], found).optional()? else {
            return Ok(None);
        };
        page.revisions = self.list(
            &format!(
                "SELECT at_ns, progress, level, suspect, fault, text FROM revisions
                 WHERE incident = ? ORDER BY id LIMIT {ROWS}"
            ),
            [id],
            super::entries::revision,
        )?;
        page.acts = self.list(
            &format!(
                "SELECT at_ns, kind, who, note, until_ns FROM acts WHERE incident = ?
                 ORDER BY event LIMIT {ROWS}"
            ),
            [id],
            super::entries::act_entry,
        )?;
        let end = self.0.query_row("SELECT end_ns FROM incidents WHERE id = ?", [id], |row| {
            row.get::<_, Option<i64>>(0)
        })?;
        page.warnings = self.list(
            &format!(
                "SELECT at_ns, detector, state, fault, suspect, level, residual_m, threshold_m,
                     evidence_nats, device, rule FROM warnings
                 WHERE run = ? AND ? IN (0, cylinder) AND at_ns BETWEEN ? AND ?
                 ORDER BY at_ns, id LIMIT {ROWS}"
            ),
            params![run, page.alarm.cylinder.unwrap_or(MACHINE), begin, end.unwrap_or(i64::MAX)],
            warning_entry,
        )?;
        Ok(Some(page))
    }

    /// The newest readings on the stop of a cylinder, the newest first.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn stops(&self, cylinder: u8) -> Result<Vec<StopEntry>, Trouble> {
        let sql = format!(
            "SELECT at_ns, c1_m, c2_m FROM stops WHERE cylinder = ? ORDER BY id DESC LIMIT {ROWS}"
        );
        self.list(&sql, [cylinder], stop_entry)
    }

    /// Statistics of the residuals of a cylinder for the hours from `from` to before `to`, a month at most.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn hours(
        &self,
        cylinder: u8,
        from: Timestamp,
        to: Timestamp,
    ) -> Result<Vec<HourEntry>, Trouble> {
        let hour = |at: Timestamp| at.as_nanos().div_euclid(1_000_000_000);
        let sql = format!(
            "SELECT hour_s, quantity, count, judged_s, mean_m, squares_m2, least_m, most_m FROM hours
             WHERE hour_s >= ? AND hour_s < ? AND cylinder = ? ORDER BY hour_s, quantity LIMIT {HOURS}"
        );
        self.list(&sql, params![hour(from), hour(to), cylinder], hour_entry)
    }

    fn list<T>(
        &self,
        sql: &str,
        values: impl rusqlite::Params,
        row: impl FnMut(&Row<'_>) -> rusqlite::Result<T>,
    ) -> Result<Vec<T>, Trouble> {
        let mut query = self.0.prepare(sql)?;
        let rows = query.query_map(values, row)?;
        Ok(rows.collect::<rusqlite::Result<Vec<T>>>()?)
    }
}
