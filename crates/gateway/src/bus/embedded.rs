//! The embedded bus, `interface = "virtual"`: a CAN bus inside the program, for use without a real
//! one.
//!
//! Each endpoint gets what the others send, in the same order for all. The bus gets its clock from
//! the caller, so that a simulator or a test can control the time.

use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::port::{
    Identifiers, Port, PortCounts, PortError, Received, Sent, Stamps, carried, system_time,
};
use super::unrestricted::{HandOver, Unrestricted};
use tertius_core::alarm::OwnFrame;
use tertius_core::frame::{Frame, Kind};
use tertius_core::time::{Span, Timestamp};

/// The name of the embedded bus in a configuration.
pub const NAME: &str = "virtual";

/// Most frames that one call of `receive` takes, as from a socket.
const AT_ONCE: usize = 256;

/// Clock of the bus.
#[derive(Clone, Debug)]
pub enum Clock {
    /// The system's clock; `receive` waits.
    System,
    /// A clock that the caller sets; `receive` never waits, since no time would pass.
    Manual(ManualClock),
}

/// A clock that stands until it is set. Clones show the same time.
#[derive(Clone, Debug)]
pub struct ManualClock(Arc<AtomicI64>);

impl ManualClock {
    pub fn new(start: Timestamp) -> Self {
        Self(Arc::new(AtomicI64::new(start.as_nanos())))
    }

    pub fn now(&self) -> Timestamp {
        Timestamp::from_nanos(self.0.load(Ordering::SeqCst))
    }

    /// Sets the clock, possibly back, as with a system's clock.
    pub fn set(&self, now: Timestamp) {
        self.0.store(now.as_nanos(), Ordering::SeqCst);
    }

    pub fn advance(&self, by: Span) {
        self.set(self.now().after(by));
    }
}

impl Clock {
    fn now(&self) -> Timestamp {
        match self {
            Self::System => system_time(),
            Self::Manual(clock) => clock.now(),
        }
    }
}

/// State of the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BusState {
    /// The bus carries frames.
    #[default]
    Up,
    /// Nobody acknowledges and the queue is full: no frame is accepted.
    Jammed,
    /// The bus is down, like an interface that was brought down.
    Down,
    /// The bus is gone, like an interface that was deleted.
    Gone,
}

/// An embedded bus. Clones are the same bus.
#[derive(Clone)]
pub struct EmbeddedBus(Arc<Shared>);

struct Shared {
    clock: Clock,
    wires: Mutex<Wires>,
    /// Signalled when a frame or a change of state comes.
    bell: Condvar,
}

#[derive(Default)]
struct Wires {
    state: BusState,
    next: u64,
    queues: BTreeMap<u64, Queue>,
}

/// Frames that an endpoint has not received yet.
struct Queue {
    frames: VecDeque<Frame>,
    capacity: usize,
    identifiers: Identifiers,
    dropped: u64,
    /// State that ended this endpoint: once down, it has to be opened again.
    ended: Option<BusState>,
}

impl EmbeddedBus {
    pub fn new(clock: Clock) -> Self {
        Self(Arc::new(Shared { clock, wires: Mutex::default(), bell: Condvar::new() }))
    }

    /// Connects to the bus. `capacity` frames may wait to be received; those beyond are dropped and
    /// counted.
    ///
    /// # Errors
    /// The bus is down or gone.
    pub fn open(&self, identifiers: &Identifiers, capacity: usize) -> Result<Endpoint, PortError> {
        let mut wires = self.0.lock();
        if let Some(error) = error_of(wires.state) {
            return Err(error);
        }
        let number = wires.next;
        wires.next += 1;
        let queue = Queue {
            frames: VecDeque::with_capacity(capacity),
            capacity,
            identifiers: identifiers.clone(),
            dropped: 0,
            ended: None,
        };
        wires.queues.insert(number, queue);
        drop(wires);
        Ok(Endpoint { bus: Arc::clone(&self.0), number, counts: PortCounts::default() })
    }

    /// Connects as [`Self::open`] does, for an endpoint that may send any frame.
    ///
    /// # Errors
    /// See [`Self::open`].
    pub fn open_unrestricted(
        &self,
        identifiers: &Identifiers,
        capacity: usize,
    ) -> Result<Unrestricted<Endpoint>, PortError> {
        self.open(identifiers, capacity).map(Unrestricted)
    }

    /// Sets the state of the bus. An endpoint that sees it go down or away is finished, even if it
    /// comes back, once it has received what had come before.
    pub fn set_state(&self, state: BusState) {
        let mut wires = self.0.lock();
        wires.state = state;
        if error_of(state).is_some() {
            for queue in wires.queues.values_mut() {
                queue.ended.get_or_insert(state);
            }
        }
        self.0.bell.notify_all();
    }

    /// Number of connected endpoints.
    pub fn endpoints(&self) -> usize {
        self.0.lock().queues.len()
    }

    /// Time of the bus.
    pub fn now(&self) -> Timestamp {
        self.0.clock.now()
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Wires> {
        // Nothing panics while it is held, and frames are whole or not there.
        self.wires.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until the endpoint has a frame or has ended.
    fn wait(&self, number: u64, patience: Duration) {
        if matches!(self.clock, Clock::Manual(_)) {
            return;
        }
        let started = Instant::now();
        let mut wires = self.lock();
        while wires.queue(number).is_idle() {
            let left = patience.saturating_sub(started.elapsed());
            if left.is_zero() {
                return;
            }
            let waited = self.bell.wait_timeout(wires, left);
            wires = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    fn send(&self, from: u64, frame: &Frame) -> Result<Sent, PortError> {
        carried(frame)?;
        let mut wires = self.lock();
        if let Some(error) = wires.queue(from).ended.and_then(error_of) {
            return Err(error);
        }
        if wires.state == BusState::Jammed {
            return Ok(Sent::Full);
        }
        let mut frame = frame.clone();
        // With the lock held, so that stamps and order agree.
        frame.timestamp = self.clock.now();
        for (&number, queue) in &mut wires.queues {
            if number != from {
                queue.push(&frame);
            }
        }
        self.bell.notify_all();
        Ok(Sent::Taken)
    }
}

impl Wires {
    fn queue(&mut self, number: u64) -> &mut Queue {
        self.queues.get_mut(&number).expect("an endpoint's queue lives as long as it does")
    }
}

impl Queue {
    fn is_idle(&self) -> bool {
        self.frames.is_empty() && self.ended.is_none()
    }

    fn push(&mut self, frame: &Frame) {
        let wanted = match (&self.identifiers, frame.kind) {
            (Identifiers::All, _) | (_, Kind::Error) => true,
            (Identifiers::Only(_), Kind::Remote { .. }) => false,
            (Identifiers::Only(ids), _) => ids.contains(&frame.id),
        };
        if !wanted || self.ended.is_some() {
            return;
        }
        if self.frames.len() < self.capacity {
            self.frames.push_back(frame.clone());
        } else {
            self.dropped += 1;
        }
    }
}

fn error_of(state: BusState) -> Option<PortError> {
    match state {
        BusState::Up | BusState::Jammed => None,
        BusState::Down => Some(PortError::Down),
        BusState::Gone => Some(PortError::Gone),
    }
}

/// A connection to an [`EmbeddedBus`]. It sends only the gateway's own frames.
pub struct Endpoint {
    bus: Arc<Shared>,
    number: u64,
    counts: PortCounts,
}

impl HandOver for Endpoint {
    fn hand_over(&mut self, frame: &Frame) -> Result<Sent, PortError> {
        let sent = self.bus.send(self.number, frame)?;
        match sent {
            Sent::Taken => self.counts.sent += 1,
            Sent::Full => self.counts.refused += 1,
        }
        Ok(sent)
    }
}

impl Endpoint {
    fn count(&mut self, frame: &Frame) {
        self.counts.received += 1;
        self.counts.error_frames += u64::from(frame.kind == Kind::Error);
    }
}

impl Port for Endpoint {
    fn receive(
        &mut self,
        patience: Duration,
        take: &mut dyn FnMut(&Frame),
    ) -> Result<Received, PortError> {
        self.bus.wait(self.number, patience);
        let mut received = Received::default();
        while received.frames < AT_ONCE {
            let mut wires = self.bus.lock();
            let queue = wires.queue(self.number);
            let (next, ended) = (queue.frames.pop_front(), queue.ended);
            let Some(frame) = next else {
                received.drained_at = ended.is_none().then(|| self.bus.clock.now());
                break;
            };
            // `take` may send on this bus.
            drop(wires);
            self.count(&frame);
            received.frames += 1;
            take(&frame);
        }
        if received.frames > 0 {
            self.counts.batches += 1;
            self.counts.largest_batch = self.counts.largest_batch.max(received.frames as u64);
            return Ok(received);
        }
        match self.bus.lock().queue(self.number).ended.and_then(error_of) {
            Some(error) => Err(error),
            None => Ok(received),
        }
    }

    fn send(&mut self, frame: &OwnFrame) -> Result<Sent, PortError> {
        self.hand_over(frame.as_frame())
    }

    fn counts(&self) -> PortCounts {
        PortCounts { dropped: self.bus.lock().queue(self.number).dropped, ..self.counts }
    }

    fn stamps(&self) -> Stamps {
        Stamps::Embedded
    }

    fn description(&self) -> String {
        let mut wires = self.bus.lock();
        let queue = wires.queue(self.number);
        let filters = match &queue.identifiers {
            Identifiers::All => "all identifiers".to_owned(),
            Identifiers::Only(ids) => format!("{} identifiers", ids.len()),
        };
        let capacity = queue.capacity;
        format!(
            "virtual (the embedded bus): receives {filters} and error frames; time stamps: {}; \
             receive buffer {capacity} frames",
            Stamps::Embedded
        )
    }
}

impl Drop for Endpoint {
    fn drop(&mut self) {
        self.bus.lock().queues.remove(&self.number);
    }
}
