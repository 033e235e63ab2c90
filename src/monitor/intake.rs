//! The short way of a frame's signals to the inputs of a cylinder.

use super::wiring::{Target, Wire};
use crate::decode::Plain;
use crate::frame::Frame;
use crate::sample::Inputs;

/// The signals of a message that all go to one cylinder and are all plain, as nearly every message of a
/// transducer or valve has them: which they are is settled once, and not asked of each frame.
#[derive(Clone, Debug)]
pub struct Intake {
    /// The index of the cylinder, from 0.
    cylinder: u8,
    /// Bytes that a payload must have to carry them all.
    needs: u8,
    taps: Box<[Tap]>,
}

/// A signal and where it goes: [`Inputs::count`]'s `place` and `bits`.
#[derive(Clone, Copy, Debug)]
struct Tap {
    signal: Plain,
    place: u8,
    bits: u16,
}

impl Intake {
    /// The short way of `wires`, the signals of one message; `None` if there is none.
    pub fn of(wires: &[Wire]) -> Option<Self> {
        let Target::Cylinder(cylinder, _) = wires.first()?.target else { return None };
        let tap = |wire: &Wire| match wire.target {
            Target::Cylinder(index, field) if index == cylinder => Some(Tap {
                signal: wire.plan.plain()?,
                place: field.place(),
                bits: Inputs::counted_bits(field),
            }),
            _ => None,
        };
        let taps = wires.iter().map(tap).collect::<Option<_>>()?;
        let needs = wires.iter().map(|wire| wire.plan.needed_length()).max()?;
        // At most the longest payload, which has 64 bytes.
        Some(Self { cylinder, needs: needs as u8, taps })
    }

    /// The index of the cylinder, from 0.
    #[inline]
    pub fn cylinder(&self) -> usize {
        usize::from(self.cylinder)
    }

    /// Puts the signals of a data frame into `inputs`; `false`, and nothing, if it is too short for all
    /// of them.
    #[inline(always)]
    pub fn fill(&self, frame: &Frame, inputs: &mut Inputs) -> bool {
        let whole = frame.length() >= usize::from(self.needs);
        if whole {
            for tap in &self.taps {
                let (count, number) = tap.signal.read(frame.buffer());
                inputs.count(tap.place, tap.bits, count, number);
            }
        }
        whole
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decode::{Database, Decoded};
    use crate::frame::{Id, Kind};
    use crate::sample::Field::{self, Command, Position, Status, Velocity};
    use crate::sample::Transducer::{C1, C2};
    use crate::time::Timestamp;

    const DBC: &str = "VERSION \"\"\nBU_: A\n\
        BO_ 1 Plain: 8 A\n\
        SG_ Position : 0|16@1+ (0.0001085,-1.5) [0|0] \"m\" A\n\
        SG_ Velocity : 31|12@0- (0.0001,0) [0|0] \"m/s\" A\n\
        SG_ Status : 40|5@1+ (1,0) [0|0] \"\" A\n\
        SG_ Counter : 55|16@0+ (1,0) [0|0] \"\" A\n\
        BO_ 2 Paged: 8 A\n\
        SG_ Page M : 0|8@1+ (1,0) [0|0] \"\" A\n\
        SG_ Asked m1 : 8|16@1+ (1,0) [0|0] \"m\" A\n\
        BO_ 3 Float: 8 A\n\
        SG_ Asked : 0|32@1- (1,0) [0|0] \"m\" A\n\
        BO_ 4 Huge: 8 A\n\
        SG_ Asked : 0|16@1- (1e308,0) [0|0] \"m\" A\n\
        BO_ 5 Wide: 12 A\n\
        SG_ Asked : 9|64@1+ (1,0) [0|0] \"m\" A\n\
        SIG_VALTYPE_ 3 Asked : 1;\n";

    fn wire(message: &str, signal: &str, target: Target) -> Wire {
        let database = Database::parse(DBC).expect("it is sound");
        let message = database.message(message).expect("it is there");
        Wire { plan: message.signal(signal).expect("it is there").plan.clone(), target }
    }

    fn to(field: Field) -> Target {
        Target::Cylinder(2, field)
    }

    /// What the signals of `frame` make of inputs, one by one.
    fn slowly(wires: &[Wire], frame: &Frame) -> Inputs {
        let mut inputs = Inputs::default();
        for wire in wires {
            let Decoded::Value(value) = wire.plan.decode(frame) else { panic!("{wire:?}") };
            let bits = value.raw.as_i128().expect("an integer") as u64;
            match wire.target {
                Target::Cylinder(_, Position(t)) => {
                    inputs.position(t, value.physical, value.raw.as_i64());
                }
                Target::Cylinder(_, Velocity(t)) => assert!(inputs.velocity(t, value.physical)),
                Target::Cylinder(_, Status(t)) => inputs.status(t, bits),
                Target::Cylinder(_, Command) => assert!(inputs.command(value.physical)),
                _ => panic!("{wire:?} is not asked for"),
            }
        }
        inputs
    }

    #[test]
    fn the_short_way_leads_where_the_long_one_does() {
        let wires = [
            wire("Plain", "Position", to(Position(C2))),
            wire("Plain", "Velocity", to(Velocity(C2))),
            wire("Plain", "Status", to(Status(C2))),
            wire("Plain", "Velocity", to(Command)),
        ];
        let intake = Intake::of(&wires).expect("all are plain");
        assert_eq!(intake.cylinder(), 2);
        let id = Id::standard(1).expect("11 bits");
        let mut state = 1_u64;
        for _ in 0..10_000 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let frame = Frame::new(Timestamp::default(), id, Kind::Data, &state.to_le_bytes());
            let (mut inputs, expected) = (Inputs::default(), slowly(&wires, &frame));
            assert!(intake.fill(&frame, &mut inputs));
            assert_eq!(inputs.got(), expected.got());
            assert_eq!(inputs.reading(C2, u16::MAX), expected.reading(C2, u16::MAX));
            assert_eq!(inputs.reading(C1, u16::MAX), None);
            assert_eq!(inputs.command_value(), expected.command_value());
        }
    }

    #[test]
    fn a_frame_that_is_too_short_leaves_no_trace() {
        let wires =
            [wire("Plain", "Position", to(Position(C1))), wire("Plain", "Counter", to(Status(C1)))];
        let intake = Intake::of(&wires).expect("both are plain");
        let id = Id::standard(1).expect("11 bits");
        for length in 0..=8 {
            let frame = Frame::new(Timestamp::default(), id, Kind::Data, &[7; 8][..length]);
            let mut inputs = Inputs::default();
            assert_eq!(intake.fill(&frame, &mut inputs), length == 8, "{length}");
            assert_eq!(inputs.got() != 0, length == 8, "{length}");
        }
    }

    #[test]
    fn what_has_to_be_asked_has_no_short_way() {
        for message in ["Paged", "Float", "Huge", "Wide"] {
            let position = wire(message, "Asked", to(Position(C1)));
            assert!(Intake::of(&[position]).is_none(), "{message}");
        }
        let elsewhere = Target::Cylinder(1, Position(C1));
        for target in [Target::State, elsewhere] {
            let wires =
                [wire("Plain", "Position", to(Position(C1))), wire("Plain", "Status", target)];
            assert!(Intake::of(&wires).is_none(), "{target:?}");
        }
        assert!(Intake::of(&[]).is_none());
    }
}
