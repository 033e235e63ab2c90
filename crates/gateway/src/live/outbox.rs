//! Frames that wait to be sent, limited in number, age and share of the bus.

mod services;

use services::Waiting;
use std::collections::VecDeque;
use tertius_core::alarm::detector::MOST_STANDING;
use tertius_core::alarm::own::{FRAME_BITS, Queue};
use tertius_core::alarm::status::MAX_CYLINDERS;
use tertius_core::alarm::{OwnContent, OwnFrame};
use tertius_core::time::{Span, Timestamp};

/// Limits of the outbox.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutboxLimits {
    /// Most warnings that wait, and most emergency messages; the oldest gives way.
    pub waiting: usize,
    /// Most estimates that wait, one for each cylinder; the oldest gives way.
    pub estimates: usize,
    /// Age at which a frame is dropped instead of being sent late.
    pub age: Span,
    /// Bit rate of the bus, bit/s.
    pub bitrate: f64,
    /// Share of the bus that the gateway may take, 0 to 1.
    pub share: f64,
    /// Most frames that may be sent at once after a quiet time, the stopping status among them.
    pub burst: u32,
}

impl OutboxLimits {
    /// Most warnings that wait: two for each that can stand, as where one is raised and cleared
    /// before the first could be sent.
    pub const WAITING: usize = 2 * MOST_STANDING;

    /// Most frames that may be sent at once: every warning that can stand, the estimates of two
    /// cycles, a status and the stopping status.
    pub const BURST: u32 = (MOST_STANDING + 2 * MAX_CYLINDERS + 1) as u32 + STOPPING_STATUS;
}

/// Frames reserved among those that may be sent at once: the status of a gateway that stops is sent
/// whatever went before it, and still keeps to the share.
const STOPPING_STATUS: u32 = 1;

/// Frames that emergency messages and heartbeats leave to statuses.
const STATUSES: u32 = 1;

/// Turn of frames that wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Turn {
    Status,
    Warnings,
    /// Emergency messages and heartbeats.
    Reports,
    /// Answers of the SDO server.
    Answers,
    Estimates,
}

/// Counts of what became of the frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OutboxCounts {
    pub sent: u64,
    /// Frames dropped for their age.
    pub too_old: u64,
    /// Frames dropped because too many waited.
    pub crowded_out: u64,
    /// Statuses that were replaced by a newer one.
    pub superseded: u64,
    /// Estimates that were replaced by newer ones.
    pub outdated: u64,
    /// Number of times that sending had to wait for the rate limit.
    pub held_back: u64,
}

/// Frames to be sent, in the order in which they came. The status has a place of its own, so that a
/// storm of warnings neither displaces it nor, once the rate limit holds frames back, delays it; a
/// newer status replaces one that still waits. Estimates come last, and leave the frames that may
/// be sent at once to the others, except for two cycles' worth. Nothing follows the stopping status
/// ([`Self::close`]).
///
/// The frames of the CANopen services come after warnings and statuses: first emergency messages
/// and heartbeats, whose number the gateway itself decides. Answers of the SDO server, for which
/// anybody may ask at any rate, leave as much to the others as estimates do, and take turns with
/// them.
#[derive(Clone, Debug)]
pub struct Outbox {
    limits: OutboxLimits,
    status: Option<OwnFrame>,
    warnings: VecDeque<OwnFrame>,
    /// Number of warnings that came before the waiting status.
    ahead: usize,
    estimates: VecDeque<OwnFrame>,
    services: Waiting,
    /// Whether the newest answer or estimate that was sent is an answer.
    answered: bool,
    /// Number of frames that may be sent now; fractions accrue with time.
    credit: f64,
    accrued: Option<Timestamp>,
    /// Whether the waiting status is the last of all frames.
    closing: bool,
    counts: OutboxCounts,
}

impl Outbox {
    /// An empty outbox.
    pub fn new(limits: OutboxLimits) -> Self {
        Self {
            limits,
            status: None,
            warnings: VecDeque::with_capacity(limits.waiting),
            ahead: 0,
            estimates: VecDeque::with_capacity(limits.estimates),
            services: Waiting::new(limits.waiting),
            answered: false,
            credit: f64::from(limits.burst),
            accrued: None,
            closing: false,
            counts: OutboxCounts::default(),
        }
    }

    pub const fn counts(&self) -> &OutboxCounts {
        &self.counts
    }

    /// Number of frames that wait.
    pub fn waiting(&self) -> usize {
        self.urgent() + self.services.len() + self.estimates.len()
    }

    fn urgent(&self) -> usize {
        self.warnings.len() + usize::from(self.status.is_some())
    }

    /// Takes a frame; its time stamp is the time at which it was made.
    pub fn put(&mut self, frame: OwnFrame) {
        if self.closing {
            return;
        }
        let message = match frame.content() {
            OwnContent::Service(service) => {
                let crowded_out = self.services.put(service, frame);
                self.counts.crowded_out += u64::from(crowded_out);
                return;
            }
            OwnContent::Message(message) => message,
        };
        match message.queue() {
            Queue::Status => {
                self.counts.superseded += u64::from(self.status.is_some());
                self.status = Some(frame);
                self.ahead = self.warnings.len();
            }
            Queue::Cyclic => {
                if self.estimates.len() >= self.limits.estimates {
                    self.counts.outdated += 1;
                    self.estimates.pop_front();
                }
                self.estimates.push_back(frame);
            }
            Queue::Events => {
                if self.warnings.len() >= self.limits.waiting {
                    self.take_warning();
                    self.counts.crowded_out += 1;
                }
                self.warnings.push_back(frame);
            }
        }
    }

    /// Takes the stopping status: waiting warnings still go before it where the rate limit allows
    /// it, and nothing follows it.
    pub fn close(&mut self, stopping_status: OwnFrame) {
        self.counts.outdated += self.estimates.len() as u64;
        self.estimates.clear();
        self.services.clear();
        self.put(stopping_status);
        self.closing = true;
    }

    /// Drops the waiting PDOs, because the node may send none.
    pub fn drop_pdos(&mut self) {
        self.status = None;
        self.warnings.clear();
        self.estimates.clear();
        self.ahead = 0;
    }

    /// The frame that may be sent at `now`, if any; [`Self::sent`] removes it.
    pub fn next(&mut self, now: Timestamp) -> Option<&OwnFrame> {
        self.accrue(now);
        self.drop_old(now);
        let turn = self.turn()?;
        if self.credit < 1.0 + self.reserve(turn) {
            self.counts.held_back += 1;
            return None;
        }
        match turn {
            Turn::Status => self.status.as_ref(),
            Turn::Warnings => self.warnings.front(),
            Turn::Reports => self.services.report(),
            Turn::Answers => self.services.answer(),
            Turn::Estimates => self.estimates.front(),
        }
    }

    /// The queue whose turn it is; `None` if nothing waits.
    fn turn(&self) -> Option<Turn> {
        let estimates = !self.estimates.is_empty();
        if self.urgent() > 0 {
            Some(if self.is_status_next() { Turn::Status } else { Turn::Warnings })
        } else if self.services.report().is_some() {
            Some(Turn::Reports)
        } else if self.services.answer().is_some() && !(estimates && self.answered) {
            Some(Turn::Answers)
        } else {
            estimates.then_some(Turn::Estimates)
        }
    }

    /// Number of frames that the queue leaves of those that may be sent at once.
    fn reserve(&self, turn: Turn) -> f64 {
        let stopping = f64::from(STOPPING_STATUS);
        match turn {
            Turn::Status if self.closing => 0.0,
            Turn::Status | Turn::Warnings => stopping,
            Turn::Reports => stopping + f64::from(STATUSES),
            Turn::Answers | Turn::Estimates => {
                let others = f64::from(self.limits.burst) - 2.0 * self.limits.estimates as f64;
                others.max(stopping)
            }
        }
    }

    /// Notes that the frame of the last [`Self::next`] was sent.
    pub fn sent(&mut self) {
        match self.turn() {
            Some(Turn::Status) => {
                self.status = None;
                if self.closing {
                    self.counts.crowded_out += self.warnings.len() as u64;
                    self.warnings.clear();
                }
            }
            Some(Turn::Warnings) => self.take_warning(),
            Some(Turn::Reports) => self.services.take_report(),
            Some(Turn::Answers) => {
                self.services.take_answer();
                self.answered = true;
            }
            Some(Turn::Estimates) | None => {
                self.estimates.pop_front();
                self.answered = false;
            }
        }
        self.credit -= 1.0;
        self.counts.sent += 1;
    }

    /// Drops everything that waits, because the bus was away.
    pub fn clear(&mut self) {
        self.counts.too_old += self.waiting() as u64;
        self.status = None;
        self.warnings.clear();
        self.estimates.clear();
        self.services.clear();
        self.ahead = 0;
    }

    fn is_status_next(&self) -> bool {
        let scarce = self.credit - f64::from(STOPPING_STATUS) < self.urgent() as f64;
        self.status.is_some() && (self.ahead == 0 || scarce)
    }

    fn take_warning(&mut self) {
        self.warnings.pop_front();
        self.ahead = self.ahead.saturating_sub(1);
    }

    fn accrue(&mut self, now: Timestamp) {
        let since = self.accrued.map_or(0.0, |accrued| now.since(accrued).as_seconds());
        let frames = since.max(0.0) * self.limits.bitrate * self.limits.share / FRAME_BITS;
        self.credit = (self.credit + frames).min(f64::from(self.limits.burst));
        self.accrued = Some(now);
    }

    fn drop_old(&mut self, now: Timestamp) {
        let age = self.limits.age;
        let old = |frame: &OwnFrame| now.since(frame.as_frame().timestamp) > age;
        // The stopping status stays true.
        if !self.closing && self.status.as_ref().is_some_and(old) {
            self.status = None;
            self.counts.too_old += 1;
        }
        // Frames come in the order of time, except after a clock was set.
        while self.warnings.front().is_some_and(old) {
            self.take_warning();
            self.counts.too_old += 1;
        }
        while self.estimates.front().is_some_and(old) {
            self.estimates.pop_front();
            self.counts.too_old += 1;
        }
        self.counts.too_old += self.services.drop_old(old);
    }
}

#[cfg(test)]
mod tests;
