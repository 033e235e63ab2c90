//! Inputs of one cylinder within one cycle.

use crate::state::{choice, whole};

/// C1 or C2, as an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transducer {
    C1 = 0,
    C2 = 1,
}

choice! { Transducer { C1, C2 } }

impl Transducer {
    pub const ALL: [Self; 2] = [Self::C1, Self::C2];

    /// Names in files and reports, by the index.
    pub const NAMES: [&'static str; 2] = ["c1", "c2"];

    /// Names for people, by the index.
    pub const LABELS: [&'static str; 2] = ["C1", "C2"];

    pub const fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    pub const fn label(self) -> &'static str {
        Self::LABELS[self as usize]
    }
}

/// A pressure of a cylinder, as an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pressure {
    /// Pressure in the bottom chamber.
    Bottom = 0,
    /// Pressure in the rod chamber.
    Rod = 1,
    /// Load pressure P_L, where the machine sends it.
    Load = 2,
    /// Supply pressure P_S, the same for all cylinders.
    Supply = 3,
}

/// Inputs that a signal can fill.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    Position(Transducer),
    Velocity(Transducer),
    Status(Transducer),
    Counter(Transducer),
    Command,
    /// Pressure: read where a process detector, or a command that learns from a recording, needs it.
    Pressure(Pressure),
    /// Position of the main spool, likewise.
    Spool,
}

impl Field {
    /// Place of the field among the inputs of a cylinder.
    pub const fn place(self) -> u8 {
        match self {
            Self::Position(t) => 4 * t as u8,
            Self::Velocity(t) => 4 * t as u8 + 1,
            Self::Status(t) => 4 * t as u8 + 2,
            Self::Counter(t) => 4 * t as u8 + 3,
            Self::Command => 8,
            Self::Pressure(p) => 9 + p as u8,
            Self::Spool => 13,
        }
    }

    /// Bit of this field in [`Inputs::got`].
    pub const fn bit(self) -> u16 {
        // All bits are taken: another field takes a wider `got`. Without this its bit would be a coded position's.
        debug_assert!(self.place() < FIRST_CODED);
        1 << self.place()
    }

    /// Whether the field comes from a transducer.
    pub const fn is_reading(self) -> bool {
        self.transducer().is_some()
    }

    /// Transducer that the field comes from.
    pub const fn transducer(self) -> Option<Transducer> {
        match self {
            Self::Position(t) | Self::Velocity(t) | Self::Status(t) | Self::Counter(t) => Some(t),
            Self::Command | Self::Pressure(_) | Self::Spool => None,
        }
    }
}

/// One reading of one transducer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// Length l, m.
    pub position: f64,
    /// Raw code of the position, where it is an integer.
    pub code: Option<i64>,
    /// Velocity l̇, m/s.
    pub velocity: Option<f64>,
    pub status: Option<u64>,
}

/// Number of places, a power of two, so that a place needs no check.
const PLACES: usize = 16;

/// Beside the bits of the fields: the position of C1 or C2 came with a code.
const CODED: [u16; 2] = [1 << FIRST_CODED, 1 << (FIRST_CODED + 1)];

/// Place of the first of these bits.
const FIRST_CODED: u8 = 14;

/// Inputs that have arrived so far in the open cycle: by [`Field::place`], a count and a number.
/// Neither is valid without its bit in `got`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Inputs {
    got: u16,
    /// Whether a frame of C1, or of C2, came that belongs to no cycle that is still open.
    refused: [bool; 2],
    /// Whether frames of C1, or of C2, came that cannot be relied on.
    doubted: [bool; 2],
    counts: [i64; PLACES],
    numbers: [f64; PLACES],
}

whole! { Inputs { got, refused, doubted, counts, numbers } }

impl Inputs {
    /// Forgets everything, for the next cycle.
    pub fn clear(&mut self) {
        self.clear_except(0);
    }

    /// Forgets everything but the fields in `kept`.
    #[inline]
    pub fn clear_except(&mut self, kept: u16) {
        (self.got, self.refused, self.doubted) = (self.got & kept, [false; 2], [false; 2]);
    }

    /// The fields that have arrived, by [`Field::bit`].
    pub const fn got(&self) -> u16 {
        self.got
    }

    /// Bits that mark a field in [`Self::got`] that came as a count.
    pub const fn counted_bits(field: Field) -> u16 {
        match field {
            Field::Position(transducer) => field.bit() | CODED[transducer as usize],
            _ => field.bit(),
        }
    }

    /// Stores the count at `place` ([`Field::place`]) of a frame, and the finite number that it
    /// means. It is not valid before [`Self::came`].
    #[inline(always)]
    pub fn count(&mut self, place: u8, count: i64, number: f64) {
        let place = usize::from(place) % PLACES;
        self.counts[place] = count;
        self.numbers[place] = number;
    }

    /// Marks the fields of `bits`, all of their [`Self::counted_bits`], as arrived.
    #[inline(always)]
    pub fn came(&mut self, bits: u16) {
        self.got |= bits;
    }

    fn note(&mut self, field: Field, number: f64) {
        self.numbers[usize::from(field.place())] = number;
        self.got |= field.bit();
    }

    fn note_finite(&mut self, field: Field, number: f64) -> bool {
        let finite = number.is_finite();
        if finite {
            self.note(field, number);
        }
        finite
    }

    fn note_bits(&mut self, field: Field, bits: u64) {
        self.counts[usize::from(field.place())] = bits as i64;
        self.got |= field.bit();
    }

    /// Takes a position with its raw code.
    pub fn position(&mut self, transducer: Transducer, metres: f64, code: Option<i64>) {
        let field = Field::Position(transducer);
        self.note(field, metres);
        self.got &= !CODED[transducer as usize];
        if let Some(code) = code {
            self.counts[usize::from(field.place())] = code;
            self.got |= CODED[transducer as usize];
        }
    }

    /// Takes a velocity, m/s; one that is not finite is bad data.
    #[must_use]
    pub fn velocity(&mut self, transducer: Transducer, metres_per_second: f64) -> bool {
        self.note_finite(Field::Velocity(transducer), metres_per_second)
    }

    pub fn status(&mut self, transducer: Transducer, status: u64) {
        self.note_bits(Field::Status(transducer), status);
    }

    /// Notes that a frame of the transducer came that belongs to no cycle that is still open.
    pub const fn refuse(&mut self, transducer: Transducer) {
        self.refused[transducer as usize] = true;
    }

    /// See [`Self::refuse`].
    pub const fn is_refused(&self, transducer: Transducer) -> bool {
        self.refused[transducer as usize]
    }

    /// Notes that frames of the transducer contradict each other: none of them is its reading, not even the first.
    pub const fn contradict(&mut self, transducer: Transducer) {
        let reading = Field::Position(transducer).bit()
            | Field::Velocity(transducer).bit()
            | Field::Status(transducer).bit()
            | Field::Counter(transducer).bit();
        self.got &= !(reading | CODED[transducer as usize]);
        self.doubt(transducer);
    }

    /// Notes that a frame of the transducer came that cannot be relied on.
    pub const fn doubt(&mut self, transducer: Transducer) {
        self.doubted[transducer as usize] = true;
    }

    /// See [`Self::doubt`].
    pub const fn is_doubted(&self, transducer: Transducer) -> bool {
        self.doubted[transducer as usize]
    }

    /// Notes that the alive counter has confirmed the reading as new.
    pub fn counted(&mut self, transducer: Transducer) {
        self.got |= Field::Counter(transducer).bit();
    }

    /// Takes the command, m/s; one that is not finite is bad data.
    #[must_use]
    pub fn command(&mut self, metres_per_second: f64) -> bool {
        self.note_finite(Field::Command, metres_per_second)
    }

    /// Command u(k), m/s.
    pub fn command_value(&self) -> Option<f64> {
        self.number(Field::Command)
    }

    /// Takes the supply's pressure, bar, which is finite.
    #[inline]
    pub fn supply(&mut self, bar: f64) {
        self.note(Field::Pressure(Pressure::Supply), bar);
    }

    /// Takes a pressure, bar; one that is not finite is bad data.
    #[must_use]
    pub fn pressure(&mut self, pressure: Pressure, bar: f64) -> bool {
        self.note_finite(Field::Pressure(pressure), bar)
    }

    /// Takes a spool position, in its own unit; one that is not finite is bad data.
    #[must_use]
    pub fn spool(&mut self, position: f64) -> bool {
        self.note_finite(Field::Spool, position)
    }

    /// Supply pressure P_S, bar.
    pub fn supply_value(&self) -> Option<f64> {
        self.number(Field::Pressure(Pressure::Supply))
    }

    /// Spool position x_m, in its own unit.
    pub fn spool_value(&self) -> Option<f64> {
        self.number(Field::Spool)
    }

    /// Pressures of the cylinder, bar, by [`Pressure`].
    pub fn pressures(&self) -> [Option<f64>; 3] {
        [Pressure::Bottom, Pressure::Rod, Pressure::Load]
            .map(|which| self.number(Field::Pressure(which)))
    }

    #[inline]
    fn number(&self, field: Field) -> Option<f64> {
        (self.got & field.bit() != 0).then_some(self.numbers[usize::from(field.place())])
    }

    #[inline]
    fn bits(&self, field: Field) -> Option<u64> {
        (self.got & field.bit() != 0).then_some(self.counts[usize::from(field.place())] as u64)
    }

    /// The reading of `transducer`, if its position came, with every status and counter that
    /// `required` names: without them it is not known to be good.
    #[inline]
    pub fn reading(&self, transducer: Transducer, required: u16) -> Option<Reading> {
        let position = Field::Position(transducer);
        let vital =
            position.bit() | Field::Status(transducer).bit() | Field::Counter(transducer).bit();
        let wanted = (required & vital) | position.bit();
        let place = usize::from(position.place());
        let coded = self.got & CODED[transducer as usize] != 0;
        (self.got & wanted == wanted).then(|| Reading {
            position: self.numbers[place],
            code: coded.then_some(self.counts[place]),
            velocity: self.number(Field::Velocity(transducer)),
            status: self.bits(Field::Status(transducer)),
        })
    }
}
