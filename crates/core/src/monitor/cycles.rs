//! The cycles of a monitor: how one opens, closes, or does not come.

use super::cylinder::Cylinder;
use super::{Monitor, Notice, Sink};
use crate::sample::cycle::Opener;
use crate::time::{Span, Timestamp};

impl Monitor {
    /// Opens a cycle with a frame of the kind `opener` that has the time stamp `stamp`.
    pub(super) fn open_cycle(
        &mut self,
        stamp: Timestamp,
        now: Timestamp,
        opener: Opener,
        sink: &mut impl Sink,
    ) {
        if self.clock.is_open() {
            self.close_cycle(now, sink);
        }
        self.drop_set_aside();
        for _ in 0..self.clock.missing_before(stamp, opener) {
            self.miss_cycle(now, sink);
        }
        if self.missing_run > self.gap_cycles {
            let sample_time = self.clock.sample_time().as_nanos();
            let length = Span::from_nanos(sample_time.saturating_mul(self.missing_run as i64));
            sink.notice(&Notice::Gap { at: now, length });
            self.tilt.iter_mut().for_each(|tilt| tilt.lose());
        }
        self.missing_run = 0;
        self.clock.open(stamp, opener);
        self.counts.cycles += 1;
        self.pending = self.cylinders.len();
        self.incomplete = false;
        self.cylinders.iter_mut().for_each(Cylinder::open);
        self.reckon_due();
        self.take_newest(stamp, now, sink);
        if self.keeps {
            self.take_held(now, sink);
        }
    }

    /// Opens a cycle with an early reading, where readings open cycles: the reading came before the
    /// previous cycle had closed.
    #[cold]
    pub(super) fn open_for_held(&mut self, now: Timestamp, sink: &mut impl Sink) {
        if !self.keeps || !self.clock.is_opened_by_readings() {
            return;
        }
        let number = self.clock.number();
        let pages = self.stations.iter().flat_map(|station| &station.pages);
        let readings = pages.filter(|page| page.reading);
        if let Some(stamp) = readings.filter_map(|page| page.slot.held_after(number)).min() {
            self.open_cycle(stamp, now, Opener::Reading, sink);
        }
    }

    /// Evaluates the cylinders that the open cycle has left.
    pub(super) fn close_cycle(&mut self, at: Timestamp, sink: &mut impl Sink) {
        if self.keeps {
            self.take_waiting(at, sink);
        }
        let lacks = |cylinder: &Cylinder| cylinder.pending && !cylinder.is_complete();
        self.incomplete |= self.pending > 0 && self.cylinders.iter().any(lacks);
        for index in 0..self.cylinders.len() {
            if self.pending > 0 && self.cylinders[index].pending {
                self.evaluate(index, at, sink);
            }
        }
        self.counts.incomplete += u64::from(self.incomplete);
        self.follow_sampling(at, sink);
        if self.has_process {
            self.follow_supply(at);
        }
        self.follow_tilt(at);
        self.report_machine(at, sink);
        self.clock.close();
        self.follow_silence(at, sink);
    }

    /// Handles a cycle that did not open: the observers predict over it.
    pub(super) fn miss_cycle(&mut self, at: Timestamp, sink: &mut impl Sink) {
        self.drop_set_aside();
        self.clock.skip(1);
        self.counts.missing += 1;
        self.missing_run += 1;
        self.lose_supply();
        // Beyond that the observers stand still and nothing is judged any more.
        if !self.heard.is_empty() || self.missing_run <= self.gap_cycles + 1 {
            for index in 0..self.cylinders.len() {
                self.evaluate(index, at, sink);
            }
        }
        self.report_machine(at, sink);
        self.follow_silence(at, sink);
    }

    /// Handles the cycle due at `at`, which did not open. Once nothing is predicted any more, a
    /// missing cycle changes nothing but its number, so all that are due before `now` are one step.
    pub(super) fn miss_cycles(&mut self, at: Timestamp, now: Timestamp, sink: &mut impl Sink) {
        if !self.heard.is_empty() || self.missing_run <= self.gap_cycles {
            return self.miss_cycle(at, sink);
        }
        let count = self.clock.missing_until(now);
        self.drop_set_aside();
        self.clock.skip(count);
        self.counts.missing += count;
        self.missing_run += count;
        self.lose_supply();
    }

    /// Takes the buses that were heard in a cycle that ends at `at`, and reports silence.
    fn follow_silence(&mut self, at: Timestamp, sink: &mut impl Sink) {
        let heard = core::mem::take(&mut self.heard);
        if let Some(silence) = &mut self.silence {
            silence.follow(heard, |bus, silent| sink.notice(&Notice::Silence { at, bus, silent }));
        }
    }

    /// Takes a Sync that was set aside for a repetition after all.
    #[inline]
    pub(super) fn drop_set_aside(&mut self) {
        self.counts.repeated += u64::from(self.clock.take_set_aside().is_some());
    }
}
