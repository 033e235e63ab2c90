//! Statistics of the frames heard on a bus.

use super::load::{Rates, seconds_on_bus};
use std::collections::BTreeMap;
use tertius_core::error_frame::{ControllerState, ErrorFrame};
use tertius_core::frame::{Frame, Id, Kind};
use tertius_core::time::Timestamp;

/// Most identifiers that are told apart: all standard ones, and as many extended.
const MOST: usize = 4096;

/// Byte of the counter in an E2E-protected frame (profile 5).
const COUNTER: usize = 2;

/// Statistics of frames.
#[derive(Clone, Debug)]
pub struct Hearing {
    /// Time of listening, s.
    pub seconds: f64,
    /// Reason why listening ended early.
    pub ended: Option<String>,
    /// Frames that the kernel dropped because nobody fetched them in time.
    pub dropped: u64,
    /// Number of data frames.
    pub frames: u64,
    /// Longest time that those occupied the bus, s.
    pub occupied: f64,
    pub errors: Errors,
    /// Sequence of the gateway's own status frames, which shows how many senders there are.
    pub status: Sequence,
    heard: BTreeMap<Id, HeardMessage>,
    rates: Rates,
    status_id: Id,
}

/// Statistics of one identifier.
#[derive(Clone, Debug, PartialEq)]
pub struct HeardMessage {
    pub count: u64,
    /// Length of the shortest frame, bytes.
    pub shortest: usize,
    first: Timestamp,
    last: Timestamp,
    /// Sum of the squared intervals, s².
    squares: f64,
    /// Shortest and longest interval, s.
    extremes: [f64; 2],
}

/// Intervals between frames of one identifier, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intervals {
    pub mean: f64,
    /// Standard deviation, s.
    pub jitter: f64,
    /// Largest deviation of one interval from the mean, s.
    pub largest_deviation: f64,
}

/// Error frames, and what they report.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Errors {
    pub frames: u64,
    /// Newest reported state of the controller.
    pub state: Option<ControllerState>,
    pub unacknowledged: u64,
    pub receive_overflows: u64,
    pub protocol: u64,
    pub transceiver: u64,
}

/// Frames with an alive counter, which one sender increments by one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sequence {
    pub frames: u64,
    /// Number of frames that do not follow the previous one.
    pub breaks: u64,
    last: Option<u8>,
}

impl Sequence {
    fn count(&mut self, counter: u8) {
        self.frames += 1;
        let follows = self.last.is_none_or(|last| last.wrapping_add(1) == counter);
        self.breaks += u64::from(!follows);
        self.last = Some(counter);
    }

    /// Whether there is more than one sender. A sender that restarts breaks the sequence once.
    pub const fn is_mixed(&self) -> bool {
        self.breaks > 1 && self.breaks * 4 > self.frames
    }
}

impl Hearing {
    /// Empty statistics of a bus with these rates; `status` is the identifier of the gateway's own
    /// status.
    pub fn new(rates: Rates, status: Id) -> Self {
        Self {
            seconds: 0.0,
            ended: None,
            dropped: 0,
            frames: 0,
            occupied: 0.0,
            errors: Errors::default(),
            status: Sequence::default(),
            heard: BTreeMap::new(),
            rates,
            status_id: status,
        }
    }

    pub fn take(&mut self, frame: &Frame) {
        if let Some(error) = ErrorFrame::read(frame) {
            self.errors.count(&error);
            return;
        }
        self.occupied += seconds_on_bus(frame, self.rates);
        if let Kind::Remote { .. } = frame.kind {
            return;
        }
        self.frames += 1;
        if frame.id == self.status_id
            && let Some(&counter) = frame.data().get(COUNTER)
        {
            self.status.count(counter);
        }
        if let Some(heard) = self.heard.get_mut(&frame.id) {
            heard.count(frame);
        } else if self.heard.len() < MOST {
            self.heard.insert(frame.id, HeardMessage::new(frame));
        }
    }

    /// Statistics of an identifier, if it was heard.
    pub fn of(&self, id: Id) -> Option<&HeardMessage> {
        self.heard.get(&id)
    }

    /// Identifiers that were heard.
    pub fn ids(&self) -> impl Iterator<Item = Id> {
        self.heard.keys().copied()
    }

    /// Largest part of the bus that its frames occupied.
    pub fn load(&self) -> Option<f64> {
        (self.seconds > 0.0).then(|| self.occupied / self.seconds)
    }
}

impl HeardMessage {
    fn new(frame: &Frame) -> Self {
        Self {
            count: 1,
            shortest: frame.length(),
            first: frame.timestamp,
            last: frame.timestamp,
            squares: 0.0,
            extremes: [f64::INFINITY, f64::NEG_INFINITY],
        }
    }

    fn count(&mut self, frame: &Frame) {
        let interval = frame.timestamp.since(self.last).as_seconds();
        self.count += 1;
        self.shortest = self.shortest.min(frame.length());
        self.last = frame.timestamp;
        self.squares += interval * interval;
        self.extremes = [self.extremes[0].min(interval), self.extremes[1].max(interval)];
    }

    /// Intervals; `None` with fewer than three frames.
    pub fn intervals(&self) -> Option<Intervals> {
        if self.count < 3 {
            return None;
        }
        let intervals = (self.count - 1) as f64;
        let mean = self.last.since(self.first).as_seconds() / intervals;
        let [shortest, longest] = self.extremes;
        Some(Intervals {
            mean,
            // Intervals of a second at the most: nothing of their squares cancels that matters.
            jitter: (self.squares / intervals - mean * mean).max(0.0).sqrt(),
            largest_deviation: (mean - shortest).max(longest - mean),
        })
    }
}

impl Errors {
    fn count(&mut self, error: &ErrorFrame) {
        self.frames += 1;
        self.state = error.state.or(self.state);
        self.unacknowledged += u64::from(error.unacknowledged);
        self.receive_overflows += u64::from(error.receive_overflow);
        self.protocol += u64::from(error.protocol);
        self.transceiver += u64::from(error.transceiver);
    }
}
