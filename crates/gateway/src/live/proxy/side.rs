//! One interface of the proxy, opened again after each loss.

use crate::bus::UnrestrictedPort;
use std::time::Duration;

/// Opens the interface, or returns the reason for people.
pub type Open<P> = Box<dyn FnMut() -> Result<P, String>>;

/// First and longest wait between two attempts to open a port.
const BACK_OFF: (Duration, Duration) = (Duration::from_millis(50), Duration::from_secs(2));

/// An interface that may come and go.
pub struct Side<P> {
    open: Open<P>,
    port: Option<P>,
    back_off: Duration,
    /// Time of the next attempt to open it, on the bench's clock.
    retry_at: Duration,
    /// Reason of a loss that was already reported.
    told: Option<String>,
    /// Number of frames that earlier ports lost for lack of room.
    overrun: u64,
}

/// A change of a side that is to be reported.
pub(super) enum Change {
    Opened,
    Lost(String),
}

impl<P: UnrestrictedPort> Side<P> {
    pub fn new(open: Open<P>) -> Self {
        Self {
            open,
            port: None,
            back_off: BACK_OFF.0,
            retry_at: Duration::ZERO,
            told: None,
            overrun: 0,
        }
    }

    pub const fn port(&self) -> Option<&P> {
        self.port.as_ref()
    }

    pub(super) const fn port_mut(&mut self) -> Option<&mut P> {
        self.port.as_mut()
    }

    /// Number of frames lost because the receive queue was full.
    pub fn overrun(&self) -> u64 {
        self.overrun + self.port.as_ref().map_or(0, |port| port.counts().dropped)
    }

    /// Opens the port if it is closed and an attempt is due.
    pub(super) fn attend(&mut self, now: Duration) -> Option<Change> {
        if self.port.is_some() || now < self.retry_at {
            return None;
        }
        match (self.open)() {
            Ok(port) => {
                self.port = Some(port);
                Some(Change::Opened)
            }
            Err(reason) => self.lose(reason, now),
        }
    }

    /// Notes that the port is finished, or that there is none. Reported once for each new reason.
    pub(super) fn lose(&mut self, reason: String, now: Duration) -> Option<Change> {
        self.overrun = self.overrun();
        self.port = None;
        self.retry_at = now + self.back_off;
        self.back_off = (self.back_off * 2).min(BACK_OFF.1);
        if self.told.as_ref() == Some(&reason) {
            return None;
        }
        self.told = Some(reason.clone());
        Some(Change::Lost(reason))
    }

    /// Notes that the interface carries frames, so that the next loss is a new one.
    pub(super) fn works(&mut self) {
        self.back_off = BACK_OFF.0;
        self.told = None;
    }

    /// Time until something has to be done without a frame: the next attempt to open it.
    pub(super) fn idle(&self, now: Duration) -> Option<Duration> {
        self.port.is_none().then(|| self.retry_at.saturating_sub(now))
    }
}
