//! The lines that candump writes, as in can-utils' candump.c and lib.c.
//!
//! The log form (`candump -l`, `-L`) and the console form (`-ta`, `-tA`, `-td`, `-tz`, with or
//! without `-x`, `-a`, `-8`) are read; CAN XL, `-i` and `-S` are refused line by line.

mod clock;
mod common;
mod console;
mod hex;
mod line;
mod log;
mod reason;
mod stamp;
mod token;

pub(super) use clock::StampClock;
pub use clock::TimeStamps;
pub(super) use common::{Common, Known};
pub(super) use line::Line;
pub use reason::{Found, Reason};
pub(super) use stamp::Extent;

use crate::frame::{Frame, Id, Kind};
use crate::time::Timestamp;

/// Longest line that is read, bytes without its newline; candump's own stay below 400.
pub const MAX_LINE: usize = 1024;
/// Longest interface name that is accepted; Linux itself allows 15 bytes.
const MAX_INTERFACE: usize = 64;
/// Least number of digits of seconds since 1970: candump pads absolute time stamps to ten digits.
const ABSOLUTE_DIGITS: usize = 9;

/// A frame for a reader to fill.
pub(super) fn blank_frame() -> Frame {
    const ZERO: Id = match Id::standard(0) {
        Some(id) => id,
        None => panic!("0 is an 11-bit identifier"),
    };
    Frame::new(Timestamp::default(), ZERO, Kind::Data, &[])
}
