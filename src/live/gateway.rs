//! The monitor between the frames that a port receives and those that it sends.

use super::health::BusHealth;
use super::outbox::Outbox;
use crate::alarm::{OwnFrame, Warning};
use crate::bus::{Port, PortError, Sent};
use crate::error_frame::ErrorFrame;
use crate::monitor::{Monitor, Notice, Record, Sink};
use crate::sequential::{Archive, Dwell};
use crate::time::{Span, Timestamp};
use std::time::Duration;
use thiserror::Error;

/// Receives the gateway's events, to log and count them. It must never wait.
pub trait Journal {
    /// Takes a cycle of one cylinder.
    fn record(&mut self, record: &Record) {
        _ = record;
    }

    fn warning(&mut self, warning: &Warning) {
        _ = warning;
    }

    /// Takes the reading of a rod on its stop.
    fn dwell(&mut self, cylinder: u8, dwell: &Dwell) {
        _ = (cylinder, dwell);
    }

    fn notice(&mut self, notice: &Notice) {
        _ = notice;
    }

    /// Takes a change of the controller's state.
    fn bus(&mut self, health: &BusHealth) {
        _ = health;
    }

    /// Notes that a frame was sent at `at`, on the clock of the time stamps.
    fn sent(&mut self, frame: &OwnFrame, at: Timestamp) {
        _ = (frame, at);
    }
}

/// A journal that ignores everything.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Journal for Silent {}

/// Results of one turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Turn {
    pub received: usize,
    pub sent: usize,
    /// Whether the interface accepts no more frames for now.
    pub full: bool,
}

/// Why the bus was not told that the gateway stops.
#[derive(Debug, Error)]
pub enum NotTold {
    #[error(transparent)]
    Port(#[from] PortError),
    #[error("the controller is bus-off")]
    BusOff,
    #[error("the interface accepts no frame: its queue is full, and nobody acknowledges")]
    Full,
}

/// Number of attempts to hand the stopping status to an interface that does not accept it.
const LAST_TRIES: u32 = 25;

/// The data path of the live gateway, which does to a port what [`crate::monitor`] does to a
/// recording. It waits only for frames, never for a disk, a log or a client.
#[derive(Clone, Debug)]
pub struct Gateway {
    monitor: Monitor,
    outbox: Outbox,
    health: BusHealth,
    /// Time by which deadlines are kept behind the clock, for frames on their way into the queue.
    guard: Span,
    now: Timestamp,
}

impl Gateway {
    pub fn new(monitor: Monitor, outbox: Outbox, guard: Span) -> Self {
        let health = BusHealth::default();
        Self { monitor, outbox, health, guard, now: Timestamp::default() }
    }

    pub const fn monitor(&self) -> &Monitor {
        &self.monitor
    }

    /// Restores the readings on the stops of an earlier gateway of the same machine.
    pub fn restore(&mut self, archive: &Archive) {
        self.monitor.restore(archive);
    }

    pub const fn outbox(&self) -> &Outbox {
        &self.outbox
    }

    /// State of the bus, as reported since the port was opened.
    pub const fn health(&self) -> &BusHealth {
        &self.health
    }

    /// Notes the loss of the port: waiting frames are dropped, since they would burst out stale
    /// when it returns, and nothing is known until it was judged again.
    pub fn lose(&mut self, journal: &mut impl Journal) {
        self.outbox.clear();
        self.health = BusHealth::default();
        let mut outlet = Outlet { outbox: &mut self.outbox, journal };
        self.monitor.interrupt(self.now, &mut outlet);
        self.outbox.clear();
    }

    /// Takes the frames that `port` has received, waiting at most `patience` for them, and sends
    /// the resulting ones.
    ///
    /// # Errors The port is down, gone or broken; call [`Self::lose`] then.
    pub fn turn(
        &mut self,
        port: &mut dyn Port,
        patience: Duration,
        journal: &mut impl Journal,
    ) -> Result<Turn, PortError> {
        let received = self.receive(port, patience, journal)?;
        let (sent, full) = self.send(port, journal)?;
        Ok(Turn { received, sent, full })
    }

    /// Tells the bus that the gateway stops, within the gateway's share of the bus. If the
    /// interface does not accept the frame there are some more attempts, each after at most
    /// `patience`.
    ///
    /// # Errors Why the interface did not accept the frame, so that the bus was not told.
    pub fn stop(
        &mut self,
        port: &mut dyn Port,
        patience: Duration,
        journal: &mut impl Journal,
    ) -> Result<(), NotTold> {
        let frame = self.monitor.stopping_status(self.now);
        self.outbox.close(frame);
        for _ in 0..LAST_TRIES {
            if self.health.is_off() {
                return Err(NotTold::BusOff);
            }
            self.send(port, journal)?;
            if self.outbox.waiting() == 0 {
                return Ok(());
            }
            let health = &mut self.health;
            port.receive(patience, &mut |frame| {
                _ = ErrorFrame::read(frame).map(|error| health.take(&error));
            })?;
        }
        Err(NotTold::Full)
    }

    fn receive(
        &mut self,
        port: &mut dyn Port,
        patience: Duration,
        journal: &mut impl Journal,
    ) -> Result<usize, PortError> {
        let Self { monitor, outbox, health, now, guard } = self;
        let mut outlet = Outlet { outbox, journal };
        let received = port.receive(patience, &mut |frame| {
            *now = frame.timestamp;
            let changed = match ErrorFrame::read(frame) {
                Some(error) => health.take(&error),
                None => health.spoke(),
            };
            if changed {
                outlet.journal.bus(health);
            }
            monitor.take(frame, &mut outlet);
        })?;
        if let Some(drained) = received.drained_at {
            *now = drained;
            let back = Span::from_nanos(guard.as_nanos().saturating_neg());
            monitor.advance(drained.after(back), &mut outlet);
        }
        Ok(received.frames)
    }

    fn send(
        &mut self,
        port: &mut dyn Port,
        journal: &mut impl Journal,
    ) -> Result<(usize, bool), PortError> {
        if self.health.is_off() {
            self.outbox.clear();
        }
        let mut sent = 0;
        while let Some(frame) = self.outbox.next(self.now) {
            match port.send(frame)? {
                Sent::Taken => journal.sent(frame, self.now),
                Sent::Full => return Ok((sent, true)),
            }
            self.outbox.sent();
            sent += 1;
        }
        Ok((sent, false))
    }
}

/// Passes the monitor's output to the outbox and the journal.
struct Outlet<'a, J> {
    outbox: &'a mut Outbox,
    journal: &'a mut J,
}

impl<J: Journal> Sink for Outlet<'_, J> {
    fn record(&mut self, record: &Record) {
        self.journal.record(record);
    }

    fn warning(&mut self, warning: &Warning) {
        self.journal.warning(warning);
    }

    fn dwell(&mut self, cylinder: u8, dwell: &Dwell) {
        self.journal.dwell(cylinder, dwell);
    }

    fn transmit(&mut self, frame: &OwnFrame) {
        self.outbox.put(frame.clone());
    }

    fn notice(&mut self, notice: &Notice) {
        self.journal.notice(notice);
    }
}
