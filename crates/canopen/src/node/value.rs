//! A value of the object dictionary as bytes.

/// Length of the longest value, bytes.
const LONGEST: usize = 256;

/// The bytes of a value, little-endian, as SDO carries them.
#[derive(Clone, Copy, Debug)]
pub(super) struct NodeValue {
    bytes: [u8; LONGEST],
    length: usize,
}

impl Default for NodeValue {
    fn default() -> Self {
        Self { bytes: [0; LONGEST], length: 0 }
    }
}

impl NodeValue {
    pub(super) fn bytes(&self) -> &[u8] {
        &self.bytes[..self.length]
    }

    /// Replaces the value; what is beyond the longest is left out.
    pub(super) fn set(&mut self, bytes: &[u8]) {
        self.length = bytes.len().min(LONGEST);
        self.bytes[..self.length].copy_from_slice(&bytes[..self.length]);
    }
}

/// Data type of an object. The numbers are those of CiA 301.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NodeType {
    Integer16 = 0x03,
    Unsigned8 = 0x05,
    Unsigned16 = 0x06,
    Unsigned32 = 0x07,
    Real32 = 0x08,
    Text = 0x09,
    Unsigned24 = 0x16,
    Unsigned64 = 0x1B,
}

impl NodeType {
    /// Length of a value, bits; 0 for texts.
    pub(super) const fn bits(self) -> u8 {
        match self {
            Self::Unsigned8 => 8,
            Self::Integer16 | Self::Unsigned16 => 16,
            Self::Unsigned24 => 24,
            Self::Unsigned32 | Self::Real32 => 32,
            Self::Unsigned64 => 64,
            Self::Text => 0,
        }
    }
}
