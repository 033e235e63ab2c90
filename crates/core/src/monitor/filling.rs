//! From frames that were taken to the inputs of the cylinders, the platform's state and the attitudes: at once, or once the
//! cycle opens or closes that they are kept for.

use super::cylinder::Cylinder;
use super::page::{Destination, Station};
use super::{Monitor, Place, Sink, machine};
use crate::decode::Decoded;
use crate::frame::Frame;
use crate::sample::{Field, Inputs, Pressure, Transducer};
use crate::time::Timestamp;

/// What all cylinders share.
const SUPPLY: Field = Field::Pressure(Pressure::Supply);

impl Monitor {
    pub(super) fn take_page(
        &mut self,
        place: Place,
        now: Timestamp,
        frame: &Frame,
        sink: &mut impl Sink,
    ) {
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

    /// Notes that what the frames of a page carry cannot be relied on in the open cycle.
    #[cold]
    pub(super) fn doubt(&mut self, place: Place) {
        self.each_reading(place, |inputs, transducer| inputs.doubt(transducer));
    }

    /// Passes each transducer that a page carries a reading of to `act`, with the inputs of its cylinder.
    pub(super) fn each_reading(&mut self, place: Place, act: impl Fn(&mut Inputs, Transducer)) {
        let Self { stations, cylinders, .. } = self;
        for (bits, transducer) in stations[place.0].pages[place.1].transducers() {
            let own = |(index, _): &(usize, &mut Cylinder)| bits & 1 << index != 0;
            let cylinders = cylinders.iter_mut().enumerate().filter(own);
            cylinders.for_each(|(_, it)| act(&mut it.inputs, transducer));
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

    /// Accepts the frame that waits at `place` as that of the open cycle.
    pub(super) fn settle(&mut self, place: Place, now: Timestamp, sink: &mut impl Sink) {
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

    fn each_page(&mut self, mut act: impl FnMut(&mut Self, Place)) {
        for station in 0..self.stations.len() {
            for page in 0..self.stations[station].pages.len() {
                act(self, (station, page));
            }
        }
    }

    /// Forgets the arrivals, because the frames so far say nothing about the next ones.
    pub(super) fn forget_arrivals(&mut self) {
        self.keeps = false;
        self.stations.iter_mut().for_each(Station::forget);
    }
}

/// The cylinders that have a bit in `bits`.
#[inline]
fn of_bits(cylinders: &mut [Cylinder], bits: u8) -> impl Iterator<Item = &mut Cylinder> {
    let has = move |(index, _): &(usize, &mut Cylinder)| bits >> index & 1 != 0;
    cylinders.iter_mut().enumerate().filter(has).map(|(_, cylinder)| cylinder)
}
