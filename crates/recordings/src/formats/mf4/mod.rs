//! Bus logging in MDF 4 of ASAM, as CANedge, asammdf and python-can write it.
//!
//! A file is a net of blocks that lead to each other by their places, in any order: the descriptions may stand behind the
//! data. It is therefore held in memory as a whole. Groups of the channels CAN_DataFrame, CAN_RemoteFrame and
//! CAN_ErrorFrame become frames; others are left out.

mod block;
mod cursor;
mod field;
mod group;
mod log;
mod packed;
mod stream;
mod variable;
mod window;

use crate::format::{End, Format, Item, Numbered, Reader, Unread};
use crate::reason::Reason;
use tertius_core::frame::Frame;

use super::channels::NumberedName;
use cursor::Next;
use log::Log;

pub static FORMAT: Format = Format {
    name: "bus logging in MDF 4",
    numbered: Numbered::Bytes,
    is_whole: true,
    recognise,
    reader: |_| Box::new(Mf4::default()),
    written: None,
};

/// How files begin, and those that were never finished.
const BEGINS: [&[u8; 9]; 2] = [b"MDF     4", b"UnFinMF 4"];
/// Longest file that is held in memory.
const MOST: usize = 1 << 30;
/// Bytes that are taken at a time.
const PART: usize = 1 << 16;

fn recognise(head: &[u8]) -> Option<bool> {
    match head.first_chunk() {
        Some(first) => Some(BEGINS.contains(&first)),
        None => BEGINS.iter().all(|begin| !begin.starts_with(head)).then_some(false),
    }
}

/// What of a file was read.
#[derive(Default)]
enum State {
    /// Some of its bytes.
    #[default]
    Bytes,
    /// All of them.
    Records(Log),
    /// Too many.
    Lost,
}

/// The reader of one file.
#[derive(Default)]
struct Mf4 {
    state: State,
    bytes: Vec<u8>,
    interface: NumberedName,
}

impl Reader for Mf4 {
    fn read<'a>(&'a mut self, unread: Unread<'a>, frame: &mut Frame) -> Item<'a> {
        let held = unread.bytes.len();
        if held >= PART || (held > 0 && unread.end != End::Open) {
            return self.take(&unread.bytes[..held.min(PART)]);
        }
        if unread.end == End::Open {
            return Item::More;
        }
        if matches!(self.state, State::Bytes) {
            self.state = State::Records(Log::open(&self.bytes));
        }
        let State::Records(log) = &mut self.state else { return Item::More };
        match log.next(&self.bytes, frame) {
            Next::Frame(channel) => {
                let interface = self.interface.channel(channel);
                Item::Frame { taken: 0, interface, absolute: log.absolute }
            }
            Next::Other => Item::Nothing { taken: 0 },
            Next::Bad(flaw) => Item::BadAt {
                at: flaw.at,
                shown: log::shown(&self.bytes, flaw.at),
                reason: flaw.reason,
                loses: flaw.loses,
            },
            Next::End => Item::More,
        }
    }
}

impl Mf4 {
    /// Takes the next bytes of the file.
    fn take(&mut self, part: &[u8]) -> Item<'static> {
        let taken = part.len();
        if matches!(self.state, State::Bytes) {
            if self.bytes.len() + taken > MOST {
                (self.state, self.bytes) = (State::Lost, Vec::new());
                let reason = Reason::Text(
                    "the file has more than 1 GiB, and MDF is held in memory as a whole; split it, or let the logger do so",
                );
                return Item::Bad { shown: 0, taken, reason };
            }
            self.bytes.extend_from_slice(part);
        }
        Item::Nothing { taken }
    }
}
