//! The data path's side of the store. It never waits: what the writer has no room for is dropped and counted.

use super::hours::Hours;
use super::note::{Event, EventKind, Note};
use super::plan::{Cause, Plan, StorePlan};
use super::shared::{Shared, StoreHandle};
use super::writer;
use crate::appliance::telemetry::Telemetry;
use crate::appliance::telemetry::clock::{Clock, SystemClock};
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tertius_core::alarm::Warning;
use tertius_core::alarm::status::MAX_CYLINDERS;
use tertius_core::incident::Incident;
use tertius_core::monitor::{Notice, Record};
use tertius_core::sequential::Dwell;
use tertius_core::text::counted;
use tracing::warn;

/// Most notes on their way to the writer, which takes them within milliseconds, whatever the disk does; about 1 MB.
const ON_THEIR_WAY: usize = 512;

/// Most notes that wait for the end of a turn. Usually it is none.
const OF_A_TURN: usize = 128;

/// Longest wait for the writer at the end.
const LAST: Duration = Duration::from_millis(1500);

/// Takes what happens, and hands it to the writer after the frames of a turn have been sent.
#[derive(Debug)]
pub struct Clerk {
    /// Whether anything is kept.
    keeps: bool,
    turn: VecDeque<Note>,
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
        let turn = VecDeque::with_capacity(OF_A_TURN + MAX_CYLINDERS);
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
        self.keeps = plan.is_some();
        self.hours.begin(plan.as_ref().map_or(0.0, |plan| plan.sample_time));
        let at = self.clock.system();
        let plan = plan.map(|store| Box::new(Plan { store, cause, at, continues }));
        self.push(Note::Begin(plan));
        self.turned();
    }

    /// Takes a cycle of one cylinder.
    pub fn record(&mut self, record: &Record) {
        if self.keeps {
            let turn = &mut self.turn;
            self.hours.take(record, |part| turn.push_back(Note::Hour(part)));
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
        if self.keeps {
            self.push(note);
        }
    }

    /// Hands over the notes of a turn, after its frames were sent. Without any it does nothing. Those that the writer
    /// has no room for wait for the next turn.
    pub fn turned(&mut self) {
        while let Some(note) = self.turn.pop_front() {
            match self.notes.try_send(note) {
                Ok(()) => {}
                Err(TrySendError::Full(note)) => {
                    self.turn.push_front(note);
                    return;
                }
                Err(TrySendError::Disconnected(_)) => self.drop_one(),
            }
        }
    }

    fn drop_one(&self) {
        self.shared.dropped.fetch_add(1, Ordering::Relaxed);
    }

    /// Adds a note to those of this turn. Where there is no room, because the disk has stood still for long, a warning
    /// or an event gives way.
    fn push(&mut self, note: Note) {
        if self.turn.len() >= OF_A_TURN {
            self.turned();
        }
        if self.turn.len() >= OF_A_TURN {
            let light = self.turn.iter().position(Note::is_light);
            self.turn.remove(light.unwrap_or(0));
            self.drop_one();
        }
        self.turn.push_back(note);
    }

    fn finish_part(&mut self) {
        let turn = &mut self.turn;
        self.hours.finish(|part| turn.push_back(Note::Hour(part)));
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
        while let Err(TrySendError::Full(back)) = self.notes.try_send(end) {
            if started.elapsed() > LAST {
                return self.give_up();
            }
            end = back;
            std::thread::sleep(Duration::from_millis(10));
        }
        while !writer.is_finished() && started.elapsed() < LAST {
            std::thread::sleep(Duration::from_millis(2));
        }
        // A writer that ended in time has told what it could not write.
        if !writer.is_finished() || !self.turn.is_empty() {
            self.give_up();
        }
    }

    /// Says what is lost, because the program ends and the writer stands still.
    fn give_up(&self) {
        if self.keeps {
            warn!(
                "the gateway stops, and the event store was not written in time: {} not handed over, and what the \
                 writer had is lost unless it is written in this moment",
                counted(self.turn.len() as u64, "note")
            );
        }
    }
}

impl Drop for Clerk {
    fn drop(&mut self) {
        self.end();
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{incident, warning};
    use super::*;

    /// A clerk whose writer takes nothing, and what would come to it.
    fn stalled() -> (Clerk, std::sync::mpsc::Receiver<Note>) {
        let (notes, noted) = sync_channel(2);
        let clerk = Clerk {
            keeps: true,
            turn: VecDeque::new(),
            hours: Hours::new(),
            notes,
            shared: Arc::default(),
            writer: None,
            clock: SystemClock::new(),
        };
        (clerk, noted)
    }

    #[test]
    fn a_writer_that_stands_still_costs_warnings_and_no_incident() {
        let (mut clerk, noted) = stalled();
        for number in 1..=20 {
            clerk.incident(&incident(number));
            (0..50).for_each(|_| clerk.warning(&warning()));
            clerk.turned();
        }
        assert_eq!(clerk.turn.len(), OF_A_TURN, "bounded");
        let lost = clerk.shared.dropped.load(Ordering::Relaxed);
        assert_eq!(lost, 20 * 51 - OF_A_TURN as u64 - 2);
        let mut numbers = Vec::new();
        while !clerk.turn.is_empty() || numbers.len() < 20 {
            for note in noted.try_iter() {
                if let Note::Incident(incident) = note {
                    numbers.push(incident.number);
                }
            }
            clerk.turned();
        }
        assert_eq!(numbers, Vec::from_iter(1..=20), "each, in their order");
    }
}
