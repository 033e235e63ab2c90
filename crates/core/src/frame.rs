//! A CAN frame with the time at which it was on the bus.

use crate::time::Timestamp;

/// The longest payload: CAN FD's.
pub const MAX_DATA: usize = 64;

/// A CAN identifier that cannot be out of range; standard and extended ones are never equal.
///
/// Inside it is the identifier with bit 31 set for the extended format, as in a DBC file.
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

impl std::fmt::Display for Id {
    /// As candump writes it: three hexadecimal digits, or eight for the extended format.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.is_extended() {
            write!(f, "{:08X}", self.value())
        } else {
            write!(f, "{:03X}", self.value())
        }
    }
}

/// What kind of frame it is. Only `Data` and `Fd` carry signals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A classic data frame.
    Data,
    /// A CAN FD data frame; `flags` as in candump's `##` (1 bit-rate switch, 2 error state).
    Fd { flags: u8 },
    /// A classic remote frame; its length is the one asked for, its payload is empty.
    Remote { length: u8 },
    /// A controller's error message; the identifier holds the error class.
    Error,
}

/// A time-stamped frame. Bytes beyond the payload's length are unspecified and never read as data.
#[derive(Clone, Debug)]
pub struct Frame {
    pub timestamp: Timestamp,
    pub id: Id,
    pub kind: Kind,
    length: u8,
    bytes: [u8; MAX_DATA],
}

impl Frame {
    /// A frame with `data` as payload.
    ///
    /// # Panics
    /// If `data` is longer than [`MAX_DATA`]: the caller's own bug, not bad input.
    pub fn new(timestamp: Timestamp, id: Id, kind: Kind, data: &[u8]) -> Self {
        let mut bytes = [0; MAX_DATA];
        bytes[..data.len()].copy_from_slice(data);
        Self { timestamp, id, kind, length: data.len() as u8, bytes }
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

    /// The whole buffer, so that a decoder may load eight bytes at once; beyond [`Self::length`]
    /// it is unspecified.
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
    /// If `length` exceeds [`MAX_DATA`].
    pub fn set_length(&mut self, length: usize) {
        assert!(length <= MAX_DATA, "a frame holds at most {MAX_DATA} bytes");
        self.length = length as u8;
    }
}

impl PartialEq for Frame {
    fn eq(&self, other: &Self) -> bool {
        (self.timestamp, self.id, self.kind) == (other.timestamp, other.id, other.kind)
            && self.data() == other.data()
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
}
