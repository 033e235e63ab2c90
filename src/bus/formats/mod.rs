//! The recording formats: a file for each that is read, and its line in [`FORMATS`].

pub(super) mod candump;
mod hex;
mod token;
mod trc;

use super::format::Format;

/// Every format. The first one that recognises an input reads it; candump's, the last, takes any.
pub static FORMATS: [&Format; 2] = [&trc::FORMAT, &candump::FORMAT];

/// The format of an input that begins with `head`; `None` where more bytes are needed to tell, which
/// never happens once the input is `whole`.
pub fn recognise(head: &[u8], whole: bool) -> Option<&'static Format> {
    for format in FORMATS {
        match (format.recognise)(head) {
            Some(true) => return Some(format),
            None if !whole => return None,
            Some(false) | None => {}
        }
    }
    Some(&candump::FORMAT)
}

/// The formats that are read, for people.
pub fn names() -> String {
    FORMATS.map(|format| format.name).join(", ")
}

/// A format that is known and not read.
struct Foreign {
    /// Whether an input begins like this.
    begins: fn(head: &[u8]) -> bool,
    /// Its name, and what to do.
    told: &'static str,
}

static FOREIGN: [Foreign; 5] = [
    Foreign {
        begins: |head| head.starts_with(b"LOGG"),
        told: "a Vector log in BLF; can_logconvert (of python-can) converts it to a candump log",
    },
    Foreign {
        begins: is_asc,
        told: "a Vector log in ASC; can_logconvert (of python-can) converts it to a candump log",
    },
    Foreign {
        begins: |head| head.starts_with(b"MDF     ") || head.starts_with(b"UnFinMF "),
        told: "measurement data in MDF; can_logconvert (of python-can) converts it to a candump log",
    },
    Foreign {
        begins: |head| PCAP.iter().any(|magic| head.starts_with(magic)),
        told: "a capture of Wireshark or tcpdump, in pcap; record with candump -l instead",
    },
    Foreign {
        begins: |head| head.starts_with(&[0x0A, 0x0D, 0x0D, 0x0A]),
        told: "a capture of Wireshark or tcpdump, in pcapng; record with candump -l instead",
    },
];

/// The first bytes of a capture, in microseconds or nanoseconds, of either byte order.
const PCAP: [[u8; 4]; 4] = [
    [0xD4, 0xC3, 0xB2, 0xA1],
    [0xA1, 0xB2, 0xC3, 0xD4],
    [0x4D, 0x3C, 0xB2, 0xA1],
    [0xA1, 0xB2, 0x3C, 0x4D],
];

/// Whether `head` begins like an ASC file, with `date Sat Sep 30 15:06:13 2017` and `base hex
/// timestamps absolute`.
fn is_asc(head: &[u8]) -> bool {
    let text = head.to_ascii_lowercase();
    let mut lines = text.split(|byte| *byte == b'\n').map(|line| line.trim_ascii());
    lines.by_ref().take(4).any(|line| {
        line.starts_with(b"base hex ") || line.starts_with(b"base dec ") || line == b"base hex"
    })
}

/// What to tell of an input that begins with `head` if it has a format that is not read.
pub fn foreign(head: &[u8]) -> Option<&'static str> {
    FOREIGN.iter().find(|format| (format.begins)(head)).map(|format| format.told)
}
