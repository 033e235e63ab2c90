//! A signal compiled for reading from and writing to frames.

use super::field::{BitField, WordField};
use super::value::{Decoded, Inserted, Raw, Value};
use crate::frame::{Frame, Kind, MAX_DATA};
use alloc::boxed::Box;

/// How a field's bits represent a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberForm {
    /// An integer that fits an i64: it is converted to a double at half the cost of a u64.
    Integer,
    /// An unsigned integer of 64 bits.
    Unsigned64,
    Float32,
    Float64,
}

/// A multiplexor on the way to a signal, and the values that select the signal.
#[derive(Clone, Debug, PartialEq)]
pub struct MultiplexGate {
    /// Bits of the multiplexor.
    pub field: BitField,
    /// Numbers that select the signal, as ascending inclusive ranges.
    pub ranges: Box<[(u64, u64)]>,
}

impl MultiplexGate {
    fn selects(&self, payload: &[u8; MAX_DATA]) -> bool {
        // A negative number becomes a huge one: only a range of all numbers has it.
        let number = self.field.integer(payload) as u64;
        self.ranges.iter().any(|&(low, high)| (low..=high).contains(&number))
    }
}

/// A signal's place, type and scale, ready to read frames: without allocating, and for an integer
/// of up to eight bytes with one load, shift, mask, sign extension and multiply-add.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalPlan {
    factor: f64,
    offset: f64,
    field: BitField,
    form: NumberForm,
    /// Multiplexors, outermost first; empty where the signal is always present.
    gates: Box<[MultiplexGate]>,
}

/// A plain signal, as given by [`SignalPlan::plain`]: an integer that fits an i64, present in every
/// sufficiently long frame of its message, and always a finite number. It is read without further
/// checks from a word of eight bytes that its message's signals share.
#[derive(Clone, Copy, Debug)]
pub struct Plain {
    factor: f64,
    offset: f64,
    field: WordField,
}

impl Plain {
    /// The count as [`SignalPlan::decode`] gives it, where `word` has the first of the eight bytes
    /// lowest.
    #[inline(always)]
    pub fn count(&self, word: u64) -> i64 {
        self.field.integer(word)
    }

    /// The number that a count stands for.
    #[inline(always)]
    pub fn number(&self, count: i64) -> f64 {
        count as f64 * self.factor + self.offset
    }
}

impl SignalPlan {
    /// The signal in `field`, which a frame carries if each of `gates` selects it; its number is
    /// raw · `factor` + `offset`.
    pub fn new(
        field: BitField,
        form: NumberForm,
        factor: f64,
        offset: f64,
        gates: Box<[MultiplexGate]>,
    ) -> Self {
        Self { factor, offset, field, form, gates }
    }

    /// The signal as a plain one within the eight bytes that begin with byte `at`; `None` if it is
    /// not plain, or not within them.
    pub fn plain(&self, at: usize) -> Option<Plain> {
        let Self { factor, offset, field, form, .. } = *self;
        let largest = libm::ldexp(1.0, field.length() as i32) * factor.abs() + offset.abs();
        let plain = form == NumberForm::Integer && self.gates.is_empty() && largest.is_finite();
        Some(Plain { factor, offset, field: field.within(at).filter(|_| plain)? })
    }

    /// Reads the signal. The frame's identifier is not checked: it must be the message's.
    #[inline(always)]
    pub fn decode(&self, frame: &Frame) -> Decoded {
        if !matches!(frame.kind, Kind::Data | Kind::Fd { .. }) {
            return Decoded::Absent;
        }
        if !self.gates.is_empty()
            && let Err(outcome) = self.pass_gates(frame)
        {
            return outcome;
        }
        if frame.length() < self.field.needs() {
            return Decoded::Short;
        }
        Decoded::Value(self.read(frame.buffer()))
    }

    #[inline(never)]
    fn pass_gates(&self, frame: &Frame) -> Result<(), Decoded> {
        for gate in &self.gates {
            if frame.length() < gate.field.needs() {
                return Err(Decoded::Short);
            }
            if !gate.selects(frame.buffer()) {
                return Err(Decoded::Absent);
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn read(&self, payload: &[u8; MAX_DATA]) -> Value {
        if self.form != NumberForm::Integer {
            return self.read_uncommon(payload);
        }
        let integer = self.field.integer(payload);
        let signed = self.field.is_signed();
        let raw = if signed { Raw::Signed(integer) } else { Raw::Unsigned(integer as u64) };
        Value { raw, physical: self.scale(integer as f64) }
    }

    #[inline(never)]
    fn read_uncommon(&self, payload: &[u8; MAX_DATA]) -> Value {
        let bits = self.field.bits(payload);
        let raw = match self.form {
            NumberForm::Integer | NumberForm::Unsigned64 => Raw::Unsigned(bits),
            NumberForm::Float32 => Raw::Float(f64::from(f32::from_bits(bits as u32))),
            NumberForm::Float64 => Raw::Float(f64::from_bits(bits)),
        };
        Value { raw, physical: self.physical(raw) }
    }

    #[inline]
    fn scale(&self, number: f64) -> f64 {
        number * self.factor + self.offset
    }

    /// Physical value raw · factor + offset, rounded twice as in cantools and elsewhere.
    #[inline]
    pub fn physical(&self, raw: Raw) -> f64 {
        self.scale(raw.as_f64())
    }

    /// The raw number, not yet rounded, that stands for `physical`.
    pub fn unscaled(&self, physical: f64) -> f64 {
        (physical - self.offset) / self.factor
    }

    /// Puts `raw` into a payload and changes no other bit; multiplexors stay as they are. An
    /// integer signal takes a float's nearest integer (ties to even), a float signal an integer's
    /// nearest double.
    pub fn insert(&self, raw: Raw, payload: &mut [u8; MAX_DATA]) -> Inserted {
        match self.form {
            NumberForm::Integer | NumberForm::Unsigned64 => self.insert_integer(raw, payload),
            NumberForm::Float64 => {
                self.field.set_bits(raw.as_f64().to_bits(), payload);
                Inserted::Whole
            }
            NumberForm::Float32 => self.insert_float32(raw.as_f64(), payload),
        }
    }

    /// Puts the raw number nearest to `physical` into a payload; otherwise like [`Self::insert`].
    pub fn insert_physical(&self, physical: f64, payload: &mut [u8; MAX_DATA]) -> Inserted {
        self.insert(Raw::Float(self.unscaled(physical)), payload)
    }

    fn insert_integer(&self, raw: Raw, payload: &mut [u8; MAX_DATA]) -> Inserted {
        let wanted = match raw {
            Raw::Float(float) if float.is_nan() => return Inserted::NotANumber,
            // Saturates far beyond 64 bits.
            Raw::Float(float) => libm::rint(float) as i128,
            Raw::Unsigned(number) => i128::from(number),
            Raw::Signed(number) => i128::from(number),
        };
        let (lowest, highest) = self.raw_limits_of_field();
        let number = wanted.clamp(lowest, highest);
        self.field.set_bits(number as u64, payload);
        match (number == wanted, self.field.is_signed()) {
            (true, _) => Inserted::Whole,
            (false, true) => Inserted::Clamped(Raw::Signed(number as i64)),
            (false, false) => Inserted::Clamped(Raw::Unsigned(number as u64)),
        }
    }

    fn insert_float32(&self, wanted: f64, payload: &mut [u8; MAX_DATA]) -> Inserted {
        let mut float = wanted as f32;
        let clamped = float.is_infinite() && wanted.is_finite();
        if clamped {
            float = f32::MAX.copysign(float);
        }
        self.field.set_bits(u64::from(float.to_bits()), payload);
        if clamped { Inserted::Clamped(Raw::Float(f64::from(float))) } else { Inserted::Whole }
    }

    fn raw_limits_of_field(&self) -> (i128, i128) {
        let length = self.field.length();
        if self.field.is_signed() {
            (-(1 << (length - 1)), (1 << (length - 1)) - 1)
        } else {
            (0, (1 << length) - 1)
        }
    }

    /// Lowest and highest raw number that the bits can hold; `None` for a float.
    pub fn raw_limits(&self) -> Option<(i128, i128)> {
        (!self.is_float()).then(|| self.raw_limits_of_field())
    }

    /// The signal in another unit, in which its numbers are `times` / `per` as large.
    #[must_use]
    pub fn rescaled(self, times: f64, per: f64) -> Self {
        let [factor, offset] = [self.factor, self.offset].map(|it| it * times / per);
        Self { factor, offset, ..self }
    }

    pub fn factor(&self) -> f64 {
        self.factor
    }

    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// Width in bits.
    pub fn bits(&self) -> u32 {
        self.field.length()
    }

    pub fn is_float(&self) -> bool {
        matches!(self.form, NumberForm::Float32 | NumberForm::Float64)
    }

    /// Whether a multiplexor decides if a frame carries the signal.
    pub fn is_multiplexed(&self) -> bool {
        !self.gates.is_empty()
    }

    /// Whether the multiplexors of `frame` select the signal; `None` if the frame is too short to
    /// tell.
    pub fn is_carried_by(&self, frame: &Frame) -> Option<bool> {
        match self.pass_gates(frame) {
            Ok(()) => Some(true),
            Err(Decoded::Short) => None,
            Err(_) => Some(false),
        }
    }

    /// Whether every frame that carries `other`, a signal of the same message, carries this one, too.
    pub fn accompanies(&self, other: &Self) -> bool {
        let within = |inner: &MultiplexGate, outer: &MultiplexGate| {
            inner.field == outer.field
                && inner.ranges.iter().all(|&(from, to)| {
                    outer.ranges.iter().any(|&(low, high)| low <= from && to <= high)
                })
        };
        self.gates.iter().all(|outer| other.gates.iter().any(|inner| within(inner, outer)))
    }

    /// Whether the same frames carry both signals of one message.
    pub fn is_on_page_of(&self, other: &Self) -> bool {
        self.accompanies(other) && other.accompanies(self)
    }

    /// Length that a payload must have to carry the signal and its multiplexors, bytes.
    pub fn needed_length(&self) -> usize {
        self.gates.iter().map(|gate| gate.field.needs()).fold(self.field.needs(), usize::max)
    }
}
