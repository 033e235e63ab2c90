//! The way of a frame: to the open cycle, once, or kept for its own; then its signals to the inputs of the cylinders, to the
//! platform's state and to the attitudes. What devices send by themselves is taken aside: readings by a timer of their own,
//! emergency messages and heartbeats.

use super::cylinder::Cylinder;
use super::page::{Destination, Page, Station, StationKind};
use super::sink::{Notice, Sink};
use super::subscriptions::DeviceService;
use super::{Monitor, Place, machine};
use crate::decode::Decoded;
use crate::frame::Frame;
use crate::sample::cycle::{Opener, When};
use crate::sample::device::DeviceState;
use crate::sample::dispute::Doubt;
use crate::sample::emergency::Emergency;
use crate::sample::fate::Fate;
use crate::sample::{Field, Inputs, Pressure, Transducer};
use crate::time::Timestamp;

/// What all cylinders share.
const SUPPLY: Field = Field::Pressure(Pressure::Supply);

impl Monitor {
    /// Takes a Sync with the time stamp `stamp`.
    pub(super) fn synchronise(&mut self, stamp: Timestamp, now: Timestamp, sink: &mut impl Sink) {
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

    /// Takes a Sync that was set aside for a repetition after all.
    #[inline]
    pub(super) fn drop_set_aside(&mut self) {
        self.counts.repeated += u64::from(self.clock.take_set_aside().is_some());
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
    pub(super) fn take_next(
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
    pub(super) fn admit(
        &mut self,
        place: Place,
        now: Timestamp,
        frame: &Frame,
        sink: &mut impl Sink,
    ) {
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

    /// Notes that what the frames of a page carry cannot be relied on in the open cycle.
    #[cold]
    fn doubt(&mut self, place: Place) {
        self.each_reading(place, |inputs, transducer| inputs.doubt(transducer));
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

    /// Passes each transducer that a page carries a reading of to `act`, with the inputs of its cylinder.
    fn each_reading(&mut self, place: Place, act: impl Fn(&mut Inputs, Transducer)) {
        let Self { stations, cylinders, .. } = self;
        for (bits, transducer) in stations[place.0].pages[place.1].transducers() {
            let own = |(index, _): &(usize, &mut Cylinder)| bits & 1 << index != 0;
            let cylinders = cylinders.iter_mut().enumerate().filter(own);
            cylinders.for_each(|(_, it)| act(&mut it.inputs, transducer));
        }
    }

    fn take_page(&mut self, place: Place, now: Timestamp, frame: &Frame, sink: &mut impl Sink) {
        let Self { stations, cylinders, clock, .. } = self;
        let page = &stations[place.0].pages[place.1];
        if page.slot.dispute.is_unknown(clock.number()) {
            return self.doubt(place);
        }
        for (index, transducer) in &page.counted {
            cylinders[usize::from(*index)].inputs.counted(*transducer);
        }
        self.fill(place, now, frame, sink);
    }

    /// Accepts the frame that waits at `place` as that of the open cycle.
    fn settle(&mut self, place: Place, now: Timestamp, sink: &mut impl Sink) {
        let Some(when) = self.clock.when() else { return };
        let slot = &mut self.stations[place.0].pages[place.1].slot;
        if let Some(frame) = slot.settle(&when, false) {
            self.take_page(place, now, &frame, sink);
        }
    }

    /// Accepts the waiting frames, because the open cycle closes and nothing better has come.
    #[cold]
    pub(super) fn take_waiting(&mut self, now: Timestamp, sink: &mut impl Sink) {
        self.each_page(|monitor, place| monitor.settle(place, now, sink));
    }

    /// Takes the frames that came early for the cycle that has just opened, and counts frames for
    /// other cycles as late.
    #[cold]
    pub(super) fn take_held(&mut self, now: Timestamp, sink: &mut impl Sink) {
        let Some(when) = self.clock.when() else { return };
        self.keeps = false;
        self.each_page(|monitor, place| {
            let slot = &mut monitor.stations[place.0].pages[place.1].slot;
            if let Some(frame) = slot.settle(&when, true) {
                monitor.counts.held += 1;
                return monitor.take_page(place, now, &frame, sink);
            }
            match slot.kept() {
                Some(cycle) if cycle == when.cycle => monitor.keeps = true,
                Some(_) => {
                    slot.drop_kept();
                    monitor.counts.late += 1;
                }
                None => {}
            }
        });
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

    /// Takes the newest readings of the transducers that send by timers of their own, for the cycle that the
    /// Sync with the time stamp `opening` has just opened: they were sampled before it.
    pub(super) fn take_newest(&mut self, opening: Timestamp, now: Timestamp, sink: &mut impl Sink) {
        if !self.by_timers {
            return;
        }
        let sample_time = self.clock.sample_time();
        for index in 0..self.stations.len() {
            let Some(newest) = self.stations[index].newest() else { continue };
            let Some(frame) = newest.take(opening, sample_time) else { continue };
            for page in 0..self.stations[index].pages.len() {
                let place = &self.stations[index].pages[page];
                match place.is_in(&frame) {
                    Some(true) => {
                        // Counted where it is cut off; a timer's frames are not told apart by it.
                        place.count(&frame, &mut self.counts.bad_signals);
                        self.take_page((index, page), now, &frame, sink);
                    }
                    Some(false) => {}
                    None => self.counts.bad_signals += 1,
                }
            }
        }
    }

    /// Forgets the arrivals, because the frames so far say nothing about the next ones.
    pub(super) fn forget_arrivals(&mut self) {
        self.keeps = false;
        self.stations.iter_mut().for_each(Station::forget);
    }

    fn each_page(&mut self, mut act: impl FnMut(&mut Self, Place)) {
        for station in 0..self.stations.len() {
            for page in 0..self.stations[station].pages.len() {
                act(self, (station, page));
            }
        }
    }

    /// Decodes the signals of a page into their places, and evaluates the cylinders that are now
    /// complete.
    pub(super) fn fill(
        &mut self,
        page: Place,
        now: Timestamp,
        frame: &Frame,
        sink: &mut impl Sink,
    ) {
        let intake = self.stations[page.0].pages[page.1].intake.as_ref();
        let mut touched = match intake.and_then(|intake| Some((intake, intake.word(frame)?))) {
            Some((intake, word)) => {
                let index = intake.cylinder();
                intake.fill(word, &mut self.cylinders[index].inputs);
                1 << index
            }
            None => self.fill_each(page, now, frame),
        };
        while touched != 0 {
            let index = touched.trailing_zeros() as usize;
            touched &= touched - 1;
            if self.cylinders[index].pending && self.cylinders[index].is_done() {
                self.evaluate(index, now, sink);
            }
        }
    }

    /// Decodes one signal of a page after the other; returns a bit for each cylinder that took one.
    #[inline]
    fn fill_each(&mut self, page: Place, now: Timestamp, frame: &Frame) -> u8 {
        let Self { stations, cylinders, gate, tilt, counts, .. } = self;
        let page = &stations[page.0].pages[page.1];
        let mut touched = 0;
        for signal in &page.signals {
            let value = match signal.plan.decode(frame) {
                Decoded::Value(value) => value,
                Decoded::Absent => continue,
                Decoded::Short => {
                    counts.bad_signals += signal.destination.count();
                    continue;
                }
            };
            match signal.destination {
                Destination::State => match value.raw.number() {
                    Some(state) => gate.state(now, state),
                    None => counts.bad_signals += 1,
                },
                Destination::Inclination(which) => {
                    counts.bad_signals += machine::put_angle(tilt.as_deref_mut(), which, value);
                }
                Destination::Cylinders(bits, SUPPLY) if value.physical.is_finite() => {
                    touched |= bits;
                    for cylinder in of_bits(cylinders, bits) {
                        cylinder.inputs.supply(value.physical);
                    }
                }
                Destination::Cylinders(bits, field) => {
                    touched |= bits;
                    for cylinder in of_bits(cylinders, bits) {
                        counts.bad_signals += u64::from(!cylinder.put(field, value));
                    }
                }
            }
        }
        touched
    }

    /// Takes a frame at `place` that a device has sent by itself; returns whether it was one. A reading waits
    /// for the next Sync. An error of a device is warned of at once; all else has its effect in the next
    /// cycle, so that no flood of frames is one of warnings or notices.
    pub(super) fn take_unasked(
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

    /// Reports what the devices of the cylinder of `index` have sent that is no fault.
    #[inline(always)]
    pub(super) fn report_devices(&mut self, index: usize, at: Timestamp, sink: &mut impl Sink) {
        if !self.cylinders[index].readings.has_devices() {
            return;
        }
        let cylinder = index as u8 + 1;
        self.cylinders[index].readings.take_news(|role, node, news| {
            sink.notice(&Notice::Device { at, cylinder, role, node, news });
        });
    }
}

/// The cylinders that have a bit in `bits`.
#[inline]
fn of_bits(cylinders: &mut [Cylinder], bits: u8) -> impl Iterator<Item = &mut Cylinder> {
    let has = move |(index, _): &(usize, &mut Cylinder)| bits >> index & 1 != 0;
    cylinders.iter_mut().enumerate().filter(has).map(|(_, cylinder)| cylinder)
}
