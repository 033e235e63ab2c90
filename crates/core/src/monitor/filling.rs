//! The way of a page's signals to the inputs of cylinders, to the platform's state and to the attitudes.

use super::cylinder::Cylinder;
use super::page::Destination;
use super::sink::Sink;
use super::{Monitor, Place, tilt};
use crate::decode::Decoded;
use crate::frame::Frame;
use crate::sample::{Field, Pressure};
use crate::time::Timestamp;

/// What all cylinders share.
const SUPPLY: Field = Field::Pressure(Pressure::Supply);

impl Monitor {
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
                    counts.bad_signals += tilt::put(tilt.as_deref_mut(), which, value);
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
}

/// The cylinders that have a bit in `bits`.
#[inline]
fn of_bits(cylinders: &mut [Cylinder], bits: u8) -> impl Iterator<Item = &mut Cylinder> {
    let has = move |(index, _): &(usize, &mut Cylinder)| bits >> index & 1 != 0;
    cylinders.iter_mut().enumerate().filter(has).map(|(_, cylinder)| cylinder)
}
