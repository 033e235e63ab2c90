//! How time passes for a monitor: with the frames, in order, unless the clock behind them was set.

use super::sink::{Notice, Sink};
use super::{Monitor, STATUS_PERIOD};
use crate::observe::observer::Restart;
use crate::sample::cycle::Due;
use crate::time::{Span, Timestamp};

/// Time stamps that leap further ahead than this are a clock that was set, not a quiet bus.
pub(super) const LARGEST_PAUSE: Span = Span::from_nanos(3600 * 1_000_000_000);

/// A clock that says so much less than the newest frame was set back. Less is a guard that is kept
/// behind the frames.
pub(super) const SMALLEST_SETBACK: Span = Span::from_nanos(-1_000_000_000);

impl Monitor {
    /// Brings time to `stamp`, or says at which earlier or later time the frame is taken instead.
    #[inline]
    pub(super) fn follow_time(&mut self, stamp: Timestamp, sink: &mut impl Sink) -> Timestamp {
        let Some(last) = self.last else {
            self.begin(stamp);
            return stamp;
        };
        if stamp >= last && stamp <= self.next_due {
            self.last = Some(stamp);
            return stamp;
        }
        self.follow_irregular_time(last, stamp, sink)
    }

    #[cold]
    fn follow_irregular_time(
        &mut self,
        last: Timestamp,
        stamp: Timestamp,
        sink: &mut impl Sink,
    ) -> Timestamp {
        let step = stamp.since(last);
        if step < Span::ZERO {
            self.counts.backwards += 1;
            if step.as_nanos().saturating_neg() <= self.clock.sample_time().as_nanos() {
                // Out of order by less than a cycle: the order of arrival is believed.
                return last;
            }
        }
        if step < Span::ZERO || step > LARGEST_PAUSE {
            self.jump(stamp, step, sink);
        } else {
            self.do_due(stamp, sink);
            self.last = Some(stamp);
        }
        stamp
    }

    pub(super) fn begin(&mut self, at: Timestamp) {
        self.last = Some(at);
        self.next_status = at.after(STATUS_PERIOD);
        self.reckon_due();
    }

    pub(super) fn jump(&mut self, at: Timestamp, by: Span, sink: &mut impl Sink) {
        self.counts.time_jumps += 1;
        sink.notice(&Notice::TimeJump { at, by });
        self.start_anew(Restart::TimeJump);
        self.register.rephase(at);
        self.begin(at);
    }

    /// The bus was lost, so that frames may be missing without a trace: nothing is known until it
    /// was judged again. What was found stands.
    pub fn interrupt(&mut self, at: Timestamp, sink: &mut impl Sink) {
        let Some(last) = self.last else { return };
        self.counts.interruptions += 1;
        self.advance(at, sink);
        let at = at.max(last);
        sink.notice(&Notice::Interruption { at });
        self.start_anew(Restart::Interruption);
        self.reckon_due();
    }

    fn start_anew(&mut self, reason: Restart) {
        // What the open cycle still owes will not come any more.
        let owing = self.clock.is_open() && (self.incomplete || self.pending > 0);
        self.counts.incomplete += u64::from(owing);
        self.clock.reset();
        self.pending = 0;
        self.gate.reset();
        self.cylinders.iter_mut().for_each(|cylinder| cylinder.interrupt(reason));
    }

    pub(super) fn reckon_due(&mut self) {
        let cycle = self.clock.due().map(Due::at);
        let times = [cycle, self.register.due()].into_iter().flatten();
        self.next_due = times.fold(self.next_status, Timestamp::min);
    }

    /// Does everything that falls due before `now`, in the order of time.
    #[cold]
    pub(super) fn do_due(&mut self, now: Timestamp, sink: &mut impl Sink) {
        while self.next_due < now {
            let at = self.next_due;
            match self.clock.due() {
                Some(Due::Close(due)) if due == at => self.close_cycle(at, sink),
                Some(Due::Missing(due)) if due == at => self.miss_cycle(at, sink),
                _ if self.register.due() == Some(at) => self.repeat_warnings(at, sink),
                _ => self.send_status(at, sink),
            }
            self.reckon_due();
        }
    }
}
