//! When a cycle opens and closes, from time stamps alone.
//!
//! A cycle is opened by Sync where one is configured, else by the first transducer frame at least
//! half a sample time after the last opening: readings come first and the command that answers
//! them follows, so a valve frame never opens a cycle. It closes a deadline after its opening.
//! When the deadline of the next cycle passes without an opening, that cycle is missing.

use crate::time::{Span, Timestamp};

/// Sample time and deadline of the cycles.
#[derive(Clone, Copy, Debug)]
pub struct CycleTiming {
    /// Ts.
    pub sample_time: Span,
    /// From the opening to the closing; less than Ts.
    pub deadline: Span,
    /// Whether a Sync message opens cycles.
    pub synchronised: bool,
}

/// What the arrival of a transducer frame does to the cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrival {
    /// It belongs to the open cycle.
    Current,
    /// It opens a new one.
    Opens,
    /// Its cycle is closed, and it is too early for the next.
    Late,
}

/// A point of time at which the cycle changes by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Due {
    /// The open cycle closes.
    Close(Timestamp),
    /// A whole cycle has passed without an opening.
    Missing(Timestamp),
}

impl Due {
    pub const fn at(self) -> Timestamp {
        match self {
            Self::Close(at) | Self::Missing(at) => at,
        }
    }
}

/// The state of the machine's cycle.
#[derive(Clone, Debug)]
pub struct CycleClock {
    timing: CycleTiming,
    /// Opening of the newest cycle, real or missing.
    opened: Option<Timestamp>,
    open: bool,
    /// The newest cycle was opened by a reading although Sync is configured.
    without_sync: bool,
    number: u64,
}

impl CycleClock {
    pub fn new(timing: CycleTiming) -> Self {
        Self { timing, opened: None, open: false, without_sync: false, number: 0 }
    }

    /// Ts.
    pub const fn sample_time(&self) -> Span {
        self.timing.sample_time
    }

    /// Number of the newest cycle, counting missing ones.
    pub const fn number(&self) -> u64 {
        self.number
    }

    /// When the newest cycle opened.
    pub const fn opened(&self) -> Option<Timestamp> {
        self.opened
    }

    pub const fn is_open(&self) -> bool {
        self.open
    }

    /// The next change that time alone brings; `None` before the first cycle.
    pub fn due(&self) -> Option<Due> {
        let opened = self.opened?;
        let closing = opened.after(self.timing.deadline);
        Some(if self.open {
            Due::Close(closing)
        } else {
            Due::Missing(closing.after(self.timing.sample_time))
        })
    }

    /// The open cycle has closed.
    pub fn close(&mut self) {
        self.open = false;
    }

    /// Steps over `count` cycles in which nothing opened.
    pub fn skip(&mut self, count: u64) {
        let nanos = self.timing.sample_time.as_nanos().saturating_mul(count as i64);
        self.opened = self.opened.map(|opened| opened.after(Span::from_nanos(nanos)));
        self.number += count;
        self.open = false;
    }

    /// Whether a Sync at `at` only confirms a cycle that a reading opened just before it.
    pub fn confirms(&mut self, at: Timestamp) -> bool {
        let confirms = self.without_sync && self.since_opening(at).is_some_and(|e| e < self.half());
        if confirms {
            self.without_sync = false;
        }
        confirms
    }

    /// What a transducer frame at `at` does, if its message was `repeated` within this cycle.
    pub fn arrival(&self, at: Timestamp, repeated: bool) -> Arrival {
        let Some(elapsed) = self.since_opening(at) else { return Arrival::Opens };
        let opens = if self.timing.synchronised {
            // Sync was lost: only a reading about one sample time later may stand in for it.
            elapsed >= self.earliest_without_sync() && (repeated || !self.open)
        } else {
            elapsed >= self.half()
        };
        match (opens, self.open) {
            (true, _) => Arrival::Opens,
            (false, true) => Arrival::Current,
            (false, false) => Arrival::Late,
        }
    }

    /// How many cycles went missing between the newest one and an opening at `at`.
    pub fn missing_before(&self, at: Timestamp) -> u64 {
        let Some(elapsed) = self.since_opening(at) else { return 0 };
        let period = self.timing.sample_time.as_nanos();
        let cycles = (elapsed.as_nanos().saturating_add(period / 2)) / period;
        (cycles.max(1) - 1) as u64
    }

    /// Opens the next cycle at `at`, after [`Self::skip`] of those that went missing.
    pub fn open(&mut self, at: Timestamp, by_sync: bool) {
        self.opened = Some(at);
        self.open = true;
        self.without_sync = self.timing.synchronised && !by_sync;
        self.number += 1;
    }

    /// Forgets the phase, after a jump in time.
    pub fn reset(&mut self) {
        self.opened = None;
        self.open = false;
        self.without_sync = false;
    }

    fn since_opening(&self, at: Timestamp) -> Option<Span> {
        self.opened.map(|opened| at.since(opened))
    }

    fn half(&self) -> Span {
        Span::from_nanos(self.timing.sample_time.as_nanos() / 2)
    }

    /// Readings follow Sync, so one that stands in for it comes no earlier than Sync would have, but
    /// for some jitter; what comes before that is a late one of the cycle before.
    fn earliest_without_sync(&self) -> Span {
        Span::from_nanos(self.timing.sample_time.as_nanos() / 20 * 19)
    }
}
