//! The newest cycle, as frames find it.

use crate::time::{Span, Timestamp};

/// The newest cycle, as a frame finds it.
#[derive(Clone, Copy, Debug)]
pub struct When {
    pub cycle: u64,
    pub opened: Timestamp,
    pub open: bool,
    /// Whether a Sync opened it, so that a frame with an earlier time stamp belongs to an earlier
    /// cycle.
    pub by_sync: bool,
    /// Sample time Ts.
    pub sample_time: Span,
}

impl When {
    /// Time from the opening to `stamp`, ns.
    pub(super) const fn phase(&self, stamp: Timestamp) -> i64 {
        stamp.since(self.opened).as_nanos()
    }

    /// Half a sample time, ns.
    pub(super) const fn half(&self) -> i64 {
        self.sample_time.as_nanos() / 2
    }
}
