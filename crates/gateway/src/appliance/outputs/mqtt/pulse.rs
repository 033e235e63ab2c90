//! Whether the broker is still there: what was sent last, and which answers are awaited.

use super::link::ANSWER;
use super::trouble::MqttTrouble;
use std::time::{Duration, Instant};

/// When to ask the broker whether it is there, and how long its answers take.
#[derive(Debug)]
pub(super) struct Pulse {
    ping_after: Duration,
    /// When something was sent last, and since when an answer is awaited.
    sent: Instant,
    asked: Option<Instant>,
    /// Whether a ping is not answered.
    pinged: bool,
}

impl Pulse {
    /// Of a connection on which something has to be sent every `keep_alive` seconds.
    pub fn new(keep_alive: u16) -> Self {
        Self {
            ping_after: Duration::from_secs(u64::from(keep_alive)) / 2,
            sent: Instant::now(),
            asked: None,
            pinged: false,
        }
    }

    /// Notes that something is sent.
    pub fn sent(&mut self) {
        self.sent = Instant::now();
    }

    /// Notes that something is sent that the broker has to answer.
    pub fn awaits(&mut self) {
        self.asked.get_or_insert_with(Instant::now);
    }

    /// Whether a ping is to be sent.
    pub fn is_due(&self) -> bool {
        self.sent.elapsed() >= self.ping_after && !self.pinged
    }

    /// Notes that a ping is sent.
    pub fn asks(&mut self) {
        self.pinged = true;
        self.awaits();
    }

    /// Whether a ping is not answered.
    pub const fn is_waiting(&self) -> bool {
        self.pinged
    }

    /// Notes an answer to a ping.
    pub const fn answered(&mut self) {
        self.pinged = false;
        self.asked = None;
    }

    /// Notes an answer, after which another one is awaited if `more`, or if it was none to a ping.
    pub fn goes_on(&mut self, more: bool) {
        self.asked = (self.pinged || more).then(Instant::now);
    }

    /// # Errors
    /// An answer is overdue.
    pub fn check(&self) -> Result<(), MqttTrouble> {
        match self.asked {
            Some(since) if since.elapsed() > ANSWER => Err(MqttTrouble::Silent(ANSWER.as_secs())),
            _ => Ok(()),
        }
    }
}
