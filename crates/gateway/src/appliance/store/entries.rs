//! Rows of the store as people and scripts read them. Times are seconds since 1970, lengths metres.

use super::columns::{self, level, some_text, text};
use rusqlite::Row;
use rusqlite::types::ValueRef;
use serde::Serialize;
use tertius_core::time::Timestamp;

/// A listed alarm.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AlarmEntry {
    /// Incident in the store.
    pub incident: i64,
    /// Cylinder number, counted from 1; `None` for what is the machine's.
    pub cylinder: Option<u8>,
    pub begin_s: f64,
    pub end_s: Option<f64>,
    /// How it ended: `returned`, `quiet`, `cut`, `joined` or `interrupted`; `None` while it is open.
    pub ending: Option<String>,
    /// Name of its [`AlarmState`](crate::alarm_list::AlarmState).
    pub state: &'static str,
    pub level: &'static str,
    pub suspect: String,
    pub fault: String,
    /// The incident in a line.
    pub text: String,
    pub acknowledged_by: Option<String>,
    pub acknowledged_note: Option<String>,
    pub shelved_by: Option<String>,
    pub shelved_reason: Option<String>,
    /// Time until which it is shelved; also after it.
    pub shelved_until_s: Option<f64>,
    /// When the suspect was named, and whether by the end of the fault; `None` while it is undecided.
    pub named_s: Option<f64>,
    pub named_by_its_end: Option<bool>,
    /// Quantity that was largest against its limit, as in [`IncidentFields`], with its peak and limit, m.
    pub quantity: Option<String>,
    pub peak_m: Option<f64>,
    pub limit_m: Option<f64>,
    /// Its absolute value in the newest cycle, m: not of the store, but of the gateway that follows it.
    pub now_m: Option<f64>,
}

/// Columns of an [`AlarmEntry`], 21 of them, four of which are for its state.
pub(super) const ALARM_COLUMNS: &str = "i.id, i.cylinder, i.begin_ns, i.end_ns, i.ending, i.suspect, \
    i.fault, e.text, i.acknowledged_by, i.acknowledged_note, i.shelved_by, i.shelved_reason, \
    i.condition, i.acknowledged, i.shelved_until_ns, i.level, i.named_ns, i.named_by_its_end, \
    i.quantity, i.peak_m, i.limit_m";

/// An incident or event, as a search finds it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EventEntry {
    /// Number in the store; an incident has the number of its event.
    pub id: i64,
    /// Exact time, s since 1970.
    #[serde(serialize_with = "digits")]
    pub at_s: Timestamp,
    /// Name of its [`EventKind`](super::EventKind).
    pub kind: String,
    pub cylinder: Option<u8>,
    pub level: Option<&'static str>,
    pub suspect: Option<String>,
    /// Incident that an act is about.
    pub about: Option<i64>,
    pub text: String,
    /// What only an incident has.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub incident: Option<IncidentFields>,
}

/// What only an incident has.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IncidentFields {
    pub fault: String,
    pub end_s: Option<f64>,
    pub ending: Option<String>,
    /// Name of its [`AlarmState`](crate::alarm_list::AlarmState).
    pub state: &'static str,
    /// Size of a step or of a difference, m, signed.
    pub size_m: Option<f64>,
    /// Quantity that was largest against its limit: `r1`, `r2`, `r3` or `c1_c2`, with its peak and limit.
    pub quantity: Option<String>,
    pub peak_m: Option<f64>,
    pub limit_m: Option<f64>,
}

/// Columns of an [`EventEntry`].
pub(super) const ENTRY_COLUMNS: &str = "e.id, e.at_ns, e.kind, e.cylinder, e.level, e.suspect, \
    e.incident, e.text, i.fault, i.end_ns, i.ending, i.size_m, i.quantity, i.peak_m, i.limit_m, \
    i.condition, i.acknowledged, i.shelved_until_ns, i.level";

/// All that is known of an incident.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IncidentPage {
    #[serde(flatten)]
    pub alarm: AlarmEntry,
    /// Number that the monitor gave it; it counts anew in each run.
    pub number: u32,
    pub run: i64,
    pub onset_s: f64,
    /// Gain error, m per m.
    pub gain: Option<f64>,
    pub size_m: Option<f64>,
    pub peak_s: Option<f64>,
    /// Names of the detectors that rose, separated by spaces.
    pub detectors: String,
    pub evidence: String,
    pub advice: String,
    /// How it went on or ended, in words.
    pub course: String,
    pub revisions: Vec<Revision>,
    /// Warnings of its cylinder while it lasted.
    pub warnings: Vec<WarningEntry>,
    pub acts: Vec<ActEntry>,
}

/// What became of an incident, once.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Revision {
    pub at_s: f64,
    /// `opened`, `revised`, `standing`, `closed` or `interrupted`
    pub progress: String,
    pub level: &'static str,
    pub suspect: String,
    pub fault: String,
    pub text: String,
}

/// A warning that was raised, changed or cleared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WarningEntry {
    pub at_s: f64,
    pub detector: String,
    pub state: String,
    pub fault: String,
    pub suspect: String,
    pub level: &'static str,
    pub residual_m: Option<f64>,
    pub threshold_m: Option<f64>,
    pub evidence_nats: Option<f64>,
    /// What its device said.
    pub device: Option<String>,
    /// The rule that named the suspect.
    pub by: Option<String>,
}

/// An act of a person.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ActEntry {
    pub at_s: f64,
    /// `acknowledge`, `shelve` or `unshelve`
    pub kind: String,
    pub who: String,
    pub note: String,
    pub until_s: Option<f64>,
}

/// A reading of a rod on its stop.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StopEntry {
    pub at_s: f64,
    pub c1_m: f64,
    /// `null` where the cylinder has no C2.
    pub c2_m: Option<f64>,
}

/// A residual in an hour.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HourEntry {
    /// Begin of the hour, s since 1970.
    pub hour_s: i64,
    /// `r1`, `r2` or `r3`
    pub quantity: String,
    /// Number of cycles in which it was judged.
    pub count: i64,
    pub judged_s: f64,
    /// The rest of the hour: nothing is known of it.
    pub unknown_s: f64,
    pub mean_m: f64,
    /// Standard deviation; `None` for a single value.
    pub sigma_m: Option<f64>,
    pub least_m: f64,
    pub most_m: f64,
}

pub(super) fn seconds(nanos: i64) -> f64 {
    Timestamp::from_nanos(nanos).as_seconds()
}

pub(super) fn digits<S: serde::Serializer>(at: &Timestamp, to: S) -> Result<S::Ok, S::Error> {
    let digits = serde_json::value::RawValue::from_string(at.to_string());
    digits.map_err(serde::ser::Error::custom)?.serialize(to)
}

fn time(row: &Row<'_>, at: usize) -> rusqlite::Result<f64> {
    row.get(at).map(seconds)
}

fn some_time(row: &Row<'_>, at: usize) -> rusqlite::Result<Option<f64>> {
    Ok(row.get::<_, Option<i64>>(at)?.map(seconds))
}

fn level_name(row: &Row<'_>, at: usize) -> rusqlite::Result<&'static str> {
    Ok(level(row.get(at)?).name())
}

/// Whether a text of a row has bytes that are no UTF-8.
pub(super) fn is_damaged(row: &Row<'_>) -> bool {
    let count = row.as_ref().column_count();
    let is_bad = |at| match row.get_ref(at) {
        Ok(ValueRef::Text(bytes)) => std::str::from_utf8(bytes).is_err(),
        _ => false,
    };
    (0..count).any(is_bad)
}

pub(super) fn alarm_entry(
    row: &Row<'_>,
    now: Timestamp,
    gated: bool,
) -> rusqlite::Result<AlarmEntry> {
    let alarm = columns::alarm(row, 12)?;
    Ok(AlarmEntry {
        incident: row.get(0)?,
        cylinder: columns::cylinder(row, 1)?,
        begin_s: time(row, 2)?,
        end_s: some_time(row, 3)?,
        ending: some_text(row, 4)?,
        state: alarm.state(now, gated).name(),
        level: alarm.level.name(),
        suspect: text(row, 5)?,
        fault: text(row, 6)?,
        text: text(row, 7)?,
        acknowledged_by: some_text(row, 8)?,
        acknowledged_note: some_text(row, 9)?,
        shelved_by: some_text(row, 10)?,
        shelved_reason: some_text(row, 11)?,
        shelved_until_s: some_time(row, 14)?,
        named_s: some_time(row, 16)?,
        named_by_its_end: row.get(17)?,
        quantity: some_text(row, 18)?,
        peak_m: row.get(19)?,
        limit_m: row.get(20)?,
        now_m: None,
    })
}

pub(super) fn entry(row: &Row<'_>, now: Timestamp) -> rusqlite::Result<EventEntry> {
    let fault = some_text(row, 8)?;
    let fields = |fault| -> rusqlite::Result<IncidentFields> {
        Ok(IncidentFields {
            fault,
            end_s: some_time(row, 9)?,
            ending: some_text(row, 10)?,
            state: columns::alarm(row, 15)?.state(now, false).name(),
            size_m: row.get(11)?,
            quantity: some_text(row, 12)?,
            peak_m: row.get(13)?,
            limit_m: row.get(14)?,
        })
    };
    Ok(EventEntry {
        id: row.get(0)?,
        at_s: Timestamp::from_nanos(row.get(1)?),
        kind: text(row, 2)?,
        cylinder: row.get(3)?,
        level: row.get::<_, Option<u8>>(4)?.map(|number| level(number).name()),
        suspect: some_text(row, 5)?,
        about: row.get(6)?,
        text: text(row, 7)?,
        incident: fault.map(fields).transpose()?,
    })
}

/// An incident without its lists.
pub(super) fn incident_page(row: &Row<'_>, now: Timestamp) -> rusqlite::Result<IncidentPage> {
    Ok(IncidentPage {
        alarm: alarm_entry(row, now, false)?,
        number: row.get(21)?,
        run: row.get(22)?,
        onset_s: time(row, 23)?,
        gain: row.get(24)?,
        size_m: row.get(25)?,
        peak_s: some_time(row, 26)?,
        detectors: text(row, 27)?,
        evidence: text(row, 28)?,
        advice: text(row, 29)?,
        course: text(row, 30)?,
        revisions: Vec::new(),
        warnings: Vec::new(),
        acts: Vec::new(),
    })
}

pub(super) fn revision(row: &Row<'_>) -> rusqlite::Result<Revision> {
    Ok(Revision {
        at_s: time(row, 0)?,
        progress: text(row, 1)?,
        level: level_name(row, 2)?,
        suspect: text(row, 3)?,
        fault: text(row, 4)?,
        text: text(row, 5)?,
    })
}

pub(super) fn warning_entry(row: &Row<'_>) -> rusqlite::Result<WarningEntry> {
    Ok(WarningEntry {
        at_s: time(row, 0)?,
        detector: text(row, 1)?,
        state: text(row, 2)?,
        fault: text(row, 3)?,
        suspect: text(row, 4)?,
        level: level_name(row, 5)?,
        residual_m: row.get(6)?,
        threshold_m: row.get(7)?,
        evidence_nats: row.get(8)?,
        device: some_text(row, 9)?,
        by: some_text(row, 10)?,
    })
}

pub(super) fn act_entry(row: &Row<'_>) -> rusqlite::Result<ActEntry> {
    Ok(ActEntry {
        at_s: time(row, 0)?,
        kind: text(row, 1)?,
        who: text(row, 2)?,
        note: text(row, 3)?,
        until_s: some_time(row, 4)?,
    })
}

pub(super) fn stop_entry(row: &Row<'_>) -> rusqlite::Result<StopEntry> {
    Ok(StopEntry { at_s: time(row, 0)?, c1_m: row.get(1)?, c2_m: row.get(2)? })
}

pub(super) fn hour_entry(row: &Row<'_>) -> rusqlite::Result<HourEntry> {
    let (count, judged, squares): (i64, f64, f64) = (row.get(2)?, row.get(3)?, row.get(5)?);
    Ok(HourEntry {
        hour_s: row.get(0)?,
        quantity: text(row, 1)?,
        count,
        judged_s: judged,
        unknown_s: (3600.0 - judged).max(0.0),
        mean_m: row.get(4)?,
        sigma_m: (count > 1).then(|| (squares / (count - 1) as f64).sqrt()),
        least_m: row.get(6)?,
        most_m: row.get(7)?,
    })
}
