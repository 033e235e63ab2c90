//! The monitor between the frames that a port receives and those that it sends.

use super::health::BusHealth;
use super::imitation::ImitationWatch;
use super::outbox::Outbox;
use crate::bus::{Port, PortError, Sent};
use std::time::Duration;
use tertius_canopen::node::{NmtEvent, Node, NodeView};
use tertius_core::alarm::{OwnFrame, Warning};
use tertius_core::error_frame::ErrorFrame;
use tertius_core::estimate::Estimate;
use tertius_core::frame::{BusNumber, Frame, Id};
use tertius_core::incident::Incident;
use tertius_core::monitor::{Monitor, Notice, Record, Sink};
use tertius_core::sequential::{Archive, Dwell};
use tertius_core::time::{Span, Timestamp};
use thiserror::Error;

/// Receives the gateway's events, to log and count them. It must never wait.
pub trait Journal {
    /// Takes each frame that was received, before the monitor does.
    #[inline]
    fn frame(&mut self, frame: &Frame) {
        _ = frame;
    }

    /// Takes a cycle of one cylinder.
    fn record(&mut self, record: &Record) {
        _ = record;
    }

    fn warning(&mut self, warning: &Warning) {
        _ = warning;
    }

    /// Takes an incident that was opened, revised or closed.
    fn incident(&mut self, incident: &Incident) {
        _ = incident;
    }

    /// Takes the estimated length of a cylinder, after the record of its cycle; see [`Sink::estimate`].
    fn estimate(&mut self, cylinder: u8, estimate: Option<&Estimate>) {
        _ = (cylinder, estimate);
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

    /// Takes an NMT command that the node has followed.
    fn nmt(&mut self, event: &NmtEvent) {
        _ = event;
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

/// Why the last status, that the gateway stops, was not sent.
#[derive(Debug, Error)]
pub enum NotSent {
    #[error(transparent)]
    Port(#[from] PortError),
    #[error("the controller is bus-off")]
    BusOff,
    #[error("the interface accepts no frame: its queue is full, and nobody acknowledges")]
    Full,
}

/// Number of attempts to hand the stopping status to an interface that does not accept it.
const LAST_TRIES: u32 = 25;

/// The data path of the live gateway, which does to a port what [`tertius_core::monitor`] does to a
/// recording. It waits only for frames, never for a disk, a log or a client.
#[derive(Debug)]
pub struct Gateway {
    monitor: Monitor,
    /// `None` if the gateway is no CANopen node.
    node: Option<Node>,
    imitation: ImitationWatch,
    outbox: Outbox,
    health: BusHealth,
    /// Time by which deadlines are kept behind the clock, for frames on their way into the queue.
    guard: Span,
    now: Timestamp,
}

impl Gateway {
    pub fn new(monitor: Monitor, outbox: Outbox, guard: Span) -> Self {
        let health = BusHealth::default();
        let imitation = ImitationWatch::default();
        Self { monitor, node: None, imitation, outbox, health, guard, now: Timestamp::default() }
    }

    /// This gateway, which watches for frames of other devices with its `own` identifiers.
    pub fn with_own_identifiers(self, own: Vec<Id>) -> Self {
        Self { imitation: ImitationWatch::new(own), ..self }
    }

    /// This gateway as a CANopen node.
    pub fn with_node(self, node: Node) -> Self {
        Self { node: Some(node), ..self }
    }

    pub const fn monitor(&self) -> &Monitor {
        &self.monitor
    }

    /// Restores the readings on the stops of an earlier gateway of the same machine.
    pub fn restore(&mut self, archive: &Archive) {
        self.monitor.restore(archive);
    }

    /// Time up to which it has got: that of the newest frame, or of the clock where no frame waits.
    pub const fn now(&self) -> Timestamp {
        self.now
    }

    pub const fn outbox(&self) -> &Outbox {
        &self.outbox
    }

    /// Number of frames of other devices with one of the gateway's own identifiers.
    pub const fn imitated(&self) -> u64 {
        self.imitation.count()
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
        let mut outlet = Outlet { outbox: &mut self.outbox, node: &mut self.node, journal };
        self.monitor.interrupt(self.now, &mut outlet);
        self.outbox.clear();
    }

    /// Takes the frames that `port` has received, waiting at most `patience` for them, and sends
    /// the resulting ones.
    ///
    /// # Errors
    /// The port is down, gone or broken; call [`Self::lose`] then.
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
    /// # Errors
    /// Why the interface did not accept the frame, so that the bus was not told.
    pub fn stop(
        &mut self,
        port: &mut dyn Port,
        patience: Duration,
        journal: &mut impl Journal,
    ) -> Result<(), NotSent> {
        let frame = self.monitor.stopping_status(self.now);
        if self.node.as_ref().is_some_and(|node| !node.sends_pdos()) {
            // NMT has silenced it. That it stops is told by the heartbeat that does not come.
            self.outbox.drop_pdos();
            return Ok(());
        }
        self.outbox.close(frame);
        for _ in 0..LAST_TRIES {
            if self.health.is_off() {
                return Err(NotSent::BusOff);
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
        Err(NotSent::Full)
    }

    fn receive(
        &mut self,
        port: &mut dyn Port,
        patience: Duration,
        journal: &mut impl Journal,
    ) -> Result<usize, PortError> {
        let Self { monitor, node, imitation, outbox, health, now, guard } = self;
        let mut outlet = Outlet { outbox, node, journal };
        let received = port.receive(patience, &mut |frame| {
            *now = frame.timestamp;
            outlet.journal.frame(frame);
            // The state of the bus on which it sends.
            let is_first = frame.bus == BusNumber::First;
            let changed = match ErrorFrame::read(frame) {
                _ if !is_first => false,
                Some(error) => health.take(&error),
                None => health.spoke(),
            };
            if changed {
                outlet.journal.bus(health);
            }
            if is_first {
                outlet.hear(frame, monitor);
                imitation.take(frame).into_iter().for_each(|it| outlet.notice(&it));
            }
            monitor.take(frame, &mut outlet);
        })?;
        for bus in received.lost.iter() {
            if bus == BusNumber::First {
                outlet.outbox.clear();
                *health = BusHealth::default();
            }
            monitor.interrupt_bus(bus, *now, &mut outlet);
        }
        if let Some(drained) = received.drained_at {
            *now = drained;
            let back = Span::from_nanos(guard.as_nanos().saturating_neg());
            monitor.advance(drained.after(back), &mut outlet);
        }
        imitation.advance(*now).into_iter().for_each(|it| outlet.notice(&it));
        outlet.beat(*now);
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

/// Passes the output of the monitor and the node to the outbox and the journal.
struct Outlet<'a, J> {
    outbox: &'a mut Outbox,
    node: &'a mut Option<Node>,
    journal: &'a mut J,
}

impl<J: Journal> Outlet<'_, J> {
    /// Lets the node take a frame from the bus. It sees the monitor, and changes nothing of it.
    fn hear(&mut self, frame: &Frame, monitor: &Monitor) {
        let Some(node) = self.node else { return };
        let status = monitor.last_status().map(|(_, status)| status);
        let view = NodeView { counts: monitor.counts(), status };
        let outbox = &mut *self.outbox;
        if let Some(event) = node.take(frame, view, &mut |frame| outbox.put(frame)) {
            if !node.sends_pdos() {
                outbox.drop_pdos();
            }
            self.journal.nmt(&event);
        }
    }

    /// Lets the node send the heartbeat that is due.
    fn beat(&mut self, now: Timestamp) {
        if let Some(node) = self.node {
            node.advance(now, &mut |frame| self.outbox.put(frame));
        }
    }
}

impl<J: Journal> Sink for Outlet<'_, J> {
    fn record(&mut self, record: &Record) {
        if let Some(node) = self.node {
            node.record(record);
        }
        self.journal.record(record);
    }

    fn warning(&mut self, warning: &Warning) {
        if let Some(node) = self.node {
            node.warning(warning, &mut |frame| self.outbox.put(frame));
        }
        self.journal.warning(warning);
    }

    fn incident(&mut self, incident: &Incident) {
        self.journal.incident(incident);
    }

    fn estimate(&mut self, _: Timestamp, cylinder: u8, estimate: Option<&Estimate>) {
        self.journal.estimate(cylinder, estimate);
    }

    fn dwell(&mut self, cylinder: u8, dwell: &Dwell) {
        self.journal.dwell(cylinder, dwell);
    }

    fn transmit(&mut self, frame: &OwnFrame) {
        if self.node.as_mut().is_none_or(|node| node.transmit(frame)) {
            self.outbox.put(frame.clone());
        }
    }

    fn notice(&mut self, notice: &Notice) {
        self.journal.notice(notice);
    }
}
