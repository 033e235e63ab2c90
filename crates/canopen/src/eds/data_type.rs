//! The static data types of CiA 301.

use std::fmt;

/// Data type of a variable, by its index in the object dictionary (CiA 301, table 44).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DataType {
    Boolean,
    /// INTEGER8 to INTEGER64, with its width in bits.
    Integer(u8),
    /// UNSIGNED8 to UNSIGNED64, with its width in bits.
    Unsigned(u8),
    Real32,
    Real64,
    VisibleString,
    OctetString,
    UnicodeString,
    TimeOfDay,
    TimeDifference,
    Domain,
    /// Another one, by its number: reserved, complex, or the maker's own.
    Other(u16),
}

/// Numbers of the integers and their widths in bits.
const INTEGERS: [(u16, u8); 8] =
    [(0x02, 8), (0x03, 16), (0x10, 24), (0x04, 32), (0x12, 40), (0x13, 48), (0x14, 56), (0x15, 64)];
const UNSIGNEDS: [(u16, u8); 8] =
    [(0x05, 8), (0x06, 16), (0x16, 24), (0x07, 32), (0x18, 40), (0x19, 48), (0x1A, 56), (0x1B, 64)];

impl DataType {
    /// The type of that number, which is its index in the object dictionary.
    pub fn from_number(number: u16) -> Self {
        let width = |of: &[(u16, u8)]| of.iter().find(|it| it.0 == number).map(|it| it.1);
        match number {
            0x01 => Self::Boolean,
            0x08 => Self::Real32,
            0x09 => Self::VisibleString,
            0x0A => Self::OctetString,
            0x0B => Self::UnicodeString,
            0x0C => Self::TimeOfDay,
            0x0D => Self::TimeDifference,
            0x0F => Self::Domain,
            0x11 => Self::Real64,
            _ => width(&INTEGERS)
                .map(Self::Integer)
                .or_else(|| width(&UNSIGNEDS).map(Self::Unsigned))
                .unwrap_or(Self::Other(number)),
        }
    }

    /// The width in bits that a value has in a PDO; `None` for what has no fixed one.
    pub fn bits(self) -> Option<u8> {
        match self {
            Self::Boolean => Some(1),
            Self::Integer(bits) | Self::Unsigned(bits) => Some(bits),
            Self::Real32 => Some(32),
            Self::Real64 => Some(64),
            Self::TimeOfDay | Self::TimeDifference => Some(48),
            Self::VisibleString
            | Self::OctetString
            | Self::UnicodeString
            | Self::Domain
            | Self::Other(_) => None,
        }
    }
}

impl fmt::Display for DataType {
    /// The name of CiA 301, such as `UNSIGNED32`; `type 0x0040` where there is none.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Boolean => f.write_str("BOOLEAN"),
            Self::Integer(bits) => write!(f, "INTEGER{bits}"),
            Self::Unsigned(bits) => write!(f, "UNSIGNED{bits}"),
            Self::Real32 => f.write_str("REAL32"),
            Self::Real64 => f.write_str("REAL64"),
            Self::VisibleString => f.write_str("VISIBLE_STRING"),
            Self::OctetString => f.write_str("OCTET_STRING"),
            Self::UnicodeString => f.write_str("UNICODE_STRING"),
            Self::TimeOfDay => f.write_str("TIME_OF_DAY"),
            Self::TimeDifference => f.write_str("TIME_DIFFERENCE"),
            Self::Domain => f.write_str("DOMAIN"),
            Self::Other(number) => write!(f, "type 0x{number:04X}"),
        }
    }
}
