//! The recording formats: a file for each that is read, and its line in [`FORMATS`].

mod asc;
mod blf;
pub(super) mod candump;
mod channels;
mod civil;
mod decimal;
mod hex;
mod mf4;
mod pcap;
mod savvycan;
mod token;
mod trc;

use super::encoder::Written;
use super::format::Format;

/// Every format. The first one that recognises an input reads it; candump's, the last, takes any.
pub static FORMATS: [&Format; 7] = [
    &blf::FORMAT,
    &mf4::FORMAT,
    &pcap::FORMAT,
    &trc::FORMAT,
    &asc::FORMAT,
    &savvycan::FORMAT,
    &candump::FORMAT,
];

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

/// The formats in which recordings are written.
pub fn written() -> impl Iterator<Item = &'static Written> {
    FORMATS.iter().rev().filter_map(|format| format.written.as_ref())
}

/// A format that is known and not read.
struct Foreign {
    /// Whether an input begins like this.
    begins: fn(head: &[u8]) -> bool,
    /// Its name, and what to do.
    told: &'static str,
}

static FOREIGN: [Foreign; 1] = [Foreign {
    begins: |head| head.starts_with(b"MDF     ") || head.starts_with(b"UnFinMF "),
    told: "measurement data in MDF before version 4; asammdf converts it to version 4, of which bus logging is read",
}];

/// What to tell of an input that begins with `head` if it has a format that is not read.
pub fn foreign(head: &[u8]) -> Option<&'static str> {
    FOREIGN.iter().find(|format| (format.begins)(head)).map(|format| format.told)
}
