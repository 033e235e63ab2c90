//! When a cycle opens and closes, from time stamps alone.
//!
//! A cycle is opened by Sync where one is configured, else by the first transducer frame about a
//! sample time after the last opening: readings come first and the command that answers them
//! follows, so a valve frame never opens a cycle. It closes a deadline after its opening. When the
//! deadline of the next cycle passes without an opening, that cycle is missing.
//!
//! An opening by Sync is when Sync came. Without it the openings are a grid of sample times, which
//! follows the frames that open cycles slowly, so that one that is early or late moves no cycle.

use super::arrival::When;
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
    /// Openings by readings that the grid has followed, up to [`SLOWNESS`].
    followed: i64,
}

/// The grid moves by this part of how far an opening is beside it, once it has followed as many.
const SLOWNESS: i64 = 16;

impl CycleClock {
    pub fn new(timing: CycleTiming) -> Self {
        Self { timing, opened: None, open: false, without_sync: false, number: 0, followed: 0 }
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

    /// How many cycles in a row are missing before `now`, if nothing opens.
    pub fn missing_until(&self, now: Timestamp) -> u64 {
        let Some(Due::Missing(first)) = self.due() else { return 0 };
        let beyond = now.since(first).as_nanos();
        let more = beyond.saturating_sub(1) / self.timing.sample_time.as_nanos();
        if beyond > 0 { more as u64 + 1 } else { 0 }
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

    /// Whether a Sync at `at` is that of a cycle that a reading has opened for it. The cycle then
    /// begins with the Sync.
    pub fn confirms(&mut self, at: Timestamp) -> bool {
        let near =
            |elapsed: Span| elapsed < self.half() && elapsed.as_nanos() > -self.half().as_nanos();
        let confirms = self.without_sync && self.since_opening(at).is_some_and(near);
        if confirms {
            self.without_sync = false;
            self.opened = Some(at);
        }
        confirms
    }

    /// Whether a Sync at `at` is that of the newest cycle once more, as where a bus is recorded on two
    /// interfaces: the next one comes no earlier than three quarters of a sample time after it.
    pub fn has_had_sync(&self, at: Timestamp) -> bool {
        let soon = Span::from_nanos(self.timing.sample_time.as_nanos() / 4 * 3);
        !self.without_sync && self.since_opening(at).is_some_and(|elapsed| elapsed < soon)
    }

    /// The newest cycle, as frames find it; `None` before the first one.
    #[inline]
    pub fn when(&self) -> Option<When> {
        Some(When {
            cycle: self.number,
            opened: self.opened?,
            open: self.open,
            by_sync: self.timing.synchronised && !self.without_sync,
            sample_time: self.timing.sample_time,
        })
    }

    /// Whether a transducer frame at `at` could open the next cycle by its time; `has` if its place
    /// has had a frame in the newest one.
    #[inline]
    pub fn could_open(&self, at: Timestamp, has: bool) -> bool {
        let Some(elapsed) = self.since_opening(at) else { return true };
        if self.timing.synchronised {
            // Sync was lost: only a reading about one sample time later may stand in for it.
            (has || !self.open) && elapsed >= self.earliest_without_sync()
        } else {
            !self.open && elapsed >= self.half()
        }
    }

    /// Whether readings open cycles, so that one that came early opens its cycle when the one before
    /// it has closed.
    pub const fn is_opened_by_readings(&self) -> bool {
        !self.timing.synchronised
    }

    /// How many cycles went missing between the newest one and an opening at `at`.
    pub fn missing_before(&self, at: Timestamp) -> u64 {
        let Some(elapsed) = self.since_opening(at) else { return 0 };
        let period = self.timing.sample_time.as_nanos();
        let cycles = (elapsed.as_nanos().saturating_add(period / 2)) / period;
        (cycles.max(1) - 1) as u64
    }

    /// Opens the next cycle for a frame at `at`, after [`Self::skip`] of those that went missing.
    pub fn open(&mut self, at: Timestamp, by_sync: bool) {
        self.opened = Some(if by_sync { at } else { self.on_grid(at) });
        self.open = true;
        self.without_sync = self.timing.synchronised && !by_sync;
        self.number += 1;
    }

    /// Where the cycle opens that a reading at `at` opens.
    fn on_grid(&mut self, at: Timestamp) -> Timestamp {
        let expected = self.opened.map(|opened| opened.after(self.timing.sample_time));
        let beside = expected.map(|expected| at.since(expected));
        let near = |beside: &Span| beside.as_nanos().abs() <= self.half().as_nanos();
        let Some((expected, beside)) = expected.zip(beside.filter(near)) else {
            self.followed = 0;
            return at;
        };
        self.followed = (self.followed + 1).min(SLOWNESS);
        // Behind Sync a reading that stands in for it tells nothing of where Sync would have been.
        let slowness = if self.timing.synchronised { SLOWNESS } else { self.followed };
        expected.after(Span::from_nanos(beside.as_nanos() / slowness))
    }

    /// Forgets the phase, after a jump in time.
    pub fn reset(&mut self) {
        self.opened = None;
        self.open = false;
        self.without_sync = false;
        self.followed = 0;
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
