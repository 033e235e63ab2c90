//! One direction of the proxy: frames on their way to an interface, limited in number and age.

use crate::bus::{PortError, Sent, UnrestrictedPort};
use std::collections::VecDeque;
use tertius_core::frame::Frame;
use tertius_core::time::{Span, Timestamp};

/// Limits of a lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LaneLimits {
    /// Most frames that wait; the oldest gives way.
    pub waiting: usize,
    /// Age at which a frame is dropped instead of being sent late.
    pub age: Span,
}

/// Counts of what became of the frames of a lane. Each received frame is in exactly one of `sent`,
/// `lost`, `too_old`, `crowded_out`, `away` and `rejected`, or still waits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LaneCounts {
    /// Frames received for forwarding.
    pub received: u64,
    /// Error frames, which concern one bus only and are never forwarded.
    pub error_frames: u64,
    pub sent: u64,
    /// Frames whose payload a fault changed.
    pub changed: u64,
    /// Frames lost to a fault.
    pub lost: u64,
    /// Frames dropped for their age.
    pub too_old: u64,
    /// Frames dropped because too many waited.
    pub crowded_out: u64,
    /// Frames dropped because an interface was not there.
    pub away: u64,
    /// Frames that the interface does not carry, such as CAN FD on a classic one.
    pub rejected: u64,
}

/// Frames that wait, in order.
#[derive(Clone, Debug)]
pub struct Lane {
    limits: LaneLimits,
    waiting: VecDeque<Frame>,
    /// Present time, on the clock of the time stamps.
    now: Timestamp,
    counts: LaneCounts,
    rejection: Option<String>,
}

impl Lane {
    pub fn new(limits: LaneLimits) -> Self {
        Self {
            limits,
            waiting: VecDeque::with_capacity(limits.waiting),
            now: Timestamp::default(),
            counts: LaneCounts::default(),
            rejection: None,
        }
    }

    pub const fn counts(&self) -> &LaneCounts {
        &self.counts
    }

    pub(super) const fn counts_mut(&mut self) -> &mut LaneCounts {
        &mut self.counts
    }

    /// Why the interface first refused a frame.
    pub fn rejection(&self) -> Option<&str> {
        self.rejection.as_deref()
    }

    /// Number of frames that wait.
    pub fn waiting(&self) -> usize {
        self.waiting.len()
    }

    /// Sets the lane's time, on which only its frames' ages depend.
    pub fn set_time(&mut self, now: Timestamp) {
        self.now = now;
    }

    /// Takes the next frame; its time stamp is the time of its reception.
    pub fn put(&mut self, frame: &Frame) {
        if self.waiting.len() >= self.limits.waiting {
            self.waiting.pop_front();
            self.counts.crowded_out += 1;
        }
        self.waiting.push_back(frame.clone());
    }

    /// Sends the frames that `port` accepts.
    ///
    /// # Errors
    /// The port is finished; the frames still wait.
    pub fn send(&mut self, port: &mut impl UnrestrictedPort) -> Result<(), PortError> {
        self.drop_old();
        while let Some(frame) = self.waiting.front() {
            match port.send_unrestricted(frame) {
                Ok(Sent::Taken) => self.counts.sent += 1,
                Ok(Sent::Full) => break,
                // It is this frame that cannot be carried; the next one may.
                Err(PortError::Io(error)) => {
                    self.counts.rejected += 1;
                    self.rejection.get_or_insert_with(|| error.to_string());
                }
                Err(error) => return Err(error),
            }
            self.waiting.pop_front();
        }
        Ok(())
    }

    /// Drops the waiting frames after an end of the lane is lost, since they would burst out stale
    /// when it returns.
    pub fn clear(&mut self) {
        self.counts.away += self.waiting.len() as u64;
        self.waiting.clear();
    }

    fn drop_old(&mut self) {
        let Self { limits, waiting, now, counts, .. } = self;
        while waiting.front().is_some_and(|frame| now.since(frame.timestamp) > limits.age) {
            waiting.pop_front();
            counts.too_old += 1;
        }
    }
}
