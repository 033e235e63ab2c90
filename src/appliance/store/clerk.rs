//! The data path's side of the store. It never waits: what the writer has no room for is dropped and counted.

use super::hours::Hours;
use super::note::{Event, EventKind, Note};
use super::plan::{Cause, Plan, StorePlan};
use super::shared::{Shared, StoreHandle};
use super::writer;
use crate::alarm::Warning;
use crate::appliance::telemetry::Telemetry;
use crate::appliance::telemetry::clock::{Clock, SystemClock};
use crate::incident::Incident;
use crate::monitor::{Notice, Record};
use crate::sequential::Dwell;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tracing::warn;

/// Most notes on their way to the writer, which takes them within milliseconds, whatever the disk does; about 1 MB.
const ON_THEIR_WAY: usize = 512;

/// Most notes of a turn. More of them are handed over at once.
const OF_A_TURN: usize = 64;

/// Longest wait for the writer at the end.
const LAST: Duration = Duration::from_millis(1500);

/// Takes what happens, and hands it to the writer after the frames of a turn have been sent.
#[derive(Debug)]
pub struct Clerk {
    /// Whether anything is kept.
    keeps: bool,
    turn: Vec<Note>,
    hours: Hours,
    notes: SyncSender<Note>,
    shared: Arc<Shared>,
    writer: Option<JoinHandle<()>>,
    clock: SystemClock,
}

impl Clerk {
    /// A clerk that keeps nothing yet. Its writer counts in `telemetry`.
    pub fn new(telemetry: &Arc<Telemetry>) -> Self {
        let (notes, noted) = sync_channel(ON_THEIR_WAY);
        let (shared, told) = (Arc::<Shared>::default(), Arc::clone(telemetry));
        let known = Arc::clone(&shared);
        let builder = std::thread::Builder::new().name("store".to_owned());
        let writer = builder.spawn(move || writer::work(&noted, &known, &told));
        let writer = writer.map_err(|error| warn!("no thread for the event store: {error}")).ok();
        let turn = Vec::with_capacity(OF_A_TURN);
        let (hours, clock) = (Hours::new(), SystemClock::new());
        Self { keeps: false, turn, hours, notes, shared, writer, clock }
    }

    /// Access for other threads.
    pub fn handle(&self) -> StoreHandle {
        StoreHandle { shared: Arc::clone(&self.shared), notes: self.notes.clone() }
    }

    /// Begins to keep what a monitor finds by `plan`; `None`: nothing is kept from now on. `continues`: the monitor goes
    /// on with the incidents of the one before.
    pub fn begin(&mut self, plan: Option<StorePlan>, cause: Cause, continues: bool) {
        self.finish_part();
        self.turned();
        self.keeps = plan.is_some();
        self.hours.begin(plan.as_ref().map_or(0.0, |plan| plan.sample_time));
        let at = self.clock.system();
        let plan = plan.map(|store| Box::new(Plan { store, cause, at, continues }));
        self.send(Note::Begin(plan));
    }

    /// Takes a cycle of one cylinder.
    pub fn record(&mut self, record: &Record) {
        if self.keeps {
            let turn = &mut self.turn;
            self.hours.take(record, |part| turn.push(Note::Hour(part)));
        }
    }

    pub fn incident(&mut self, incident: &Incident) {
        self.note(Note::Incident(*incident));
    }

    pub fn warning(&mut self, warning: &Warning) {
        self.note(Note::Warning(*warning));
    }

    pub fn dwell(&mut self, cylinder: u8, dwell: &Dwell) {
        self.note(Note::Dwell(cylinder, *dwell));
    }

    pub fn notice(&mut self, notice: &Notice) {
        self.note(Note::Notice(*notice));
    }

    /// Takes what happens now and then.
    pub fn event(&mut self, kind: EventKind, text: impl FnOnce() -> String) {
        if self.keeps {
            let (at, text) = (self.clock.system(), text());
            self.note(Note::Event(Box::new(Event { kind, at, cylinder: None, text })));
        }
    }

    fn note(&mut self, note: Note) {
        if !self.keeps {
            return;
        }
        if self.turn.len() >= OF_A_TURN {
            self.turned();
        }
        self.turn.push(note);
    }

    /// Hands over the notes of a turn, after its frames were sent. Without any it does nothing.
    pub fn turned(&mut self) {
        for note in self.turn.drain(..) {
            if self.notes.try_send(note).is_err() {
                self.shared.dropped.fetch_add(1, Ordering::Relaxed);
            }
        }
    }

    fn send(&self, note: Note) {
        if self.notes.try_send(note).is_err() {
            self.shared.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn finish_part(&mut self) {
        let turn = &mut self.turn;
        self.hours.finish(|part| turn.push(Note::Hour(part)));
    }

    /// Waits, not for long, until everything is written, after the gateway has stopped.
    pub fn finish(&mut self) {
        self.finish_part();
        self.turned();
        self.end();
    }

    fn end(&mut self) {
        let Some(writer) = self.writer.take() else { return };
        let started = Instant::now();
        let mut end = Note::End(self.clock.system());
        while let Err(std::sync::mpsc::TrySendError::Full(back)) = self.notes.try_send(end) {
            if started.elapsed() > LAST {
                return;
            }
            end = back;
            std::thread::sleep(Duration::from_millis(10));
        }
        while !writer.is_finished() && started.elapsed() < LAST {
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

impl Drop for Clerk {
    fn drop(&mut self) {
        self.end();
    }
}
