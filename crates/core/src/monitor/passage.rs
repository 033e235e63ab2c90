//! Passage of time for a monitor: with the frames, in order, unless the clock behind them was set.

use super::Monitor;
use super::reporting::STATUS_PERIOD;
use super::sink::{Notice, Sink};
use super::subscriptions::{SubscribedSignal, Target};
use crate::frame::BusNumber;
use crate::observe::observer::Restart;
use crate::sample::cycle::Due;
use crate::time::{Span, Timestamp};

/// Largest forward leap of time stamps that counts as a quiet bus; a larger one means that the
/// clock was set.
const LARGEST_PAUSE: Span = Span::from_nanos(3600 * 1_000_000_000);

/// Smallest backward leap of the clock, from the newest frame, that counts as the clock being set.
/// A smaller one is the guard time behind the frames.
const SMALLEST_SETBACK: Span = Span::from_nanos(-1_000_000_000);

impl Monitor {
    /// Advances time to `now`; every frame before it must have been taken. A clock that was set
    /// back or far ahead is reported as a time jump, since on a quiet bus no frame would reveal it.
    pub fn advance(&mut self, now: Timestamp, sink: &mut impl Sink) {
        let Some(last) = self.last else { return };
        let step = now.since(last);
        if step < SMALLEST_SETBACK || step > LARGEST_PAUSE {
            return self.jump(now, step, sink);
        }
        if step <= Span::ZERO {
            return;
        }
        if self.next_due < now {
            self.do_due(now, sink);
        }
        self.last = Some(now);
    }

    /// Advances time to `stamp`, and returns the time at which a frame with it is taken: the newest
    /// time, if the frame is out of order.
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
                self.clock.step_back();
                // Out of order by less than a cycle: what is decided stays so.
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

    fn begin(&mut self, at: Timestamp) {
        self.last = Some(at);
        self.next_status = at.after(STATUS_PERIOD);
        self.reckon_due();
    }

    fn jump(&mut self, at: Timestamp, by: Span, sink: &mut impl Sink) {
        self.counts.time_jumps += 1;
        sink.notice(&Notice::TimeJump { at, by });
        // Its times are of the clock before.
        let last = self.last.unwrap_or(at);
        self.incidents.cut(last, |incident| sink.incident(incident));
        self.start_anew(Restart::TimeJump);
        self.register.rephase(at);
        self.begin(at);
    }

    /// Forgets the state after the bus was lost, because frames may be missing without a trace.
    /// Findings stand.
    pub fn interrupt(&mut self, at: Timestamp, sink: &mut impl Sink) {
        if self.last.is_none() {
            return;
        }
        self.counts.interruptions += 1;
        self.advance(at, sink);
        // Not before what was reported already; a clock that was set was reported, and counts anew.
        let at = self.last.map_or(at, |last| last.max(at));
        sink.notice(&Notice::Interruption { at, bus: None });
        self.incidents.cut(at, |incident| sink.incident(incident));
        self.start_anew(Restart::Interruption);
        self.reckon_due();
    }

    /// Forgets what was learnt by what `bus` carries after it was lost, because frames may be missing without a trace.
    /// What the other buses carry goes on. See [`Self::interrupt`].
    pub fn interrupt_bus(&mut self, bus: BusNumber, at: Timestamp, sink: &mut impl Sink) {
        if self.silence.is_none() {
            return self.interrupt(at, sink);
        }
        if self.last.is_none() {
            return;
        }
        self.counts.interruptions += 1;
        self.advance(at, sink);
        let at = self.last.map_or(at, |last| last.max(at));
        sink.notice(&Notice::Interruption { at, bus: Some(bus) });
        for (message, station) in self.subscriptions.all().iter().zip(&mut self.stations) {
            if message.bus != bus {
                continue;
            }
            station.forget();
            if message.signals.iter().any(|signal| signal.target == Target::State) {
                self.gate.reset();
            }
            let is_angle = |it: &SubscribedSignal| matches!(it.target, Target::Inclination(_));
            if let Some(tilt) = self.tilt.as_mut().filter(|_| message.signals.iter().any(is_angle))
            {
                tilt.forget();
            }
        }
        self.cylinders.iter_mut().for_each(|cylinder| cylinder.lose(bus));
        // Its pressure and the rods' lengths may have come by this bus.
        self.interrupt_supply();
    }

    fn start_anew(&mut self, reason: Restart) {
        // What the open cycle still owes will not come any more.
        let owing = self.clock.is_open() && (self.incomplete || self.pending > 0);
        self.counts.incomplete += u64::from(owing);
        self.drop_set_aside();
        self.clock.reset();
        self.sync_watch.reset();
        self.forget_arrivals();
        self.pending = 0;
        self.gate.reset();
        if let Some(tilt) = &mut self.tilt {
            tilt.forget();
        }
        self.interrupt_supply();
        let last = self.last.unwrap_or_default();
        self.cylinders.iter_mut().for_each(|cylinder| cylinder.interrupt(reason, last));
    }

    /// Does everything that falls due before `now`, in the order of time.
    #[cold]
    fn do_due(&mut self, now: Timestamp, sink: &mut impl Sink) {
        while self.next_due < now {
            let at = self.next_due;
            match self.clock.due() {
                Some(Due::Close(due)) if due == at => {
                    self.close_cycle(at, sink);
                    self.open_for_held(at, sink);
                }
                Some(Due::Missing(due)) if due == at => self.miss_cycles(at, now, sink),
                _ if self.register.due() == Some(at) => self.repeat_warnings(at, sink),
                _ => self.send_status(at, sink),
            }
            self.reckon_due();
        }
    }
    /// Closes the open cycle at its deadline, because no frame follows, and reports the incidents that are not
    /// over.
    pub fn finish(&mut self, sink: &mut impl Sink) {
        if let Some(Due::Close(at)) = self.clock.due() {
            self.close_cycle(at, sink);
        }
        self.drop_set_aside();
        if let Some(last) = self.last {
            self.incidents.finish(last, |incident| sink.incident(incident));
        }
    }
}
