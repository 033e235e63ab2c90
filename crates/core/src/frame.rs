//! A CAN frame with the time at which it was on the bus.

mod bus;
mod driver;

pub use bus::{BusNumber, Buses};

use crate::state::{
    StateError, StateReader, StateWriter, Stateful, Whole, shape_of_both, shape_of_name,
};
use crate::time::Timestamp;

/// Length of the longest payload, CAN FD's, bytes.
pub const MAX_DATA: usize = 64;

/// Length of the longest payload of a classic frame, bytes.
const CLASSIC_DATA: usize = 8;

/// A CAN identifier, which cannot be out of range; standard and extended identifiers are never
/// equal.
///
/// It is stored with bit 31 set for the extended format, as in a DBC file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Id(u32);

impl Id {
    const EXTENDED: u32 = 1 << 31;
    pub const STANDARD_MAX: u32 = 0x7FF;
    pub const EXTENDED_MAX: u32 = 0x1FFF_FFFF;

    /// An 11-bit identifier; `None` above 0x7FF.
    pub const fn standard(id: u32) -> Option<Self> {
        if id <= Self::STANDARD_MAX { Some(Self(id)) } else { None }
    }

    /// A 29-bit identifier; `None` above 0x1FFF_FFFF.
    pub const fn extended(id: u32) -> Option<Self> {
        if id <= Self::EXTENDED_MAX { Some(Self(id | Self::EXTENDED)) } else { None }
    }

    pub const fn is_extended(self) -> bool {
        self.0 & Self::EXTENDED != 0
    }

    /// The identifier's 11 or 29 bits, without the format flag.
    pub const fn value(self) -> u32 {
        self.0 & !Self::EXTENDED
    }

    /// The bits as a DBC file writes them: bit 31 set for the extended format.
    pub const fn to_dbc(self) -> u32 {
        self.0
    }
}

impl core::fmt::Display for Id {
    /// Writes the identifier as candump does: three hexadecimal digits, or eight for the extended
    /// format.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        if self.is_extended() {
            write!(f, "{:08X}", self.value())
        } else {
            write!(f, "{:03X}", self.value())
        }
    }
}

/// Kind of a frame. Only `Data` and `Fd` carry signals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A classic data frame.
    Data,
    /// A CAN FD data frame; `flags` as in candump's `##` (1 bit-rate switch, 2 error state).
    Fd { flags: u8 },
    /// A classic remote frame; its length is the requested one, its payload is empty.
    Remote { length: u8 },
    /// A controller's error message; the identifier holds the error class.
    Error,
}

/// A time-stamped frame. Bytes beyond the payload's length are unspecified and never read as data.
#[derive(Clone, Debug)]
pub struct Frame {
    pub timestamp: Timestamp,
    /// Bus of the machine on which it was; the first one, unless the source of the frame knows another.
    pub bus: BusNumber,
    pub id: Id,
    pub kind: Kind,
    length: u8,
    bytes: [u8; MAX_DATA],
}

impl Frame {
    /// A frame with `data` as payload.
    ///
    /// # Panics
    /// `data` is longer than [`MAX_DATA`]: a bug of the caller, not bad input.
    pub fn new(timestamp: Timestamp, id: Id, kind: Kind, data: &[u8]) -> Self {
        let mut bytes = [0; MAX_DATA];
        bytes[..data.len()].copy_from_slice(data);
        Self { timestamp, bus: BusNumber::First, id, kind, length: data.len() as u8, bytes }
    }

    /// This frame, as one of `bus`.
    pub const fn on(mut self, bus: BusNumber) -> Self {
        self.bus = bus;
        self
    }

    /// The payload.
    pub fn data(&self) -> &[u8] {
        &self.bytes[..usize::from(self.length)]
    }

    /// The payload's length in bytes.
    pub fn length(&self) -> usize {
        usize::from(self.length)
    }

    /// The payload as one word, its first byte lowest and zeros above; `None` if it is longer than eight
    /// bytes.
    #[inline]
    pub fn word(&self) -> Option<u64> {
        let bits = 8 * u32::from(self.length);
        let word = self.bytes.first_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes));
        (bits <= u64::BITS).then(|| word & !u64::MAX.checked_shl(bits).unwrap_or(0))
    }

    /// A digest of the payload: that of payloads which differ is another one, but for one chance in 2⁶⁴ where they are longer than
    /// eight bytes.
    #[inline(always)]
    pub fn digest(&self) -> u64 {
        self.word().unwrap_or_else(|| self.digest_of_many())
    }

    #[cold]
    fn digest_of_many(&self) -> u64 {
        let mut words = self.data().chunks(8).map(|chunk| {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            u64::from_le_bytes(word)
        });
        let first = words.next().unwrap_or_default();
        // A prime keeps words from cancelling each other.
        words.fold(first, |all, word| all.wrapping_mul(0x0100_0000_01B3) ^ word)
    }

    /// The whole buffer, so that a decoder can load eight bytes at once; its content beyond
    /// [`Self::length`] is unspecified.
    pub fn buffer(&self) -> &[u8; MAX_DATA] {
        &self.bytes
    }

    /// The whole buffer for a reader that fills frames in place.
    pub fn buffer_mut(&mut self) -> &mut [u8; MAX_DATA] {
        &mut self.bytes
    }

    /// Sets the payload's length after [`Self::buffer_mut`] was filled.
    ///
    /// # Panics
    /// `length` exceeds [`MAX_DATA`].
    pub fn set_length(&mut self, length: usize) {
        assert!(length <= MAX_DATA, "a frame holds at most {MAX_DATA} bytes");
        self.length = length as u8;
    }
}

impl Stateful for Id {
    const SHAPE: u64 = shape_of_name("Id");

    fn save(&self, into: &mut StateWriter) {
        self.0.save(into);
    }

    fn resume(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        *self = Self::read(from)?;
        Ok(())
    }
}

impl Whole for Id {
    fn read(from: &mut StateReader<'_>) -> Result<Self, StateError> {
        let number = u32::read(from)?;
        let id = match number & Self::EXTENDED {
            0 => Self::standard(number),
            _ => Self::extended(number & !Self::EXTENDED),
        };
        id.ok_or(StateError::Unsound { what: "identifier" })
    }
}

impl Stateful for Frame {
    const SHAPE: u64 =
        shape_of_both(shape_of_both(shape_of_name("Frame"), BusNumber::SHAPE), MAX_DATA as u64);

    fn save(&self, into: &mut StateWriter) {
        let Self { timestamp, bus, id, kind, length, bytes: _ } = self;
        timestamp.save(into);
        bus.save(into);
        id.save(into);
        into.put(match kind {
            Kind::Data => [0, 0],
            Kind::Fd { flags } => [1, *flags],
            Kind::Remote { length } => [2, *length],
            Kind::Error => [3, 0],
        });
        length.save(into);
        // What lies behind the payload is whatever the reader of the frame left there.
        let mut bytes = [0; MAX_DATA];
        bytes[..self.length()].copy_from_slice(self.data());
        bytes.save(into);
    }

    fn resume(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        *self = Self::read(from)?;
        Ok(())
    }
}

impl Whole for Frame {
    fn read(from: &mut StateReader<'_>) -> Result<Self, StateError> {
        let (timestamp, bus) = (Timestamp::read(from)?, BusNumber::read(from)?);
        let id = Id::read(from)?;
        let kind = match from.take()? {
            [0, 0] => Kind::Data,
            [1, flags] => Kind::Fd { flags },
            [2, length] => Kind::Remote { length },
            [3, 0] => Kind::Error,
            _ => return Err(StateError::Unsound { what: "kind of frame" }),
        };
        let length = u8::read(from)?;
        if usize::from(length) > MAX_DATA {
            return Err(StateError::Unsound { what: "length of a frame" });
        }
        Ok(Self { timestamp, bus, id, kind, length, bytes: from.take()? })
    }
}

impl PartialEq for Frame {
    fn eq(&self, other: &Self) -> bool {
        let key = |frame: &Self| (frame.timestamp, frame.bus, frame.id, frame.kind);
        key(self) == key(other) && self.data() == other.data()
    }
}

impl Eq for Frame {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_payload_of_up_to_eight_bytes_is_a_word_whatever_is_behind_it() {
        let id = Id::standard(1).expect("11 bits");
        for length in 0..=12 {
            let data = &[0x81; 12][..length];
            let mut frame = Frame::new(Timestamp::default(), id, Kind::Data, data);
            frame.buffer_mut()[length..].fill(0xFF);
            let expected =
                data.iter().rev().fold(0_u128, |word, byte| word << 8 | u128::from(*byte));
            assert_eq!(frame.word(), u64::try_from(expected).ok().filter(|_| length <= 8));
        }
    }

    /// What is behind the payload is of no frame.
    #[test]
    fn frames_are_the_same_that_say_the_same_at_the_same_time() {
        let id = |value| Id::standard(value).expect("11 bits");
        let frame = |nanos, value, kind, data: &[u8]| {
            Frame::new(Timestamp::from_nanos(nanos), id(value), kind, data)
        };
        let one = frame(7, 1, Kind::Data, &[1, 2]);
        let mut same = frame(7, 1, Kind::Data, &[1, 2, 3]);
        same.set_length(2);
        assert_eq!(same, one);
        for other in [
            frame(8, 1, Kind::Data, &[1, 2]),
            frame(7, 2, Kind::Data, &[1, 2]),
            frame(7, 1, Kind::Error, &[1, 2]),
            frame(7, 1, Kind::Data, &[1, 3]),
            frame(7, 1, Kind::Data, &[1]),
            one.clone().on(BusNumber::Second),
        ] {
            assert_ne!(other, one);
        }
    }

    #[test]
    fn what_lies_behind_a_payload_is_not_saved() {
        let id = Id::standard(1).expect("11 bits");
        let mut frame = Frame::new(Timestamp::default(), id, Kind::Data, &[1; MAX_DATA]);
        frame.set_length(3);
        let saved = |frame: &Frame| {
            let mut writer = StateWriter::default();
            frame.save(&mut writer);
            writer.finish()
        };
        let expected = saved(&Frame::new(Timestamp::default(), id, Kind::Data, &[1; 3]));
        assert_eq!(saved(&frame), expected);
    }

    #[test]
    fn an_identifier_in_a_dbc_says_its_format_in_bit_31() {
        let [short, long] = [Id::standard(0x181), Id::extended(0x181)].map(|id| id.expect("fits"));
        assert_eq!((short.to_dbc(), long.to_dbc()), (0x181, 0x8000_0181));
    }
}
