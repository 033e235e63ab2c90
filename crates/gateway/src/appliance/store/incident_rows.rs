//! Incidents as rows: the present one, its revisions and its alarm.

use super::act::{ActError, AlarmAct};
use super::columns::{ALARM, MACHINE, alarm, cylinder, text};
use super::event_rows::{Facets, Rows};
use super::note::EventKind;
use crate::alarm_list::{ActKind, Alarm, AlarmCondition, Happening, Standing};
use rusqlite::{OptionalExtension, Row, Transaction, params};
use tertius_core::incident::{Incident, Progress};
use tertius_core::time::Timestamp;
use tertius_report::story;

/// What the column `cylinder` of an incident has.
fn column(incident: &Incident) -> u8 {
    incident.scope.cylinder().unwrap_or(MACHINE)
}

/// Writes what became of an incident: its event, its present state and a revision.
pub(super) fn revise(rows: &Rows<'_>, incident: &Incident) -> rusqlite::Result<()> {
    let text = story::line(incident, &rows.names);
    let facets = Facets {
        cylinder: incident.scope.cylinder(),
        cylinders: incident.scope.cylinders(),
        level: Some(incident.level as u8),
        suspect: Some(incident.suspect.name()),
        incident: None,
    };
    let (id, alarm) = match known(rows, incident)? {
        Some((id, alarm)) => {
            rows.step.execute(
                "UPDATE events SET level = ?, suspect = ?, text = ? WHERE id = ?",
                params![facets.level, facets.suspect, text, id],
            )?;
            rows.index(id, EventKind::Incident, facets, &text)?;
            (id, alarm)
        }
        None => {
            let id = rows.put((EventKind::Incident, incident.begin), facets, &text)?;
            (id, Alarm::opened(incident.level))
        }
    };
    let alarm = follow(alarm, incident);
    put(rows, id, incident)?;
    put_alarm(rows.step, id, &alarm)?;
    let progress = incident.progress.name();
    let told = story::evidence(incident);
    let level = incident.level as u8;
    let of = [incident.suspect.name(), incident.fault.name()];
    put_revision(rows, (id, incident.timestamp, progress), (level, of), &format!("{text}; {told}"))
}

/// The alarm of an incident after this news of it.
fn follow(alarm: Alarm, incident: &Incident) -> Alarm {
    let goes_on = incident.progress != Progress::Closed;
    let alarm = match alarm.standing.condition {
        // The program goes on with what another one had left.
        AlarmCondition::Interrupted if goes_on => alarm.after(Happening::Worse),
        _ => alarm.at_level(incident.level),
    };
    if goes_on { alarm } else { alarm.after(Happening::Returned) }
}

/// The number of an incident that is in the store, and its alarm: by its number in this run, or as one that an
/// earlier run has left and a monitor with its state goes on with.
fn known(rows: &Rows<'_>, incident: &Incident) -> rusqlite::Result<Option<(i64, Alarm)>> {
    let found = |row: &Row<'_>| Ok((row.get(0)?, alarm(row, 1)?));
    let own = format!("SELECT id, {ALARM} FROM incidents WHERE run = ? AND number = ?");
    let own = rows.step.query_row(&own, params![rows.run, incident.number], found).optional()?;
    if own.is_some() || incident.progress == Progress::Opened {
        return Ok(own);
    }
    let left = format!(
        "SELECT id, {ALARM} FROM incidents WHERE number = ? AND cylinder = ? AND begin_ns = ?
             AND condition = 'interrupted' AND run < ? ORDER BY id DESC LIMIT 1"
    );
    let (number, cylinder) = (incident.number, column(incident));
    let by = params![number, cylinder, incident.begin.as_nanos(), rows.run];
    rows.step.query_row(&left, by, found).optional()
}

fn put(rows: &Rows<'_>, id: i64, incident: &Incident) -> rusqlite::Result<()> {
    let worst = incident.worst();
    let detectors: Vec<&str> =
        story::detectors(incident).into_iter().map(|detector| detector.name()).collect();
    rows.step.execute(
        "INSERT INTO incidents (id, run, number, cylinder, begin_ns, onset_ns, end_ns, ending,
             condition, acknowledged, active, listed, level, suspect, fault, gain, size_m,
             quantity, peak_m, peak_ns, limit_m, detectors, evidence, advice, course, named_ns,
             named_by_its_end)
         VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, 'active', 0, 1, 1, ?9, ?10, ?11, ?12, ?13, ?14,
             ?15, ?16, ?17, ?18, ?19, ?20, ?21, ?22, ?23)
         ON CONFLICT DO UPDATE SET run = ?2, onset_ns = ?6, end_ns = ?7, ending = ?8, level = ?9,
             suspect = ?10, fault = ?11, gain = ?12, size_m = ?13, quantity = ?14, peak_m = ?15,
             peak_ns = ?16, limit_m = ?17, detectors = ?18, evidence = ?19, advice = ?20, course = ?21,
             named_ns = ?22, named_by_its_end = ?23",
        params![
            id,
            rows.run,
            incident.number,
            column(incident),
            incident.begin.as_nanos(),
            incident.onset.as_nanos(),
            incident.end.map(|(at, _)| at.as_nanos()),
            incident.end.map(|(_, how)| how.name()),
            incident.level as u8,
            incident.suspect.name(),
            incident.fault.name(),
            incident.gain,
            incident.size,
            worst.map(|(quantity, _)| quantity.name()),
            worst.map(|(_, peak)| peak.value),
            worst.map(|(_, peak)| peak.at.as_nanos()),
            worst.map(|(quantity, _)| incident.limits[quantity as usize]),
            detectors.join(" "),
            story::evidence(incident),
            story::advice(incident, &rows.names),
            story::ending(incident),
            incident.named.map(|it| it.at.as_nanos()),
            incident.named.map(|it| it.by_its_end),
        ],
    )?;
    Ok(())
}

fn put_alarm(step: &Transaction<'_>, id: i64, alarm: &Alarm) -> rusqlite::Result<()> {
    let Standing { condition, acknowledged } = alarm.standing;
    step.execute(
        "UPDATE incidents SET condition = ?, acknowledged = ?, shelved_until_ns = ?, active = ?,
             listed = ? WHERE id = ?",
        params![
            condition.name(),
            acknowledged,
            alarm.shelved_until.map(Timestamp::as_nanos),
            condition == AlarmCondition::Active,
            !alarm.is_normal(),
            id
        ],
    )?;
    Ok(())
}

fn put_revision(
    rows: &Rows<'_>,
    (id, at, progress): (i64, Timestamp, &str),
    (level, [suspect, fault]): (u8, [&str; 2]),
    text: &str,
) -> rusqlite::Result<()> {
    rows.step.execute(
        "INSERT INTO revisions (incident, at_ns, progress, level, suspect, fault, text)
         VALUES (?, ?, ?, ?, ?, ?, ?)",
        params![id, at.as_nanos(), progress, level, suspect, fault, text],
    )?;
    Ok(())
}

/// Gives the incidents that are open to the run `run`, which goes on with them.
pub(super) fn carry_over(step: &Transaction<'_>, run: i64) -> rusqlite::Result<()> {
    step.execute("UPDATE incidents SET run = ? WHERE active = 1", [run])?;
    Ok(())
}

/// Marks at `at` the incidents that are open as interrupted: nothing shows that they are over.
pub(super) fn interrupt(rows: &Rows<'_>, at: Timestamp) -> rusqlite::Result<()> {
    const COURSE: &str = "the monitor ended while it was open; nothing shows that it is over";
    let sql = format!("SELECT id, suspect, fault, {ALARM} FROM incidents WHERE active = 1");
    let mut query = rows.step.prepare(&sql)?;
    let open = query.query_map([], |row| {
        Ok((row.get::<_, i64>(0)?, [text(row, 1)?, text(row, 2)?], alarm(row, 3)?))
    })?;
    for open in open.collect::<rusqlite::Result<Vec<_>>>()? {
        let (id, [suspect, fault], alarm) = open;
        put_alarm(rows.step, id, &alarm.after(Happening::Interrupted))?;
        rows.step.execute(
            "UPDATE incidents SET ending = 'interrupted', course = ? WHERE id = ?",
            params![COURSE, id],
        )?;
        let of = (alarm.level as u8, [suspect.as_str(), fault.as_str()]);
        put_revision(rows, (id, at, "interrupted"), of, COURSE)?;
    }
    Ok(())
}

/// Does what a person did, unless it means nothing.
pub(super) fn act(rows: &Rows<'_>, act: &AlarmAct) -> rusqlite::Result<Result<(), ActError>> {
    let sql = format!("SELECT cylinder, suspect, {ALARM} FROM incidents WHERE id = ?");
    let found = |row: &Row<'_>| Ok((cylinder(row, 0)?, text(row, 1)?, alarm(row, 2)?));
    let found = rows.step.query_row(&sql, [act.incident], found).optional()?;
    let Some((cylinder, _, before)) = found else { return Ok(Err(ActError::Unknown)) };
    let after = match before.act(act.kind, act.at) {
        Ok(after) => after,
        Err(refusal) => return Ok(Err(refusal.into())),
    };
    put_alarm(rows.step, act.incident, &after)?;
    let (id, who, note) = (act.incident, act.who(), act.note());
    let (text, until) = match act.kind {
        ActKind::Acknowledge => {
            rows.step.execute(
                "UPDATE incidents SET acknowledged_by = ?, acknowledged_ns = ?,
                     acknowledged_note = ? WHERE id = ?",
                params![who, act.at.as_nanos(), note, id],
            )?;
            (format!("{who} acknowledged incident {id}"), None)
        }
        ActKind::Shelve(until) => {
            rows.step.execute(
                "UPDATE incidents SET shelved_by = ?, shelved_reason = ? WHERE id = ?",
                params![who, note, id],
            )?;
            let time = story::span(until.since(act.at));
            (format!("{who} shelved incident {id} for {time}"), Some(until.as_nanos()))
        }
        ActKind::Unshelve => (format!("{who} unshelved incident {id}"), None),
    };
    let text = if note.is_empty() { text } else { format!("{text}: {note}") };
    let level = Some(before.level as u8);
    let facets = Facets { cylinder, level, incident: Some(id), ..Facets::default() };
    let event = rows.put((EventKind::Act, act.at), facets, &text)?;
    rows.step.execute(
        "INSERT INTO acts VALUES (?, ?, ?, ?, ?, ?, ?)",
        params![event, id, act.at.as_nanos(), act.kind.name(), who, note, until],
    )?;
    Ok(Ok(()))
}
