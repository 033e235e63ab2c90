//! Inputs without a frame, and what they seem to be.

use std::fmt;

/// Number of bytes by which an input is recognised.
pub const HEAD: usize = 512;

/// An input without a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Barren {
    /// Name of the file as given, or "standard input".
    pub file: String,
    pub lines: u64,
    /// Apparent kind, after decompression.
    pub seems: Seems,
}

impl fmt::Display for Barren {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, lines, seems } = self;
        match seems {
            Seems::Empty => write!(f, "{file}: {seems}"),
            Seems::Text => write!(f, "{file}: no frame in {lines} lines; {seems}"),
            _ => write!(f, "{file}: no frame; {seems}"),
        }
    }
}

/// Apparent kind of an input, by its first bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seems {
    Empty,
    /// Vector's text format.
    Asc,
    /// Vector's binary format.
    Blf,
    /// PEAK's text format.
    Trc,
    /// ASAM's measurement data, of either version.
    Mdf,
    /// Capture of Wireshark or tcpdump.
    Pcap,
    Pcapng,
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

/// First bytes by which a kind is recognised.
const MAGIC: [(&[u8], Seems); 19] = [
    (b"LOGG", Seems::Blf),
    (b"MDF     ", Seems::Mdf),
    (b"UnFinMF ", Seems::Mdf),
    (&[0xD4, 0xC3, 0xB2, 0xA1], Seems::Pcap),
    (&[0xA1, 0xB2, 0xC3, 0xD4], Seems::Pcap),
    (&[0x4D, 0x3C, 0xB2, 0xA1], Seems::Pcap),
    (&[0xA1, 0xB2, 0x3C, 0x4D], Seems::Pcap),
    (&[0x0A, 0x0D, 0x0D, 0x0A], Seems::Pcapng),
    (&[0xFD, b'7', b'z', b'X', b'Z', 0], packed("xz", "xz -dc FILE")),
    (b"BZh", packed("bzip2", "bzip2 -dc FILE")),
    (&[b'7', b'z', 0xBC, 0xAF, 0x27, 0x1C], packed("7-Zip", "7z x -so FILE")),
    (b"PK\x03\x04", packed("zip", "unzip -p FILE")),
    (&[0x04, 0x22, 0x4D, 0x18], packed("LZ4", "lz4 -dc FILE")),
    (b"Rar!", packed("RAR", "unrar p -inul FILE")),
    (&[0x1F, 0x8B], packed("gzip, twice over", "gzip -dc FILE")),
    (&[0x28, 0xB5, 0x2F, 0xFD], packed("zstd, twice over", "zstd -dc FILE")),
    (b";$FILEVERSION=", Seems::Trc),
    (&[0xFF, 0xFE], Seems::Utf16),
    (&[0xFE, 0xFF], Seems::Utf16),
];

const fn packed(name: &'static str, unpack: &'static str) -> Seems {
    Seems::Packed { name, unpack }
}

impl Seems {
    /// The kind of an input that begins with `head`: the first 512 bytes, or all if there are
    /// fewer.
    pub fn of(head: &[u8]) -> Self {
        let magic = MAGIC.iter().find(|(magic, _)| head.starts_with(magic));
        match magic {
            _ if head.trim_ascii().is_empty() => Self::Empty,
            Some((_, seems)) => *seems,
            None if is_text(head) && is_asc(head) => Self::Asc,
            None if is_text(head) => Self::Text,
            None => Self::Binary,
        }
    }
}

/// Whether `head` is text, which has no control characters except white space.
fn is_text(head: &[u8]) -> bool {
    let odd = |byte: &u8| byte.is_ascii_control() && !byte.is_ascii_whitespace();
    !head.iter().any(odd)
}

/// Whether `head` begins like an ASC file, with `date Sat Sep 30 15:06:13 2017` and `base hex
/// timestamps absolute`.
fn is_asc(head: &[u8]) -> bool {
    let text = head.to_ascii_lowercase();
    let mut lines = text.split(|byte| *byte == b'\n').map(|line| line.trim_ascii());
    lines.by_ref().take(4).any(|line| {
        line.starts_with(b"base hex ") || line.starts_with(b"base dec ") || line == b"base hex"
    })
}

impl fmt::Display for Seems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let converted = "can_logconvert (of python-can) converts it to a candump log";
        match self {
            Self::Empty => f.write_str("it is empty"),
            Self::Asc => write!(f, "it seems to be a Vector log in ASC; {converted}"),
            Self::Blf => write!(f, "it seems to be a Vector log in BLF; {converted}"),
            Self::Trc => write!(f, "it seems to be a PEAK trace in TRC; {converted}"),
            Self::Mdf => write!(f, "it seems to be measurement data in MDF; {converted}"),
            Self::Pcap | Self::Pcapng => {
                let name = if *self == Self::Pcap { "pcap" } else { "pcapng" };
                write!(
                    f,
                    "it seems to be a capture of Wireshark or tcpdump, in {name}; record with \
                     candump -l instead"
                )
            }
            Self::Packed { name, unpack } => {
                write!(f, "it seems to be packed ({name}); unpack it first: {unpack} | tertius … -")
            }
            Self::Utf16 => f.write_str(
                "it seems to be text in UTF-16; convert it with iconv -f utf-16 -t ascii",
            ),
            Self::Text => f.write_str("it is text, but not a candump recording"),
            Self::Binary => f.write_str("it is neither text nor a known format"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_told_from_what_is_none() {
        assert_eq!(Seems::of(b""), Seems::Empty);
        assert_eq!(Seems::of(b"\n\r\n"), Seems::Empty);
        assert_eq!(Seems::of("# Gangway\nüber\ttext".as_bytes()), Seems::Text);
        assert_eq!(Seems::of(b"\x7FELF\x02\x01"), Seems::Binary);
        let asc = b"date Sat Sep 30 15:06:13.191 2017\r\nbase hex  timestamps absolute\r\n";
        assert_eq!(Seems::of(asc), Seems::Asc);
        // Windows writes two bytes a character behind a mark.
        assert_eq!(Seems::of(b"\xFF\xFE(\0"), Seems::Utf16);
    }
}
