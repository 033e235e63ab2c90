//! Why a line or record is not a frame, for people.

use super::limits::MAX_LINE;

/// What was found in a bad line and what was expected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Reason {
    /// Any reason of a format: what was found, and what was expected.
    #[error("found {found}, expected {expected}")]
    Expected { found: Found, expected: &'static str },
    /// The same where nothing is found, since the input has no bytes there.
    #[error("found the end of the file, expected {0}")]
    EndExpected(&'static str),
    /// Any reason of a format that says everything.
    #[error("{0}")]
    Text(&'static str),
    #[error(
        "the line is longer than {MAX_LINE} bytes: this is not a candump recording, or it lost its \
         line ends"
    )]
    LineTooLong,
    #[error("the line is truncated where the file is damaged")]
    CutOff,
    #[error("the file ends in the middle of a record")]
    Incomplete,
    #[error("the record is longer than {limit} bytes", limit = super::limits::MAX_RECORD)]
    RecordTooLong,
    #[error("candump reports here that it lost frames")]
    DropCount,
    #[error(
        "found {0}, expected a time stamp such as (1700000000.000516); record with candump -L or -ta"
    )]
    NoStamp(Found),
    #[error("the time stamp's closing parenthesis is missing")]
    OpenStamp,
    #[error(
        "the time stamp is neither seconds with up to nine decimals, as in (1700000000.000516), nor a date, as in (2023-11-14 22:13:20.000516)"
    )]
    Stamp,
    #[error("the time stamp is out of range: expected the years 1678 to 2261")]
    StampRange,
    #[error("found {0}, expected an interface such as can0 after the time stamp")]
    Interface(Found),
    #[error("the interface's name has {0} bytes, expected at most {limit}", limit = super::limits::MAX_INTERFACE)]
    InterfaceTooLong(usize),
    #[error("the line ends after the interface, expected a frame such as 181#E02D")]
    NoFrame,
    #[error(
        "the identifier has {0} characters, expected 3 hexadecimal digits, or 8 for an extended one"
    )]
    IdentifierLength(usize),
    #[error("found {0} in the identifier, expected a hexadecimal digit")]
    IdentifierDigit(Found),
    #[error("the identifier {0:03X} is out of range, expected at most 7FF")]
    StandardRange(u32),
    #[error(
        "the identifier {0:08X} is out of range, expected at most 1FFFFFFF, or 3FFFFFFF for an error frame"
    )]
    ExtendedRange(u32),
    #[error("a CAN XL frame; classic CAN and CAN FD are read")]
    Xl,
    #[error("found {0} as flags of a CAN FD frame, expected a hexadecimal digit after ##")]
    FdFlags(Found),
    #[error("found {0} in the data, expected a hexadecimal digit")]
    DataDigit(Found),
    #[error(
        "found a word of {0} characters in the data, expected two hexadecimal digits for each byte; record without candump -i and -S"
    )]
    DataWord(usize),
    #[error("the data end with half a byte, expected two hexadecimal digits for each byte")]
    HalfByte,
    #[error("more than 8 bytes of data in a classic frame")]
    ClassicLength,
    #[error("more than 64 bytes of data")]
    FdTooLong,
    #[error("{0} bytes of data, but a CAN FD frame has 0 to 8, 12, 16, 20, 24, 32, 48 or 64")]
    FdLength(usize),
    #[error("found {0} as a remote frame's length, expected 0 to 8")]
    RemoteLength(Found),
    #[error("an error frame is never a remote or a CAN FD frame")]
    ErrorKind,
    #[error("found {0} as raw length code, expected 9 to F after the _ that follows 8 bytes")]
    RawLength(Found),
    #[error("found {0}, expected the length in brackets, as in [8]")]
    Length(Found),
    #[error("the line announces {announced} bytes, but {found} follow")]
    LengthMismatch { announced: usize, found: usize },
    #[error(
        "found a compressed block of {found} bytes, expected at most {most}: what is unpacked is held in memory, and this file is read at {places} places at the same time; write it with smaller blocks, or its groups into files of their own"
    )]
    UnpackedTooLong { found: u64, most: u64, places: usize },
    #[error("found {0} after the frame, expected the end of the line")]
    Trailing(Found),
}

/// The byte that was found, or the end of the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Found(pub Option<u8>);

impl Found {
    /// The first byte of `text`.
    pub(super) fn first(text: &[u8]) -> Self {
        Self(text.first().copied())
    }
}

impl std::fmt::Display for Found {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            None => f.write_str("the end of the line"),
            Some(b' ' | b'\t') => f.write_str("a blank"),
            Some(byte) if byte.is_ascii_graphic() => write!(f, "“{}”", char::from(byte)),
            Some(byte) => write!(f, "the byte 0x{byte:02X}"),
        }
    }
}
