//! The way of a frame: to the open cycle, once, or kept for its own. What devices send by themselves is taken aside: readings
//! by a timer of their own, emergency messages and heartbeats.

use super::page::{Page, Station, StationKind};
use super::subscriptions::DeviceService;
use super::{Monitor, Notice, Place, Sink};
use crate::error_frame::ErrorFrame;
use crate::frame::{Frame, Kind};
use crate::sample::Inputs;
use crate::sample::cycle::{Opener, When};
use crate::sample::device::DeviceState;
use crate::sample::dispute::Doubt;
use crate::sample::emergency::Emergency;
use crate::sample::fate::Fate;
use crate::time::Timestamp;

impl Monitor {
    /// Takes a frame from the bus. A frame whose time stamp is earlier than that of a previous
    /// frame, by less than a cycle, is taken now, but classified by its time stamp.
    // Of the loop that calls it, where there is more than one for a sink, too: a call costs 15 instructions a frame.
    #[inline(always)]
    pub fn take(&mut self, frame: &Frame, sink: &mut impl Sink) {
        let place = match frame.kind {
            Kind::Data | Kind::Fd { .. } => self.subscriptions.find(frame.bus, frame.id),
            Kind::Remote { .. } => None,
            Kind::Error => {
                self.counts.errors += 1;
                if ErrorFrame::read(frame).is_some_and(|error| error.is_bus_off()) {
                    self.interrupt_bus(frame.bus, frame.timestamp, sink);
                }
                None
            }
        };
        let Some(place) = place else {
            self.counts.ignored += 1;
            return;
        };
        self.counts.used += 1;
        let now = self.follow_time(frame.timestamp, sink);
        if !self.take_next(place, now, frame, sink) {
            self.sort(place, now, frame, sink);
        }
    }

    /// Takes any frame of the message at `place`.
    #[inline(never)]
    fn sort(&mut self, place: usize, now: Timestamp, frame: &Frame, sink: &mut impl Sink) {
        if self.take_unasked(place, now, frame, sink) {
            return;
        }
        if self.stations[place].is_sync() {
            self.synchronise(frame.timestamp, now, sink);
        }
        for index in 0..self.stations[place].pages.len() {
            let page = &self.stations[place].pages[index];
            match page.is_in(frame) {
                Some(true) if page.cyclic => self.admit((place, index), now, frame, sink),
                Some(true) => self.fill((place, index), now, frame, sink),
                Some(false) => {}
                None => self.counts.bad_signals += 1,
            }
        }
    }

    /// Takes a Sync with the time stamp `stamp`.
    fn synchronise(&mut self, stamp: Timestamp, now: Timestamp, sink: &mut impl Sink) {
        if !self.sync_watch.take(self.clock.number(), self.counts.used) {
            // The machine's own Sync cannot be told from the others: readings open the cycles until the flood ends.
            self.drop_set_aside();
            self.counts.repeated += 1;
            self.clock.lose_sync();
        } else if self.clock.confirms(stamp) {
            self.reckon_due();
        } else if self.clock.has_had_sync(stamp) {
            self.drop_set_aside();
            if self.has_readings() {
                self.clock.set_aside(stamp);
            } else {
                self.counts.repeated += 1;
            }
        } else {
            self.open_cycle(stamp, now, Opener::Sync, sink);
        }
    }

    /// Whether a reading of the newest cycle has come.
    fn has_readings(&self) -> bool {
        let number = self.clock.number();
        let mut pages = self.stations.iter().flat_map(|station| &station.pages);
        pages.any(|page| page.reading && page.slot.has(number))
    }

    /// Opens the next cycle if the reading in `frame` does: by the Sync before it that was taken for a repetition, or by
    /// itself, where its Sync is late or lost or none is configured.
    fn open_by_reading(
        &mut self,
        place: Place,
        now: Timestamp,
        frame: &Frame,
        count: Option<u64>,
        sink: &mut impl Sink,
    ) {
        let is_empty = !self.has_readings();
        let Self { stations, clock, .. } = self;
        let slot = &mut stations[place.0].pages[place.1].slot;
        let when = clock.when();
        if let (Some(sync), Some(when)) = (clock.sync_set_aside(), &when)
            && slot.follows(frame, count, when, sync)
        {
            clock.take_set_aside();
            return self.open_cycle(sync, now, Opener::Sync, sink);
        }
        let (has, kept) = (slot.has(clock.number()), slot.kept());
        let is_next = clock.is_opened_by_readings() && slot.is_next(count, clock.number());
        if is_next && has && clock.may_open_at_once()
            || clock.could_open(frame.timestamp, has)
                && when.is_none_or(|when| slot.may_open(frame, count, &when, is_empty))
        {
            self.counts.repeated += u64::from(kept != slot.kept());
            let opener = if is_next { Opener::NextReading } else { Opener::Reading };
            self.open_cycle(frame.timestamp, now, opener, sink);
        }
    }

    /// Takes a frame of the usual kind: the signals of one cylinder, and exactly the one that its
    /// place lacks in the open cycle. Returns `false`, and does nothing, if further checks are
    /// needed.
    #[inline(always)]
    fn take_next(
        &mut self,
        place: usize,
        now: Timestamp,
        frame: &Frame,
        sink: &mut impl Sink,
    ) -> bool {
        let Self { stations, clock, cylinders, .. } = self;
        let Station { kind: StationKind::Usual, pages } = &mut stations[place] else {
            return false;
        };
        let [Page { intake: Some(intake), slot, .. }] = &mut **pages else { return false };
        let (Some(word), Some(when)) = (intake.word(frame), clock.when()) else { return false };
        if slot.dispute.is_open(when.cycle) || !slot.take_next(frame, intake.counter(word), &when) {
            return false;
        }
        let index = intake.cylinder();
        let cylinder = &mut cylinders[index];
        intake.fill(word, &mut cylinder.inputs);
        self.heard.insert(frame.bus);
        if cylinder.pending && cylinder.is_done() {
            self.evaluate(index, now, sink);
        }
        true
    }

    /// Takes a page of `frame` if it belongs to its cycle.
    fn admit(&mut self, place: Place, now: Timestamp, frame: &Frame, sink: &mut impl Sink) {
        self.heard.insert(frame.bus);
        let station = &mut self.stations[place.0];
        let is_sync = station.is_sync();
        let page = &mut station.pages[place.1];
        if page.reading && page.is_too_short(frame) {
            return self.refuse_short(place, now, frame, sink);
        }
        let count = page.count(frame, &mut self.counts.bad_signals);
        if page.reading && !is_sync {
            self.open_by_reading(place, now, frame, count, sink);
        }
        let Some(when) = self.clock.when() else {
            self.counts.late += 1;
            if self.clock.wait(now) {
                self.reckon_due();
            }
            return;
        };
        let page = &mut self.stations[place.0].pages[place.1];
        match page.slot.judge(frame, count, &when) {
            Fate::Taken => self.take_page(place, now, frame, sink),
            Fate::Replaces => {
                self.counts.late += 1;
                self.take_page(place, now, frame, sink);
            }
            Fate::Settles => {
                self.counts.late += 1;
                self.settle(place, now, sink);
            }
            fate @ (Fate::Waits | Fate::Held) => {
                if fate == Fate::Held {
                    self.settle(place, now, sink);
                }
                self.keep(place, fate, frame, count, &when);
            }
            Fate::Repeated => self.counts.repeated += 1,
            Fate::Contradicts => {
                self.counts.contradicting += 1;
                self.each_reading(place, Inputs::contradict);
            }
            Fate::Late => {
                self.counts.late += 1;
                self.refuse(place);
            }
            // The counter's own tally has it.
            Fate::Jumped => self.refuse(place),
        }
        self.report_doubt(place, now, frame, sink);
    }

    /// Leaves out a frame that is too short for what is configured of its page.
    #[cold]
    fn refuse_short(&mut self, place: Place, now: Timestamp, frame: &Frame, sink: &mut impl Sink) {
        let cycle = self.clock.number();
        self.counts.short += 1;
        self.stations[place.0].pages[place.1].slot.dispute.doubt(Doubt::TooShort, cycle);
        self.doubt(place);
        self.report_doubt(place, now, frame, sink);
    }

    /// Reports that the frames of a page, of which `frame` is one, are in doubt now, or are no longer.
    fn report_doubt(&mut self, place: Place, now: Timestamp, frame: &Frame, sink: &mut impl Sink) {
        let cycle = self.clock.number();
        let dispute = &mut self.stations[place.0].pages[place.1].slot.dispute;
        if !dispute.is_open(cycle) {
            return;
        }
        while let Some((doubt, is_over)) = dispute.take_news(cycle) {
            sink.notice(&Notice::Doubt { at: now, id: frame.id, bus: frame.bus, doubt, is_over });
        }
    }

    /// Keeps `frame` until its cycle opens, or closes.
    fn keep(&mut self, place: Place, fate: Fate, frame: &Frame, count: Option<u64>, when: &When) {
        let slot = &mut self.stations[place.0].pages[place.1].slot;
        // What was kept gives way to what is newer.
        match slot.kept() {
            Some(cycle) if cycle == when.cycle => self.counts.late += 1,
            Some(_) => self.counts.repeated += 1,
            None => {}
        }
        slot.keep(fate, frame, count, when);
        self.keeps = true;
    }

    /// Notes that a frame came whose readings are not those of the open cycle.
    #[cold]
    fn refuse(&mut self, place: Place) {
        self.each_reading(place, |inputs, transducer| inputs.refuse(transducer));
    }

    /// Takes a frame at `place` that a device has sent by itself; returns whether it was one. A reading waits
    /// for the next Sync. An error of a device is warned of at once; all else has its effect in the next
    /// cycle, so that no flood of frames is one of warnings or notices.
    fn take_unasked(
        &mut self,
        place: usize,
        now: Timestamp,
        frame: &Frame,
        sink: &mut impl Sink,
    ) -> bool {
        let service = match &mut self.stations[place].kind {
            StationKind::Usual | StationKind::Sync => return false,
            StationKind::Timed(newest) => {
                self.heard.insert(frame.bus);
                newest.keep(frame);
                return true;
            }
            StationKind::Service(service) => service,
        };
        match service.service {
            DeviceService::Heartbeat => match DeviceState::read(frame.data()) {
                Some(state) => {
                    for (index, role) in &service.devices {
                        self.cylinders[usize::from(*index)].readings.take_heartbeat(*role, state);
                    }
                }
                None => self.counts.bad_signals += 1,
            },
            DeviceService::Emergency => match Emergency::read(frame.data()) {
                Some(emergency) => self.take_emergency(place, now, emergency, sink),
                None => self.counts.bad_signals += 1,
            },
        }
        true
    }

    fn take_emergency(
        &mut self,
        place: usize,
        now: Timestamp,
        emergency: Emergency,
        sink: &mut impl Sink,
    ) {
        let mut next = 0;
        while let StationKind::Service(service) = &self.stations[place].kind
            && let Some(&(index, role)) = service.devices.get(next)
        {
            next += 1;
            let index = usize::from(index);
            if self.cylinders[index].readings.take_emergency(role, now, emergency) {
                self.warn(index, now, sink);
            }
        }
    }
}
