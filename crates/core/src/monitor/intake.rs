//! A short path for a frame's signals to the inputs of a cylinder.

use super::subscriptions::{SubscribedSignal, Target};
use crate::decode::{Plain, SignalPlan};
use crate::frame::Frame;
use crate::sample::{Field, Inputs, Transducer};
use alloc::boxed::Box;

/// Length of a word, from which all signals are read, bytes.
const WORD: usize = 8;

/// Signals of a page that all go to one cylinder, are all plain and lie within eight bytes, as in
/// nearly every message of a transducer or valve. This is determined once, and not for each frame.
#[derive(Clone, Debug)]
pub struct Intake {
    /// Cylinder index, from 0.
    cylinder: u8,
    /// Byte at which the word begins.
    at: u8,
    /// Length that a payload must have to carry all signals, bytes.
    needs: u8,
    taps: Box<[Tap]>,
    /// Bits of all fields for [`Inputs::came`].
    bits: u16,
    /// Alive counter.
    counter: Option<Plain>,
}

/// A signal and its destination: [`Inputs::count`]'s `place`.
#[derive(Clone, Copy, Debug)]
struct Tap {
    signal: Plain,
    place: u8,
}

/// An alive counter, and the readings that it counts, by cylinder index.
#[derive(Clone, Copy, Debug)]
pub struct Counting<'a> {
    pub plan: &'a SignalPlan,
    pub counted: &'a [(u8, Transducer)],
}

impl Intake {
    /// The short path of `signals`, the signals of one page, and of its alive counter where it has
    /// one; `None` if there is no short path.
    pub fn of(signals: &[SubscribedSignal], counting: Option<Counting<'_>>) -> Option<Self> {
        let Target::Cylinder(cylinder, _) = signals.first()?.target else { return None };
        let counters = counting.iter().map(|counting| counting.plan);
        let plans = signals.iter().map(|signal| &signal.plan).chain(counters);
        let needs = plans.map(SignalPlan::needed_length).max()?;
        let at = needs.saturating_sub(WORD);
        let mut bits = 0;
        let mut tap = |signal: &SubscribedSignal| match signal.target {
            Target::Cylinder(index, field) if index == cylinder => {
                bits |= Inputs::counted_bits(field);
                Some(Tap { signal: signal.plan.plain(at)?, place: field.place() })
            }
            _ => None,
        };
        let taps = signals.iter().map(&mut tap).collect::<Option<_>>()?;
        let mut counter = None;
        if let Some(Counting { plan, counted }) = counting {
            counter = Some(plan.plain(at)?);
            for (index, transducer) in counted {
                bits |= Field::Counter(*transducer).bit();
                if *index != cylinder {
                    return None;
                }
            }
        }
        // At most the longest payload, which has 64 bytes.
        let [at, needs] = [at, needs].map(|bytes| bytes as u8);
        Some(Self { cylinder, at, needs, taps, bits, counter })
    }

    /// Cylinder index, from 0.
    #[inline]
    pub fn cylinder(&self) -> usize {
        usize::from(self.cylinder)
    }

    /// The word of a data frame that has all signals; `None` if it is too short for one of them.
    #[inline(always)]
    pub fn word(&self, frame: &Frame) -> Option<u64> {
        let bytes = frame.buffer().get(usize::from(self.at)..)?.first_chunk()?;
        (frame.length() >= usize::from(self.needs)).then_some(u64::from_le_bytes(*bytes))
    }

    /// The alive counter's value, where there is one.
    #[inline(always)]
    pub fn counter(&self, word: u64) -> Option<u64> {
        self.counter.as_ref().map(|counter| counter.count(word) as u64)
    }

    /// Stores the signals of a frame in `inputs`, and notes that their readings were counted.
    #[inline(always)]
    pub fn fill(&self, word: u64, inputs: &mut Inputs) {
        for tap in &self.taps {
            let count = tap.signal.count(word);
            inputs.count(tap.place, count, tap.signal.number(count));
        }
        inputs.came(self.bits);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decode::{BitField, Decoded, MultiplexGate, NumberForm};
    use crate::frame::{Id, Kind};
    use crate::sample::Field::{self, Command, Position, Status, Velocity};
    use crate::sample::Transducer::{C1, C2};
    use crate::time::Timestamp;

    fn field(start: u64, length: u64, motorola: bool, signed: bool) -> BitField {
        BitField::new(start, length, motorola, signed).expect("it is within a frame")
    }

    fn whole(field: BitField, factor: f64, offset: f64) -> SignalPlan {
        SignalPlan::new(field, NumberForm::Integer, factor, offset, Box::new([]))
    }

    /// The signals of a message whose signals are all plain.
    fn plain(signal: &str) -> SignalPlan {
        match signal {
            "Position" => whole(field(0, 16, false, false), 0.000_108_5, -1.5),
            "Velocity" => whole(field(31, 12, true, true), 0.0001, 0.0),
            "Status" => whole(field(40, 5, false, false), 1.0, 0.0),
            "Counter" => whole(field(55, 16, true, false), 1.0, 0.0),
            _ => panic!("{signal}"),
        }
    }

    /// A signal on a page of its message.
    fn paged() -> SignalPlan {
        let gate = MultiplexGate { field: field(0, 8, false, false), ranges: Box::new([(1, 1)]) };
        SignalPlan::new(field(8, 16, false, false), NumberForm::Integer, 1.0, 0.0, Box::new([gate]))
    }

    fn subscribed(signal: &str, target: Target) -> SubscribedSignal {
        SubscribedSignal { plan: plain(signal), target }
    }

    fn to(field: Field) -> Target {
        Target::Cylinder(2, field)
    }

    /// The inputs from the signals of `frame`, one by one.
    fn slowly(signals: &[SubscribedSignal], frame: &Frame) -> Inputs {
        let mut inputs = Inputs::default();
        for signal in signals {
            let Decoded::Value(value) = signal.plan.decode(frame) else { panic!("{signal:?}") };
            let bits = value.raw.as_i128().expect("an integer") as u64;
            match signal.target {
                Target::Cylinder(_, Position(t)) => {
                    inputs.position(t, value.physical, value.raw.as_i64());
                }
                Target::Cylinder(_, Velocity(t)) => assert!(inputs.velocity(t, value.physical)),
                Target::Cylinder(_, Status(t)) => inputs.status(t, bits),
                Target::Cylinder(_, Command) => assert!(inputs.command(value.physical)),
                _ => panic!("{signal:?} is not asked for"),
            }
        }
        inputs
    }

    #[test]
    fn the_short_way_leads_where_the_long_one_does() {
        let signals = [
            subscribed("Position", to(Position(C2))),
            subscribed("Velocity", to(Velocity(C2))),
            subscribed("Status", to(Status(C2))),
            subscribed("Velocity", to(Command)),
        ];
        let intake = Intake::of(&signals, None).expect("all are plain");
        assert_eq!(intake.cylinder(), 2);
        let id = Id::standard(1).expect("11 bits");
        let mut state = 1_u64;
        for _ in 0..10_000 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let frame = Frame::new(Timestamp::default(), id, Kind::Data, &state.to_le_bytes());
            let (mut inputs, expected) = (Inputs::default(), slowly(&signals, &frame));
            intake.fill(intake.word(&frame).expect("it is long enough"), &mut inputs);
            assert_eq!(inputs.got(), expected.got());
            assert_eq!(inputs.reading(C2, u16::MAX), expected.reading(C2, u16::MAX));
            assert_eq!(inputs.reading(C1, u16::MAX), None);
            assert_eq!(inputs.command_value(), expected.command_value());
        }
    }

    #[test]
    fn a_counter_is_read_and_told_of_the_readings_that_it_counts() {
        let signals = [subscribed("Position", to(Position(C1)))];
        let counter = subscribed("Counter", to(Field::Counter(C1)));
        let counting = |counted| Counting { plan: &counter.plan, counted };
        let intake = Intake::of(&signals, Some(counting(&[(2, C1)]))).expect("both are plain");
        let id = Id::standard(1).expect("11 bits");
        let frame =
            Frame::new(Timestamp::default(), id, Kind::Data, &[0, 0, 0, 0, 0, 0, 0x12, 0x34]);
        let word = intake.word(&frame).expect("it is long enough");
        assert_eq!(intake.counter(word), Some(0x1234));
        let mut inputs = Inputs::default();
        intake.fill(word, &mut inputs);
        assert!(inputs.reading(C1, Field::Counter(C1).bit()).is_some());
        // Of another cylinder, or of another page.
        assert!(Intake::of(&signals, Some(counting(&[(1, C1)]))).is_none());
        let paged = paged();
        let counting = Counting { plan: &paged, counted: &[(2, C1)] };
        assert!(Intake::of(&signals, Some(counting)).is_none());
    }

    #[test]
    fn a_frame_that_is_too_short_has_no_short_way() {
        let signals =
            [subscribed("Position", to(Position(C1))), subscribed("Counter", to(Status(C1)))];
        let intake = Intake::of(&signals, None).expect("both are plain");
        let id = Id::standard(1).expect("11 bits");
        for length in 0..=8 {
            let frame = Frame::new(Timestamp::default(), id, Kind::Data, &[7; 8][..length]);
            assert_eq!(intake.word(&frame).is_some(), length == 8, "{length}");
        }
    }

    #[test]
    fn what_has_to_be_asked_has_no_short_way() {
        let float =
            SignalPlan::new(field(0, 32, false, true), NumberForm::Float32, 1.0, 0.0, Box::new([]));
        let huge = whole(field(0, 16, false, true), 1e308, 0.0);
        let wide = whole(field(9, 64, false, false), 1.0, 0.0);
        for plan in [paged(), float, huge, wide] {
            let position = SubscribedSignal { plan, target: to(Position(C1)) };
            assert!(Intake::of(core::slice::from_ref(&position), None).is_none(), "{position:?}");
        }
        let elsewhere = Target::Cylinder(1, Position(C1));
        for target in [Target::State, elsewhere] {
            let signals = [subscribed("Position", to(Position(C1))), subscribed("Status", target)];
            assert!(Intake::of(&signals, None).is_none(), "{target:?}");
        }
        assert!(Intake::of(&[], None).is_none());
    }
}
