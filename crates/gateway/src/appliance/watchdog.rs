//! The service manager and its watchdog.

use sd_notify::NotifyState;
use std::time::{Duration, Instant};

/// Notifies the service manager; does nothing without one.
pub(super) fn notify(states: &[NotifyState<'_>]) {
    _ = sd_notify::notify(states);
}

/// Feeds the service manager's watchdog at half its time.
#[derive(Debug)]
pub(super) struct Watchdog {
    period: Option<Duration>,
    fed: Instant,
}

impl Watchdog {
    pub(super) fn new() -> Self {
        Self { period: sd_notify::watchdog_enabled().map(|time| time / 2), fed: Instant::now() }
    }

    pub(super) fn feed(&mut self) {
        if self.period.is_some_and(|period| self.fed.elapsed() >= period) {
            notify(&[NotifyState::Watchdog]);
            self.fed = Instant::now();
        }
    }
}
