//! The monitor on a port that only listens, beside the gateway or without one.

use super::gateway::Journal;
use super::health::BusHealth;
use crate::bus::{ListeningPort, PortError};
use std::time::Duration;
use tertius_core::alarm::Warning;
use tertius_core::error_frame::ErrorFrame;
use tertius_core::estimate::Estimate;
use tertius_core::frame::BusNumber;
use tertius_core::incident::Incident;
use tertius_core::monitor::{Monitor, Notice, Record, Sink};
use tertius_core::sequential::{Archive, Dwell};
use tertius_core::time::{Span, Timestamp};

/// What [`Gateway`](super::gateway::Gateway) is without its frames: it judges as the gateway does, and cannot send.
#[derive(Debug)]
pub struct ListeningMonitor {
    monitor: Monitor,
    health: BusHealth,
    /// Time by which deadlines are kept behind the clock, for frames on their way into the queue.
    guard: Span,
    now: Timestamp,
}

impl ListeningMonitor {
    pub fn new(monitor: Monitor, guard: Span) -> Self {
        Self { monitor, health: BusHealth::default(), guard, now: Timestamp::default() }
    }

    pub const fn monitor(&self) -> &Monitor {
        &self.monitor
    }

    /// Restores what was read on the stops of the same machine.
    pub fn restore(&mut self, archive: &Archive) {
        self.monitor.restore(archive);
    }

    /// Notes the loss of the port: nothing is known until it was judged again.
    pub fn lose(&mut self, journal: &mut impl Journal) {
        self.health = BusHealth::default();
        self.monitor.interrupt(self.now, &mut Ear(journal));
    }

    /// Takes the frames that `port` has received, waiting at most `patience` for them, and returns their number.
    ///
    /// # Errors
    /// The port is down, gone or broken; call [`Self::lose`] then.
    pub fn turn(
        &mut self,
        port: &mut ListeningPort,
        patience: Duration,
        journal: &mut impl Journal,
    ) -> Result<usize, PortError> {
        let Self { monitor, health, guard, now } = self;
        let mut ear = Ear(journal);
        let received = port.receive(patience, &mut |frame| {
            *now = frame.timestamp;
            let changed = match ErrorFrame::read(frame) {
                _ if frame.bus != BusNumber::First => false,
                Some(error) => health.take(&error),
                None => health.spoke(),
            };
            if changed {
                ear.0.bus(health);
            }
            monitor.take(frame, &mut ear);
        })?;
        for bus in received.lost.iter() {
            monitor.interrupt_bus(bus, *now, &mut ear);
        }
        if let Some(drained) = received.drained_at {
            *now = drained;
            let back = Span::from_nanos(guard.as_nanos().saturating_neg());
            monitor.advance(drained.after(back), &mut ear);
        }
        Ok(received.frames)
    }
}

/// Passes what the monitor says to a journal. The frames that a gateway would send now are dropped.
struct Ear<'a, J>(&'a mut J);

impl<J: Journal> Sink for Ear<'_, J> {
    fn record(&mut self, record: &Record) {
        self.0.record(record);
    }

    fn warning(&mut self, warning: &Warning) {
        self.0.warning(warning);
    }

    fn incident(&mut self, incident: &Incident) {
        self.0.incident(incident);
    }

    fn estimate(&mut self, _: Timestamp, cylinder: u8, estimate: Option<&Estimate>) {
        self.0.estimate(cylinder, estimate);
    }

    fn dwell(&mut self, cylinder: u8, dwell: &Dwell) {
        self.0.dwell(cylinder, dwell);
    }

    fn notice(&mut self, notice: &Notice) {
        self.0.notice(notice);
    }
}
