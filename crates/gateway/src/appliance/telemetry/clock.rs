//! Clocks of the telemetry, as a trait so that a test can provide them.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use tertius_core::time::Timestamp;

/// A monotonic clock, and the system's clock, by which people and kernels write time stamps.
pub trait Clock: Send + Sync {
    /// Time since this clock was made; never goes back.
    fn uptime(&self) -> Duration;

    /// The system's time, which may be set at any time.
    fn system(&self) -> Timestamp;
}

/// The computer's own clocks.
#[derive(Clone, Copy, Debug)]
pub struct SystemClock {
    start: Instant,
}

impl SystemClock {
    pub fn new() -> Self {
        Self { start: Instant::now() }
    }
}

impl Default for SystemClock {
    fn default() -> Self {
        Self::new()
    }
}

impl Clock for SystemClock {
    fn uptime(&self) -> Duration {
        self.start.elapsed()
    }

    fn system(&self) -> Timestamp {
        // A clock set to before 1970 is wrong, and 1970 is as good.
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Timestamp::from_nanos(i64::try_from(since.as_nanos()).unwrap_or(i64::MAX))
    }
}
