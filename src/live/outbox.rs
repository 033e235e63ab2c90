//! What waits to be sent: bounded in number, age and share of the bus.

use crate::alarm::OwnFrame;
use crate::alarm::frames::FRAME_BITS;
use crate::frame::Id;
use crate::time::{Span, Timestamp};
use std::collections::VecDeque;

/// What the outbox keeps to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Warnings that wait at most; the oldest gives way.
    pub waiting: usize,
    /// Estimates that wait at most, one for each cylinder; the oldest gives way.
    pub estimates: usize,
    /// An older frame is dropped, never sent late.
    pub age: Span,
    /// Bit rate of the bus, 1/s.
    pub bitrate: f64,
    /// The part of the bus that the gateway may take, 0 to 1.
    pub share: f64,
    /// So many frames may go out at once after a quiet time.
    pub burst: u32,
}

/// What became of the frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OutboxCounts {
    pub sent: u64,
    /// Dropped for their age.
    pub too_old: u64,
    /// Dropped because too many waited.
    pub crowded_out: u64,
    /// Statuses that a newer one took the place of.
    pub superseded: u64,
    /// Estimates that gave way to newer ones.
    pub outdated: u64,
    /// Times that sending had to wait for the rate limit.
    pub held_back: u64,
}

/// Frames on their way out, in the order in which they came to be. The status has a place of its own,
/// so that a storm of warnings neither displaces nor, once the rate limit holds frames back, delays
/// it; a newer one takes the place of one that still waits. Estimates come last of all, and leave what
/// may go out at once to the others, but for two cycles' worth.
#[derive(Clone, Debug)]
pub struct Outbox {
    limits: Limits,
    status_id: Id,
    status: Option<OwnFrame>,
    warnings: VecDeque<OwnFrame>,
    /// Warnings that came before the status that waits.
    ahead: usize,
    estimates: VecDeque<OwnFrame>,
    /// Frames that may go out now; fractions of one accrue with time.
    credit: f64,
    accrued: Option<Timestamp>,
    counts: OutboxCounts,
}

impl Outbox {
    /// An empty outbox; frames with the identifier `status_id` are statuses.
    pub fn new(limits: Limits, status_id: Id) -> Self {
        Self {
            limits,
            status_id,
            status: None,
            warnings: VecDeque::with_capacity(limits.waiting),
            ahead: 0,
            estimates: VecDeque::with_capacity(limits.estimates),
            credit: f64::from(limits.burst),
            accrued: None,
            counts: OutboxCounts::default(),
        }
    }

    pub const fn counts(&self) -> &OutboxCounts {
        &self.counts
    }

    /// Frames that wait.
    pub fn waiting(&self) -> usize {
        self.urgent() + self.estimates.len()
    }

    fn urgent(&self) -> usize {
        self.warnings.len() + usize::from(self.status.is_some())
    }

    /// Takes a frame; its time stamp is when it came to be.
    pub fn put(&mut self, frame: OwnFrame) {
        if frame.as_frame().id == self.status_id {
            self.counts.superseded += u64::from(self.status.is_some());
            self.status = Some(frame);
            self.ahead = self.warnings.len();
            return;
        }
        if frame.is_estimate() {
            if self.estimates.len() >= self.limits.estimates {
                self.counts.outdated += 1;
                self.estimates.pop_front();
            }
            self.estimates.push_back(frame);
            return;
        }
        if self.warnings.len() >= self.limits.waiting {
            self.take_warning();
            self.counts.crowded_out += 1;
        }
        self.warnings.push_back(frame);
    }

    /// The frame that may be sent at `now`, if any; [`Self::sent`] takes it out.
    pub fn next(&mut self, now: Timestamp) -> Option<&OwnFrame> {
        self.accrue(now);
        self.drop_old(now);
        let urgent = self.urgent() > 0;
        if !urgent && self.estimates.is_empty() {
            return None;
        }
        if self.credit < 1.0 + if urgent { 0.0 } else { self.reserve() } {
            self.counts.held_back += 1;
            return None;
        }
        match (urgent, self.is_status_next()) {
            (false, _) => self.estimates.front(),
            (true, true) => self.status.as_ref(),
            (true, false) => self.warnings.front(),
        }
    }

    /// What estimates leave of the frames that may go out at once.
    fn reserve(&self) -> f64 {
        (f64::from(self.limits.burst) - 2.0 * self.limits.estimates as f64).max(0.0)
    }

    /// The frame of the last [`Self::next`] went out.
    pub fn sent(&mut self) {
        if self.urgent() == 0 {
            self.estimates.pop_front();
        } else if self.is_status_next() {
            self.status = None;
        } else {
            self.take_warning();
        }
        self.credit -= 1.0;
        self.counts.sent += 1;
    }

    /// Forgets everything that waits: the bus was away.
    pub fn clear(&mut self) {
        self.counts.too_old += self.waiting() as u64;
        self.status = None;
        self.warnings.clear();
        self.estimates.clear();
        self.ahead = 0;
    }

    fn is_status_next(&self) -> bool {
        let scarce = self.credit < self.urgent() as f64;
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
        if self.status.as_ref().is_some_and(old) {
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
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alarm::status::Status;
    use crate::alarm::{Detector, Encoder, Finding, Level};
    use crate::verdict::{Fault, Suspect};

    const MS: i64 = 1_000_000;

    fn at(ms: i64) -> Timestamp {
        Timestamp::from_nanos(ms * MS)
    }

    fn limits() -> Limits {
        // 13,500 bits a second: 100 frames, one every 10 ms.
        Limits {
            waiting: 4,
            estimates: 6,
            age: Span::from_seconds(0.05),
            bitrate: 270_000.0,
            share: 0.05,
            burst: 2,
        }
    }

    fn encoder() -> Encoder {
        Encoder::new(81).expect("81 is a node")
    }

    fn outbox() -> Outbox {
        Outbox::new(limits(), Id::standard(0x1D1).expect("eleven bits"))
    }

    fn warning(encoder: &mut Encoder, ms: i64, cylinder: u8) -> OwnFrame {
        let finding = Finding {
            fault: Fault::Abrupt,
            suspect: Suspect::C1,
            level: Level::Yellow,
            residual: Some(0.0),
            threshold: Some(0.0),
            evidence: None,
        };
        encoder.warning(at(ms), cylinder, Detector::Fde1, &finding, true)
    }

    #[test]
    fn a_storm_keeps_to_its_share_of_the_bus() {
        let (mut outbox, mut encoder) = (outbox(), encoder());
        let mut sent = Vec::new();
        for ms in 0..2000 {
            outbox.put(warning(&mut encoder, ms, 1));
            while outbox.next(at(ms)).is_some() {
                outbox.sent();
                sent.push(ms);
            }
        }
        assert!(sent.len() <= 2 + 200 && sent.len() >= 199, "{}", sent.len());
        for (from, to) in sent.iter().zip(&sent[12..]) {
            assert!(to - from >= 99, "never more than the burst beyond 10 frames in 100 ms");
        }
        assert!(outbox.counts().crowded_out > 1700);
    }

    #[test]
    fn a_status_is_not_displaced_by_warnings() {
        let (mut outbox, mut encoder) = (outbox(), encoder());
        (0..9).for_each(|_| outbox.put(warning(&mut encoder, 0, 1)));
        outbox.put(encoder.status(at(0), &Status::default()));
        let first = outbox.next(at(0)).expect("there is credit").as_frame().id.value();
        assert_eq!(first, 0x1D1);
    }

    #[test]
    fn frames_go_out_in_the_order_in_which_they_came_to_be() {
        let mut encoder = encoder();
        let mut outbox = Outbox::new(Limits { burst: 9, ..limits() }, outbox().status_id);
        outbox.put(warning(&mut encoder, 0, 1));
        outbox.put(encoder.status(at(0), &Status::default()));
        outbox.put(warning(&mut encoder, 0, 2));
        let mut ids = Vec::new();
        while let Some(frame) = outbox.next(at(0)) {
            ids.push(frame.as_frame().id.value());
            outbox.sent();
        }
        assert_eq!(ids, [0x2D1, 0x1D1, 0x2D1]);
    }

    #[test]
    fn estimates_come_after_all_others_and_the_newest_of_each_cylinder_remain() {
        let mut encoder = encoder();
        let mut outbox = Outbox::new(Limits { burst: 9, ..limits() }, outbox().status_id);
        for cycle in 0..3 {
            for cylinder in 1..=6 {
                outbox.put(encoder.estimate(at(cycle * 20), cylinder, None));
            }
        }
        outbox.put(warning(&mut encoder, 40, 1));
        outbox.put(encoder.status(at(40), &Status::default()));
        let mut sent = Vec::new();
        while let Some(frame) = outbox.next(at(40)) {
            let frame = frame.as_frame();
            sent.push((frame.id.value(), frame.data()[2], frame.timestamp));
            outbox.sent();
        }
        let estimates = (12..18).map(|counter| (0x3D1, counter, at(40)));
        let expected = [(0x2D1, 0, at(40)), (0x1D1, 0, at(40))].into_iter().chain(estimates);
        assert!(sent.iter().copied().eq(expected), "{sent:?}");
        assert_eq!((outbox.counts().outdated, outbox.counts().superseded), (12, 0));
    }

    /// 300 estimates a second, and 100 frames that may go out.
    #[test]
    fn estimates_keep_to_the_share_and_leave_room_for_a_warning_at_any_time() {
        let (mut outbox, mut encoder) = (outbox(), encoder());
        outbox.limits = Limits { burst: 20, ..outbox.limits };
        let (mut estimates, mut warnings) = (0, 0);
        for ms in 0..2000 {
            if ms % 20 == 0 {
                (1..=6).for_each(|n| outbox.put(encoder.estimate(at(ms), n, None)));
            }
            let warns = ms % 500 == 499;
            if warns {
                (0..4).for_each(|_| outbox.put(warning(&mut encoder, ms, 1)));
            }
            let before = warnings;
            while let Some(frame) = outbox.next(at(ms)) {
                (estimates, warnings) = match frame.is_estimate() {
                    true => (estimates + 1, warnings),
                    false => (estimates, warnings + 1),
                };
                outbox.sent();
            }
            assert_eq!(warnings - before, if warns { 4 } else { 0 }, "at once, at {ms}");
        }
        assert!((190..=200 + 20).contains(&(estimates + warnings)), "{estimates} {warnings}");
    }

    #[test]
    fn what_is_too_old_is_never_sent() {
        let (mut outbox, mut encoder) = (outbox(), encoder());
        outbox.put(warning(&mut encoder, 0, 1));
        outbox.put(encoder.status(at(0), &Status::default()));
        outbox.put(warning(&mut encoder, 30, 2));
        let next = outbox.next(at(51)).expect("the newest is young enough");
        assert_eq!(next.as_frame().timestamp, at(30));
        assert_eq!(outbox.counts().too_old, 2);
        assert!(outbox.next(at(81)).is_none());
    }

    #[test]
    fn a_clock_that_was_set_back_gives_no_credit() {
        let (mut outbox, mut encoder) = (outbox(), encoder());
        let mut send = |outbox: &mut Outbox, ms| {
            outbox.put(warning(&mut encoder, ms, 1));
            let may = outbox.next(at(ms)).is_some();
            if may {
                outbox.sent();
            }
            may
        };
        assert!(send(&mut outbox, 1_000_000));
        assert!(send(&mut outbox, 1_000_000));
        for _ in 0..100 {
            assert!(!send(&mut outbox, 5), "the burst is used up");
        }
        assert!(send(&mut outbox, 15), "and it goes on from the new time");
    }
}
