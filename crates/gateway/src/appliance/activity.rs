//! Log lines about a bus that falls quiet, resumes, delivers frames too fast or accepts none.

use crate::bus::{Port, PortCounts};
use crate::live::gateway::Gateway;
use std::time::{Duration, Instant};
use tracing::{info, warn};

/// Time without a frame of the machine after which the bus is quiet.
const QUIET: Duration = Duration::from_secs(1);

/// Least interval at which a persisting condition is logged again.
const AGAIN: Duration = Duration::from_secs(60);

/// Reports once when the bus becomes quiet and once when it resumes, and reports lost frames.
#[derive(Debug)]
pub(super) struct Activity {
    used: u64,
    since: Instant,
    quiet: bool,
    dropped: Growth,
    too_old: Growth,
    crowded_out: Growth,
    jam: Jam,
}

impl Activity {
    pub(super) fn new() -> Self {
        Self {
            used: 0,
            since: Instant::now(),
            quiet: false,
            dropped: Growth::default(),
            too_old: Growth::default(),
            crowded_out: Growth::default(),
            jam: Jam::default(),
        }
    }

    pub(super) fn look(&mut self, gateway: &Gateway, port: &dyn Port) {
        self.look_for_frames(gateway.monitor().counts().used);
        let counts = port.counts();
        if let Some(frames) = self.dropped.by(counts.dropped) {
            warn!(frames, "frames were lost: the receive queue was full");
        }
        self.jam.look(&counts);
        let outbox = gateway.outbox().counts();
        if let Some(frames) = self.too_old.by(outbox.too_old) {
            warn!(frames, "frames were too old to send: the interface accepts none, or too few");
        }
        if let Some(frames) = self.crowded_out.by(outbox.crowded_out) {
            warn!(frames, "warnings gave way to newer ones: more than the bus share allows");
        }
    }

    fn look_for_frames(&mut self, used: u64) {
        if used != self.used {
            if self.quiet {
                info!("the machine sends again after {:.1} s", self.since.elapsed().as_secs_f64());
            }
            (self.used, self.since, self.quiet) = (used, Instant::now(), false);
        } else if !self.quiet && self.since.elapsed() >= QUIET {
            self.quiet = true;
            warn!("no frame of the machine for a second: its state is unknown");
        }
    }
}

/// An interface that accepts no frames: nobody acknowledges them, or the bus is full.
#[derive(Clone, Copy, Debug, Default)]
struct Jam {
    sent: u64,
    refused: u64,
    since: Option<Instant>,
    told: bool,
}

impl Jam {
    fn look(&mut self, counts: &PortCounts) {
        if counts.sent != self.sent {
            if let (true, Some(since)) = (self.told, self.since) {
                let seconds = since.elapsed().as_secs_f64();
                info!("the interface accepts frames again after {seconds:.1} s");
            }
            (self.since, self.told) = (None, false);
        } else if counts.refused > self.refused {
            let since = *self.since.get_or_insert_with(Instant::now);
            if !self.told && since.elapsed() >= QUIET {
                self.told = true;
                warn!(
                    "the interface has accepted no frame for a second: nobody acknowledges, or the \
                     bus is full; waiting frames are dropped when they are too old"
                );
            }
        }
        (self.sent, self.refused) = (counts.sent, counts.refused);
    }
}

/// A count whose growth is logged, at once and then from time to time.
#[derive(Clone, Copy, Debug, Default)]
struct Growth {
    told: u64,
    last: Option<Instant>,
}

impl Growth {
    /// Growth of `count` since it was last logged, if it is to be logged now.
    fn by(&mut self, count: u64) -> Option<u64> {
        if count == self.told {
            return None;
        }
        if count < self.told {
            // Another port or gateway counts from zero.
            *self = Self { told: 0, ..*self };
        }
        if self.last.is_some_and(|last| last.elapsed() < AGAIN) {
            return None;
        }
        let grown = count - self.told;
        *self = Self { told: count, last: Some(Instant::now()) };
        (grown > 0).then_some(grown)
    }
}
