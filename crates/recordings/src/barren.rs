//! Inputs without a frame, and what they seem to be.

use std::fmt;

use super::bad_line::{BadLine, BadPlace};
use super::format::Format;
use super::formats::{self, candump};
use super::input::Input;
use super::reason::Reason;

/// An input without a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Barren {
    /// Name of the file as given, or "standard input".
    pub file: String,
    pub lines: u64,
    /// Apparent kind, after decompression.
    pub seems: Seems,
}

impl Barren {
    /// The `input`, which was read as one of `format` and had so many `lines`; `flaw` is the first thing that is wrong
    /// with it and is not told elsewhere.
    pub(super) fn of(
        input: &Input,
        format: &'static Format,
        lines: u64,
        flaw: Option<&BadLine>,
    ) -> Self {
        let seems = match flaw {
            Some(BadLine { place: BadPlace::Byte(at), reason, .. }) if format.is_whole => {
                Seems::Flawed { name: format.name, at: *at, reason: *reason }
            }
            _ => Seems::of(input.head(), format),
        };
        Self { file: input.name().to_owned(), lines, seems }
    }
}

impl fmt::Display for Barren {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, lines, seems } = self;
        match seems {
            Seems::Empty => write!(f, "{file}: {seems}"),
            Seems::Text if *lines == 1 => write!(f, "{file}: no frame in 1 line; {seems}"),
            Seems::Text => write!(f, "{file}: no frame in {lines} lines; {seems}"),
            _ => write!(f, "{file}: no frame; {seems}"),
        }
    }
}

/// Apparent kind of an input, by its first bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seems {
    Empty,
    /// A format that is read, but without a frame here: its name.
    Readable(&'static str),
    /// The same, and what is wrong with it at this byte.
    Flawed {
        name: &'static str,
        at: u64,
        reason: Reason,
    },
    /// A format that is not read: its name, and what to do.
    Foreign(&'static str),
    /// Compressed or packed data, and how to unpack them.
    Packed {
        name: &'static str,
        unpack: &'static str,
    },
    /// Text with two bytes a character.
    Utf16,
    /// Text in no known format.
    Text,
    /// Other binary data.
    Binary,
}

/// First bytes of what is no recording format.
const MAGIC: [(&[u8], Seems); 10] = [
    (&[0xFD, b'7', b'z', b'X', b'Z', 0], packed("xz", "xz -dc FILE")),
    (b"BZh", packed("bzip2", "bzip2 -dc FILE")),
    (&[b'7', b'z', 0xBC, 0xAF, 0x27, 0x1C], packed("7-Zip", "7z x -so FILE")),
    (b"PK\x03\x04", packed("zip", "unzip -p FILE")),
    (&[0x04, 0x22, 0x4D, 0x18], packed("LZ4", "lz4 -dc FILE")),
    (b"Rar!", packed("RAR", "unrar p -inul FILE")),
    (&[0x1F, 0x8B], packed("gzip, twice over", "gzip -dc FILE")),
    (&[0x28, 0xB5, 0x2F, 0xFD], packed("zstd, twice over", "zstd -dc FILE")),
    (&[0xFF, 0xFE], Seems::Utf16),
    (&[0xFE, 0xFF], Seems::Utf16),
];

const fn packed(name: &'static str, unpack: &'static str) -> Seems {
    Seems::Packed { name, unpack }
}

impl Seems {
    /// The kind of an input that begins with `head`: the first 512 bytes, or all if there are
    /// fewer. `format` is the one that it was read as.
    pub(super) fn of(head: &[u8], format: &Format) -> Self {
        // candump's is tried on everything that no other format recognises.
        if !std::ptr::eq(format, &candump::FORMAT) {
            return Self::Readable(format.name);
        }
        let magic = MAGIC.iter().find(|(magic, _)| head.starts_with(magic));
        match magic {
            _ if head.trim_ascii().is_empty() => Self::Empty,
            Some((_, seems)) => *seems,
            None => match formats::foreign(head) {
                Some(told) => Self::Foreign(told),
                None if is_text(head) => Self::Text,
                None => Self::Binary,
            },
        }
    }
}

/// Whether `head` is text, which has no control characters except white space.
fn is_text(head: &[u8]) -> bool {
    let odd = |byte: &u8| byte.is_ascii_control() && !byte.is_ascii_whitespace();
    !head.iter().any(odd)
}

impl fmt::Display for Seems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => f.write_str("it is empty"),
            Self::Readable(told) | Self::Foreign(told) => write!(f, "it seems to be {told}"),
            Self::Flawed { name, at, reason } => {
                write!(f, "it seems to be {name}, but at byte {at}: {reason}")
            }
            Self::Packed { name, unpack } => {
                write!(f, "it seems to be packed ({name}); unpack it first: {unpack} | tertius … -")
            }
            Self::Utf16 => f.write_str(
                "it seems to be text in UTF-16; convert it with iconv -f utf-16 -t ascii",
            ),
            Self::Text => f.write_str("it is text, but not a recording that can be read"),
            Self::Binary => f.write_str("it is neither text nor a known format"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(head: &[u8]) -> Seems {
        Seems::of(head, &candump::FORMAT)
    }

    #[test]
    fn text_is_told_from_what_is_none() {
        assert_eq!(of(b""), Seems::Empty);
        assert_eq!(of(b"\n\r\n"), Seems::Empty);
        assert_eq!(of("# Gangway\nüber\ttext".as_bytes()), Seems::Text);
        assert_eq!(of(b"\x7FELF\x02\x01"), Seems::Binary);
        assert!(matches!(of(b"MDF     3.30    "), Seems::Foreign(told) if told.contains("MDF")));
        // Windows writes two bytes a character behind a mark.
        assert_eq!(of(b"\xFF\xFE(\0"), Seems::Utf16);
    }
}
