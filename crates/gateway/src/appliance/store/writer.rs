//! The thread that writes: it gathers notes, and writes them twice a second at most.

use super::act::{ActError, ActRequest};
use super::backlog::Backlog;
use super::event_rows::Rows;
use super::note::Note;
use super::plan::Plan;
use super::retention::{self, Aging, Left, Limits};
use super::shared::{Shared, StoreState};
use super::trouble::Trouble;
use super::vault::Vault;
use crate::appliance::realtime;
use crate::appliance::telemetry::Telemetry;
use crate::appliance::telemetry::clock::{Clock, SystemClock};
use rusqlite::{Connection, TransactionBehavior};
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};
use tertius_config::MachineNames;
use tertius_core::text::counted;
use tracing::{info, warn};

/// Longest time from a note to the disk: what stood for a second outlives a kill.
const GATHER: Duration = Duration::from_millis(400);

/// Notes that are written without gathering more.
const BATCH: usize = 256;

/// Wait after an attempt that failed: while another process has locked the database, and otherwise.
const AGAIN: [Duration; 2] = [Duration::from_millis(400), Duration::from_secs(5)];

/// Longest time for which the end is tried to be written.
const LAST: Duration = Duration::from_secs(1);

/// Interval at which limits are looked at.
const TIDY: Duration = Duration::from_secs(60);

/// Writes what `notes` bring until the program stops.
pub(super) fn work(notes: &Receiver<Note>, shared: &Shared, telemetry: &Telemetry) {
    realtime::be_ordinary();
    let mut writer = Writer::new(shared, telemetry);
    loop {
        let ends = match notes.recv_timeout(writer.patience()) {
            Ok(note) => {
                let mut ends = writer.take(note);
                // All that is there, so that the way to here stays free; but not for ever.
                for note in notes.try_iter().take(4 * BATCH) {
                    ends |= writer.take(note);
                }
                ends
            }
            Err(RecvTimeoutError::Timeout) => false,
            Err(RecvTimeoutError::Disconnected) => true,
        };
        if ends {
            return writer.finish();
        }
        writer.turn();
    }
}

pub(super) struct Writer<'a> {
    shared: &'a Shared,
    telemetry: &'a Telemetry,
    clock: SystemClock,
    /// What is kept, and where; `None`: nothing.
    plan: Option<Plan>,
    vault: Option<Vault>,
    run: i64,
    /// How cylinders and transducers are called in that run.
    names: MachineNames,
    backlog: Backlog,
    /// When the oldest note came that waits.
    since: Option<Instant>,
    /// Before this nothing is tried.
    not_before: Option<Instant>,
    tidy_at: Instant,
    aging: Aging,
    /// What was last told of what hinders.
    told: Option<String>,
}

impl<'a> Writer<'a> {
    pub fn new(shared: &'a Shared, telemetry: &'a Telemetry) -> Self {
        Self {
            shared,
            telemetry,
            clock: SystemClock::new(),
            plan: None,
            vault: None,
            run: 0,
            names: MachineNames::default(),
            backlog: Backlog::default(),
            since: None,
            not_before: None,
            tidy_at: Instant::now(),
            aging: Aging::default(),
            told: None,
        }
    }

    /// Time until there is something to do.
    fn patience(&self) -> Duration {
        let due = self.since.map(|since| since + GATHER);
        let due = due.map(|due| self.not_before.map_or(due, |time| due.max(time)));
        let tidy = self.not_before.map_or(self.tidy_at, |time| self.tidy_at.max(time));
        let next = due.unwrap_or(tidy).min(tidy);
        next.saturating_duration_since(Instant::now()).max(Duration::from_millis(1))
    }

    /// Takes a note, and returns whether it is the last.
    pub fn take(&mut self, note: Note) -> bool {
        let ends = matches!(note, Note::End(_));
        if let Note::Begin(plan) = &note {
            self.begin(plan.as_deref().cloned());
        }
        self.since.get_or_insert_with(Instant::now);
        if self.plan.is_some() {
            self.backlog.push(note);
        } else if let Note::Act(request) = note {
            self.answer(request, Err(ActError::Unavailable("nothing is kept".to_owned())));
        }
        ends
    }

    fn begin(&mut self, plan: Option<Plan>) {
        let path = |plan: &Plan| plan.store.path.clone();
        if self.plan.as_ref().map(path) != plan.as_ref().map(path) {
            self.write();
            self.vault = None;
            for note in self.backlog.clear() {
                self.refuse(note, "another file is kept now");
            }
            self.told = None;
        } else if let Some(vault) = &mut self.vault
            && let Some(plan) = &plan
        {
            vault.limit(plan.store.size);
        }
        self.not_before = None;
        let path = plan.as_ref().map(path);
        self.plan = plan;
        self.shared.set(StoreState { path, trouble: None });
    }

    /// Does what is due.
    fn turn(&mut self) {
        let now = Instant::now();
        if self.not_before.is_some_and(|time| now < time) {
            return;
        }
        let due = self.since.is_some_and(|since| now.duration_since(since) >= GATHER);
        if due || self.backlog.len() >= BATCH {
            self.write();
        }
        if now >= self.tidy_at {
            self.tidy();
        }
    }

    pub fn tidy(&mut self) {
        let now = self.clock.system();
        self.tidy_at = Instant::now() + TIDY;
        let (Some(vault), Some(plan)) = (&mut self.vault, &self.plan) else { return };
        match retention::step(&mut vault.database, limits(plan), &mut self.aging, now) {
            Ok(Left::More) => self.tidy_at = Instant::now() + GATHER,
            Ok(Left::Nothing) => {}
            Err(trouble) => self.fail(&trouble),
        }
        self.measure();
    }

    fn measure(&self) {
        let size = self.vault.as_ref().and_then(|vault| retention::size(&vault.database).ok());
        self.telemetry.store_size(size);
    }

    /// Writes what is left, if that does not take long.
    fn finish(&mut self) {
        let started = Instant::now();
        loop {
            self.write();
            if self.since.is_none() {
                return;
            }
            if started.elapsed() > LAST {
                return self.give_up();
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Says what is lost, because the program ends before it could be written.
    pub fn give_up(&self) {
        let Some(plan) = &self.plan else { return };
        let lost = self.backlog.waiting() + self.backlog.lost();
        if lost > 0 {
            warn!(
                "{} {} lost: the gateway stops, and the event store {} could not be written ({})",
                counted(lost, "note"),
                if lost == 1 { "is" } else { "are" },
                plan.store.path.display(),
                self.told.as_deref().unwrap_or("it took too long")
            );
        }
    }

    /// Writes all that waits, in one transaction.
    pub fn write(&mut self) {
        self.since = None;
        self.backlog.lose(self.shared.dropped.swap(0, Ordering::Relaxed));
        if self.plan.is_none() || self.backlog.is_empty() {
            return;
        }
        match self.attempt() {
            Ok(written) => self.succeed(written),
            Err(trouble) => {
                self.fail(&trouble);
                self.since = Some(Instant::now());
            }
        }
    }

    fn attempt(&mut self) -> Result<Written, Trouble> {
        let nothing = Written { run: self.run, names: self.names.clone(), answers: Vec::new() };
        let Some(plan) = &self.plan else { return Ok(nothing) };
        if self.vault.is_none() {
            let vault = Vault::open(&plan.store)?;
            if !vault.knows(self.run)? {
                self.run = 0;
            }
            self.vault = Some(vault);
            if self.run == 0 && !self.backlog.begins() {
                self.backlog.begin_first(plan.clone());
            }
        }
        let Some(vault) = &mut self.vault else { return Ok(nothing) };
        let now = self.clock.system();
        write_all(&mut vault.database, &self.backlog, (self.run, self.names.clone()), now)
    }

    fn succeed(&mut self, written: Written) {
        let Written { run, names, answers } = written;
        (self.run, self.names) = (run, names);
        self.telemetry.store_written(self.backlog.len() as u64, self.backlog.lost());
        let mut answers = answers.into_iter();
        for note in self.backlog.clear() {
            if let Note::Act(request) = note {
                let answer = answers.next().unwrap_or(Err(ActError::Busy));
                self.answer(request, answer);
            }
        }
        if self.told.take().is_some() {
            info!("the event store is written again");
        }
        self.not_before = None;
        self.report(None);
        self.measure();
        if let (Some(vault), Some(plan)) = (&self.vault, &self.plan)
            && retention::is_due(&vault.database, limits(plan)).unwrap_or(false)
        {
            self.tidy_at = Instant::now();
        }
    }

    /// Notes what hinders, tells it once, and does what helps.
    fn fail(&mut self, trouble: &Trouble) {
        self.telemetry.store_failed();
        let told = trouble.to_string();
        for note in self.backlog.take_acts() {
            self.refuse(note, &told);
        }
        let locked = matches!(trouble, Trouble::Locked);
        self.not_before = Some(Instant::now() + AGAIN[usize::from(!locked)]);
        match (trouble, &mut self.vault, &self.plan) {
            (Trouble::Full, Some(vault), Some(plan)) => {
                let made = retention::make_room(&mut vault.database, limits(plan));
                if matches!(made, Ok(true)) {
                    self.not_before = Some(Instant::now() + AGAIN[0]);
                }
            }
            (Trouble::Corrupt(_), _, Some(plan)) => {
                let path = plan.store.path.clone();
                self.vault = None;
                match Vault::set_aside(&path) {
                    Ok(aside) => {
                        let aside = aside.display();
                        warn!(
                            "{}: {told}. It was set aside as {aside}; the event store restarts",
                            path.display()
                        );
                        (self.run, self.not_before) = (0, None);
                        return;
                    }
                    Err(error) => self.warn(&format!("{told}; it cannot be set aside: {error}")),
                }
            }
            // The file may be another one by now.
            (Trouble::Other(_), ..) => self.vault = None,
            _ => {}
        }
        self.warn(&told);
    }

    fn warn(&mut self, told: &str) {
        let Some(plan) = &self.plan else { return };
        if self.told.as_deref() != Some(told) {
            warn!(
                "the event store {} is not written: {told}. Detection goes on; what happens is kept \
                 in memory, as far as there is room, and tried again",
                plan.store.path.display()
            );
            self.told = Some(told.to_owned());
        }
        self.report(Some(told.to_owned()));
    }

    fn report(&self, trouble: Option<String>) {
        let path = self.plan.as_ref().map(|plan| plan.store.path.clone());
        self.shared.set(StoreState { path, trouble });
    }

    fn refuse(&self, note: Note, why: &str) {
        if let Note::Act(request) = note {
            self.answer(request, Err(ActError::Unavailable(why.to_owned())));
        }
    }

    fn answer(&self, request: ActRequest, answer: Result<(), ActError>) {
        self.shared.acts.fetch_sub(1, Ordering::AcqRel);
        // Who asked may have gone.
        _ = request.answer.send(answer);
    }
}

fn limits(plan: &Plan) -> Limits {
    Limits { size: plan.store.size, days: plan.store.days }
}

/// What has been written.
struct Written {
    run: i64,
    names: MachineNames,
    /// Answers to the acts, in their order.
    answers: Vec<Result<(), ActError>>,
}

/// Writes all notes or none.
fn write_all(
    database: &mut Connection,
    backlog: &Backlog,
    (run, names): (i64, MachineNames),
    now: tertius_core::time::Timestamp,
) -> Result<Written, Trouble> {
    let step = database.transaction_with_behavior(TransactionBehavior::Immediate)?;
    let mut rows = Rows { step: &step, run, names };
    let mut answers = Vec::new();
    for note in backlog.notes() {
        answers.extend(rows.write(note)?);
    }
    if backlog.lost() > 0 {
        rows.lost(backlog.lost(), now)?;
    }
    rows.seen(now)?;
    let Rows { run, names, .. } = rows;
    step.commit()?;
    Ok(Written { run, names, answers })
}
