//! What is said of a bus that falls quiet, speaks again or comes too fast.

use crate::bus::Port;
use crate::monitor::Counts;
use std::time::{Duration, Instant};
use tracing::{info, warn};

/// Without a frame of the machine for this long the bus is quiet.
const QUIET: Duration = Duration::from_secs(1);

/// Tells once when the bus becomes quiet and once when it speaks again, and of frames lost.
#[derive(Debug)]
pub(super) struct Activity {
    used: u64,
    since: Instant,
    quiet: bool,
    dropped: u64,
}

impl Activity {
    pub(super) fn new() -> Self {
        Self { used: 0, since: Instant::now(), quiet: false, dropped: 0 }
    }

    pub(super) fn look(&mut self, counts: &Counts, port: &dyn Port) {
        if counts.used != self.used {
            if self.quiet {
                info!("the machine speaks again after {:.1} s", self.since.elapsed().as_secs_f64());
            }
            (self.used, self.since, self.quiet) = (counts.used, Instant::now(), false);
        } else if !self.quiet && self.since.elapsed() >= QUIET {
            self.quiet = true;
            warn!("no frame of the machine for a second: nothing is known of it");
        }
        let dropped = port.counts().dropped;
        if dropped > self.dropped {
            warn!(frames = dropped - self.dropped, "frames were lost: the receive queue was full");
        }
        self.dropped = dropped;
    }
}
