//! Tables of SavvyCAN and of GVRET devices: CSV with the columns `Time Stamp,ID,Extended,Dir,Bus,LEN,D1,…`.
//!
//! The first line names the columns; older tables have no `Dir`. Times are whole microseconds, since 1970 or since
//! the device started: which of both, the table does not tell, but only the former are so large. It does not tell
//! remote frames and error frames from data frames either. Columns behind the payload are of no interest.

use crate::format::{Format, Item, Numbered, Reader, Unread, is_fd_length};
use crate::reason::{Found, Reason};
use tertius_core::frame::{Frame, Id, Kind, MAX_DATA};
use tertius_core::time::Timestamp;

use super::hex;

pub static FORMAT: Format = Format {
    name: "a table of SavvyCAN (GVRET) in CSV",
    numbered: Numbered::Lines,
    is_whole: false,
    recognise,
    reader: |_| Box::new(SavvyCan::default()),
    written: None,
};

/// What the names of the columns begin with.
const BEGIN: &[u8] = b"time stamp,id,extended,";
/// The columns between that and the payload.
const WITH_DIRECTION: &[u8] = b"dir,bus,len,";
const WITHOUT_DIRECTION: &[u8] = b"bus,len,";
/// Least time that counts from 1970, µs: nine digits of seconds, as in candump's logs. No device runs for so long.
const LEAST_ABSOLUTE: i64 = 100_000_000_000_000;
const NANOS_PER_MICROSECOND: i64 = 1000;
/// Most digits of a time, which is then in range as a number; of a bus; and of a length.
const TIME: usize = 18;
const BUS: usize = 3;
const LENGTH: usize = 2;
const MAX_CLASSIC: usize = 8;

/// By the names of the first columns.
fn recognise(head: &[u8]) -> Option<bool> {
    let head = unmarked(head);
    let shown = head.len().min(BEGIN.len());
    if !head[..shown].eq_ignore_ascii_case(&BEGIN[..shown]) {
        return Some(false);
    }
    (shown == BEGIN.len()).then_some(true)
}

/// The text behind the byte order mark that spreadsheets put first.
fn unmarked(text: &[u8]) -> &[u8] {
    text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text)
}

/// What follows `begin` in `text`, in whichever case.
fn behind<'a>(text: &'a [u8], begin: &[u8]) -> Option<&'a [u8]> {
    let (first, rest) = text.split_at_checked(begin.len())?;
    first.eq_ignore_ascii_case(begin).then_some(rest)
}

/// The reader of one table.
#[derive(Default)]
struct SavvyCan {
    /// Whether there is a column for the direction; `None` before the names of the columns.
    directed: Option<bool>,
    /// Name of the newest frame's interface, for example `bus0`.
    interface: Vec<u8>,
}

impl Reader for SavvyCan {
    fn read<'a>(&'a mut self, unread: Unread<'a>, frame: &mut Frame) -> Item<'a> {
        let cut = match unread.line() {
            Ok(cut) => cut,
            Err(item) => return item,
        };
        let text = unmarked(cut.text).trim_ascii();
        if text.is_empty() {
            return cut.nothing();
        }
        // Tables that were put behind one another have the names once more.
        if let Some(names) = behind(text, BEGIN) {
            return match self.columns(names) {
                Ok(()) => cut.nothing(),
                Err(reason) => cut.bad(reason),
            };
        }
        match self.row(text, frame) {
            Ok(micros) => cut.frame(&self.interface, micros >= LEAST_ABSOLUTE),
            Err(reason) => cut.bad(reason),
        }
    }
}

impl SavvyCan {
    /// Takes the names of the columns behind [`BEGIN`].
    fn columns(&mut self, names: &[u8]) -> Result<(), Reason> {
        self.directed = match names {
            names if behind(names, WITH_DIRECTION).is_some() => Some(true),
            names if behind(names, WITHOUT_DIRECTION).is_some() => Some(false),
            _ => None,
        };
        let expected = "the columns Dir,Bus,LEN,D1 or Bus,LEN,D1 behind Time Stamp,ID,Extended";
        let found = Found::first(names);
        self.directed.map(|_| ()).ok_or(Reason::Expected { found, expected })
    }

    /// Reads a row into `frame`; returns its time, µs.
    fn row(&mut self, text: &[u8], frame: &mut Frame) -> Result<i64, Reason> {
        let Some(directed) = self.directed else {
            let expected = "a row below the columns Time Stamp,ID,Extended,Dir,Bus,LEN,D1";
            return Err(Reason::Expected { found: Found::first(text), expected });
        };
        let mut cells = text.split(|byte| *byte == b',').map(<[u8]>::trim_ascii);
        let mut next = || cells.next().unwrap_or_default();
        let micros = micros(next())?;
        let (id, extended) = (next(), next());
        if directed {
            direction(next())?;
        }
        let (bus, length) = (next(), length(next())?);
        for (found, byte) in frame.buffer_mut().iter_mut().take(length).enumerate() {
            *byte = match next() {
                [] => return Err(Reason::LengthMismatch { announced: length, found }),
                digits @ ([_] | [_, _]) => data(digits)? as u8,
                [_, _, more @ ..] => return Err(Reason::DataDigit(Found::first(more))),
            };
        }
        frame.id = identifier(id, extended)?;
        // Beyond a classic frame's length it can only be one of CAN FD.
        frame.kind = if length > MAX_CLASSIC { Kind::Fd { flags: 0 } } else { Kind::Data };
        frame.set_length(length);
        let nanos = micros.checked_mul(NANOS_PER_MICROSECOND).ok_or(Reason::StampRange)?;
        frame.timestamp = Timestamp::from_nanos(nanos);
        self.name(bus)?;
        Ok(micros)
    }

    /// Names the interface after its bus.
    fn name(&mut self, bus: &[u8]) -> Result<(), Reason> {
        if decimal(bus, BUS).is_none() {
            let expected = "the number of a bus";
            return Err(Reason::Expected { found: Found::first(bus), expected });
        }
        self.interface.clear();
        self.interface.extend_from_slice(b"bus");
        self.interface.extend_from_slice(bus);
        Ok(())
    }
}

/// A whole number of at most so many digits.
fn decimal(digits: &[u8], most: usize) -> Option<i64> {
    let add = |value: i64, digit: &u8| {
        digit.is_ascii_digit().then(|| 10 * value + i64::from(digit - b'0'))
    };
    Some(digits).filter(|it| (1..=most).contains(&it.len()))?.iter().try_fold(0, add)
}

fn micros(cell: &[u8]) -> Result<i64, Reason> {
    let expected = "a time in whole microseconds, as in 1700000000000516";
    decimal(cell, TIME).ok_or(Reason::Expected { found: Found::first(cell), expected })
}

fn direction(cell: &[u8]) -> Result<(), Reason> {
    let is_known = [b"rx", b"tx"].iter().any(|word| cell.eq_ignore_ascii_case(*word));
    let expected = "Rx or Tx as the direction";
    is_known.then_some(()).ok_or(Reason::Expected { found: Found::first(cell), expected })
}

fn identifier(digits: &[u8], extended: &[u8]) -> Result<Id, Reason> {
    let is = |word: &[u8]| extended.eq_ignore_ascii_case(word);
    let is_extended = is(b"true") || is(b"1");
    if !is_extended && !is(b"false") && !is(b"0") {
        let expected = "true or false for an extended identifier";
        return Err(Reason::Expected { found: Found::first(extended), expected });
    }
    let digits = behind(digits, b"0x").unwrap_or(digits);
    if digits.is_empty() || digits.len() > 8 {
        let expected = "an identifier of up to 8 hexadecimal digits";
        return Err(Reason::Expected { found: Found::first(digits), expected });
    }
    let value = hex::number(digits).map_err(|byte| Reason::IdentifierDigit(Found(Some(byte))))?;
    if is_extended {
        Id::extended(value).ok_or(Reason::ExtendedRange(value))
    } else {
        Id::standard(value).ok_or(Reason::StandardRange(value))
    }
}

/// The number of bytes of the payload.
fn length(cell: &[u8]) -> Result<usize, Reason> {
    let expected = "the number of bytes of data";
    let length = decimal(cell, LENGTH)
        .ok_or(Reason::Expected { found: Found::first(cell), expected })? as usize;
    match length {
        length if length > MAX_DATA => Err(Reason::FdTooLong),
        length if !is_fd_length(length) => Err(Reason::FdLength(length)),
        length => Ok(length),
    }
}

fn data(digits: &[u8]) -> Result<u32, Reason> {
    hex::number(digits).map_err(|byte| Reason::DataDigit(Found(Some(byte))))
}
