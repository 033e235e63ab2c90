//! The lines that candump writes, as in can-utils' candump.c and lib.c.
//!
//! The log form (`candump -l`, `-L`) and the console form (`-ta`, `-tA`, `-td`, `-tz`, with or
//! without `-x`, `-a`, `-8`) are read; CAN XL, `-i` and `-S` are refused line by line.

mod clock;
mod common;
mod console;
mod line;
mod log;
pub(super) mod stamp;
pub(crate) mod writer;

pub(crate) use common::{Common, Known};
use line::Line;
use stamp::{Extent, Seven, Stamp};

use crate::encoder::Written;
use crate::format::{Format, Item, Numbered, Reader, TimeStamps, Unread, blank_frame};
use crate::reason::{Found, Reason};
use tertius_core::frame::Frame;

use clock::StampClock;

/// From `.1000000` s to the whole second that asc2log means by it, ns.
const CARRIED: i64 = 900_000_000;

/// candump's format, which also takes what no other format recognises.
pub static FORMAT: Format = Format {
    name: "a candump recording (-l, -L, or the console form with time stamps)",
    numbered: Numbered::Lines,
    is_whole: false,
    recognise: |_| Some(true),
    reader: |stamps| {
        Box::new(Candump { clock: StampClock::new(stamps), has_seven_decimals: false })
    },
    written: Some(Written {
        word: "log",
        encoder: || Box::new(writer::LogEncoder),
        explains_errors: true,
        is_packed: false,
    }),
};

/// Reads the lines that are left by [`Common`], the shortcut for most lines of a recording.
struct Candump {
    clock: StampClock,
    /// Whether a time stamp with seven decimals was one in tenths of a microsecond.
    has_seven_decimals: bool,
}

impl Candump {
    /// Reads what asc2log writes where microseconds add up to a whole second: `(1614188635.1000000)` is
    /// 1614188636 s. A recording that has seven decimals throughout means what it says.
    fn carry(&mut self, stamp: &mut Stamp) {
        self.has_seven_decimals |= stamp.seven == Some(Seven::Other);
        if stamp.seven == Some(Seven::Million) && !self.has_seven_decimals {
            stamp.nanos = stamp.nanos.saturating_add(CARRIED);
        }
    }
}

impl Reader for Candump {
    fn read<'a>(&'a mut self, unread: Unread<'a>, frame: &mut Frame) -> Item<'a> {
        let cut = match unread.line() {
            Ok(cut) => cut,
            Err(item) => return item,
        };
        let mut line = match Line::parse(cut.text) {
            Ok(Some(line)) => line,
            Ok(None) => return cut.nothing(),
            Err(reason) => return cut.bad(reason),
        };
        self.carry(&mut line.stamp);
        let read = line.read_frame(frame);
        if read.is_ok() && self.clock.must_look_ahead(&line) && !self.clock.look_ahead(unread) {
            return Item::More;
        }
        // A bad frame's time counts too: those after it may be relative to it.
        match self.clock.instant(&line).and_then(|instant| read.map(|()| instant)) {
            Ok(instant) => {
                frame.timestamp = instant;
                cut.frame(line.interface, line.stamp.extent == Extent::Absolute)
            }
            Err(reason) => cut.bad(reason),
        }
    }
}
