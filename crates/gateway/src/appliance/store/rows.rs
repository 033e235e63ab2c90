//! Notes as rows: everything that is written in a transaction.

use super::act::{ActError, AlarmAct};
use super::event_rows::{Facets, Rows};
use super::hours::{Part, RESIDUALS};
use super::incident_rows::{self, revise};
use super::note::{Event, EventKind, Note};
use super::plan::Plan;
use rusqlite::{OptionalExtension, params};
use tertius_config::MachineNames;
use tertius_core::alarm::Warning;
use tertius_core::incident::Incident;
use tertius_core::monitor::Notice;
use tertius_core::time::Timestamp;
use tertius_report::story;

impl Rows<'_> {
    /// Writes a note. An act is answered by its caller, once everything is on the disk.
    pub fn write(&mut self, note: &Note) -> rusqlite::Result<Option<Result<(), ActError>>> {
        match note {
            Note::Begin(Some(plan)) => self.begin(plan)?,
            Note::Begin(None) => {}
            Note::Incident(incident) => self.incident(incident)?,
            Note::Warning(warning) => self.warning(warning)?,
            Note::Dwell(cylinder, dwell) => {
                self.step.execute(
                    "INSERT INTO stops (at_ns, cylinder, c1_m, c2_m) VALUES (?, ?, ?, ?)",
                    params![dwell.at.as_nanos(), cylinder, dwell.readings.c1, dwell.readings.c2],
                )?;
            }
            Note::Notice(notice) => {
                if let Some(event) = event_of(notice, &self.names) {
                    self.event(&event)?;
                }
            }
            Note::Hour(part) => self.hour(part)?,
            Note::Event(event) => self.event(event)?,
            Note::Act(request) => return self.act(&request.act).map(Some),
            Note::End(at) => self.end(*at)?,
        }
        Ok(None)
    }

    fn event(&self, event: &Event) -> rusqlite::Result<()> {
        let facets = Facets { cylinder: event.cylinder, ..Facets::default() };
        self.put((event.kind, event.at), facets, &event.text).map(|_| ())
    }

    fn begin(&mut self, plan: &Plan) -> rusqlite::Result<()> {
        let last: Option<(i64, i64, Option<i64>)> = self
            .step
            .query_row("SELECT id, seen_ns, end_ns FROM runs ORDER BY id DESC LIMIT 1", [], |row| {
                Ok((row.get(0)?, row.get(1)?, row.get(2)?))
            })
            .optional()?;
        self.names.clone_from(&plan.store.names);
        let (at, version) = (plan.at.as_nanos(), env!("CARGO_PKG_VERSION"));
        let (machine, configuration) = (&plan.store.machine, &plan.store.configuration);
        self.step.execute(
            "INSERT INTO runs (begin_ns, seen_ns, cause, version, machine, configuration)
             VALUES (?1, ?1, ?2, ?3, ?4, ?5)",
            params![at, plan.cause.name(), version, machine, configuration],
        )?;
        let before = std::mem::replace(&mut self.run, self.step.last_insert_rowid());
        if plan.continues {
            incident_rows::carry_over(self.step, self.run)?;
        } else {
            incident_rows::interrupt(self, plan.at)?;
        }
        let mut text = format!("tertius {version}, {machine}, configuration {configuration}");
        let (kind, unseen) = match plan.cause {
            super::Cause::Start => (EventKind::Start, last.filter(|(_, _, end)| end.is_none())),
            super::Cause::Reload => (EventKind::Reload, None),
        };
        if let Some((run, seen, _)) = unseen.filter(|(run, ..)| *run != before) {
            let seen = Timestamp::from_nanos(seen);
            text += &format!("; run {run} ended without a word, last seen at {seen}");
        }
        self.put((kind, plan.at), Facets::default(), &text).map(|_| ())
    }

    fn end(&self, at: Timestamp) -> rusqlite::Result<()> {
        self.step.execute(
            "UPDATE runs SET end_ns = ?1, seen_ns = ?1 WHERE id = ?2",
            params![at.as_nanos(), self.run],
        )?;
        let facets = Facets::default();
        self.put((EventKind::Stop, at), facets, "the gateway was stopped").map(|_| ())
    }

    /// Notes that the run was alive at `at`.
    pub fn seen(&self, at: Timestamp) -> rusqlite::Result<()> {
        let sql = "UPDATE runs SET seen_ns = ? WHERE id = ?";
        self.step.execute(sql, params![at.as_nanos(), self.run])?;
        Ok(())
    }

    /// Notes that notes were lost.
    pub fn lost(&self, notes: u64, at: Timestamp) -> rusqlite::Result<()> {
        let text = format!("{notes} warnings or events were not stored: too many came at once");
        self.put((EventKind::Lost, at), Facets::default(), &text).map(|_| ())
    }

    fn incident(&self, incident: &Incident) -> rusqlite::Result<()> {
        revise(self, incident)
    }

    fn warning(&self, warning: &Warning) -> rusqlite::Result<()> {
        let finding = &warning.finding;
        self.step.execute(
            "INSERT INTO warnings (run, at_ns, cylinder, detector, state, fault, suspect, level,
                 residual_m, threshold_m, evidence_nats, device, rule)
             VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
            params![
                self.run,
                warning.timestamp.as_nanos(),
                warning.cylinder,
                warning.detector.name(),
                warning.state.name(),
                finding.fault.name(),
                finding.suspect.name(),
                finding.level as u8,
                finding.residual,
                finding.threshold,
                finding.evidence.map(|evidence| evidence.fault),
                finding.device.map(|device| device.to_string()),
                finding.rule.name(),
            ],
        )?;
        Ok(())
    }

    /// Adds a part of an hour to what is known of it (Chan's update), so that a restart within an hour, and one
    /// that the clock repeats, change no sum.
    fn hour(&self, part: &Part) -> rusqlite::Result<()> {
        for (name, moments) in RESIDUALS.iter().zip(part.moments) {
            if moments.count == 0 {
                continue;
            }
            let judged = f64::from(moments.count) * part.sample_time;
            self.step.execute(
                "INSERT INTO hours VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)
                 ON CONFLICT DO UPDATE SET
                     squares_m2 = squares_m2 + ?7
                         + (?6 - mean_m) * (?6 - mean_m) * count * ?4 / (count + ?4),
                     mean_m = mean_m + (?6 - mean_m) * ?4 / (count + ?4),
                     least_m = min(least_m, ?8), most_m = max(most_m, ?9),
                     count = count + ?4, judged_s = judged_s + ?5",
                params![
                    part.hour,
                    part.cylinder,
                    name,
                    moments.count,
                    judged,
                    moments.mean,
                    moments.squares,
                    moments.least,
                    moments.most
                ],
            )?;
        }
        Ok(())
    }

    fn act(&self, act: &AlarmAct) -> rusqlite::Result<Result<(), ActError>> {
        incident_rows::act(self, act)
    }
}

/// A notice as an event, if it is worth keeping for years.
fn event_of(notice: &Notice, names: &MachineNames) -> Option<Event> {
    let (kind, at, cylinder) = match *notice {
        Notice::TimeJump { at, .. } => (EventKind::Clock, at, None),
        Notice::Timing { at, .. } => (EventKind::Timing, at, None),
        Notice::Device { at, cylinder, .. } => (EventKind::Device, at, Some(cylinder)),
        Notice::UnnamedStatus { at, cylinder, .. } => (EventKind::Doubt, at, Some(cylinder)),
        Notice::Doubt { at, .. } => (EventKind::Doubt, at, None),
        Notice::Gap { .. }
        | Notice::Interruption { .. }
        | Notice::Silence { .. }
        | Notice::Restart { .. } => return None,
    };
    Some(Event { kind, at, cylinder, text: story::notice_words(notice, names) })
}
