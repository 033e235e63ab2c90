//! One interface of the proxy, opened anew after each loss.

use crate::bus::UnrestrictedPort;
use std::time::Duration;

/// Opens the interface, or says for people why not.
pub type Open<P> = Box<dyn FnMut() -> Result<P, String>>;

/// The first and the longest wait between two tries to open a port.
const BACK_OFF: (Duration, Duration) = (Duration::from_millis(50), Duration::from_secs(2));

/// An interface that comes and goes.
pub struct Side<P> {
    open: Open<P>,
    port: Option<P>,
    back_off: Duration,
    /// The next try to open it, on the bench's clock.
    retry_at: Duration,
    /// The reason of a loss that was told already.
    told: Option<String>,
    /// Frames that the ports before this one lost for want of room.
    overrun: u64,
}

/// What happened to a side that someone should be told.
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

    /// Frames that were lost because the receive queue was full.
    pub fn overrun(&self) -> u64 {
        self.overrun + self.port.as_ref().map_or(0, |port| port.counts().dropped)
    }

    /// Opens the port if it is closed and time for a try.
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

    /// The port is finished, or there is none. Told once for each new reason.
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

    /// The interface carries frames: the next loss is a new one.
    pub(super) fn works(&mut self) {
        self.back_off = BACK_OFF.0;
        self.told = None;
    }

    /// How long until something has to be done without a frame: the next try to open it.
    pub(super) fn idle(&self, now: Duration) -> Option<Duration> {
        self.port.is_none().then(|| self.retry_at.saturating_sub(now))
    }
}
