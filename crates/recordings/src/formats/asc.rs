//! Vector's logging format ASC, as CANalyzer and CANoe write it, and others for them.
//!
//! A head tells the date, the base of identifiers and data (hexadecimal or decimal), and whether times count from
//! the start or from the event before. An event is a line that begins with its time, s; frames are those with a channel,
//! an identifier and a direction. Some tools write times of day instead, which the first frame shows. A frame may have
//! its name in a database in place of its identifier, which then stands at the end of the line. The date is the local
//! time of the recording computer, which does not tell its zone, and is taken as UTC.

mod date;
mod flags;
mod writer;

use crate::encoder::Written;
use crate::format::{Format, Item, Numbered, Reader, Unread, is_fd_length};
use crate::reason::{Found, Reason};
use tertius_core::frame::{Frame, Id, Kind};
use tertius_core::time::Timestamp;

use super::decimal::number;
use super::hex;
use super::token::{is_blank, token};
use date::{Date, Origin};
use flags::{BIT_RATE_SWITCH, ERROR_STATE};

pub static FORMAT: Format = Format {
    name: "a Vector log in ASC",
    numbered: Numbered::Lines,
    is_whole: false,
    recognise,
    reader: |_| Box::new(Asc::default()),
    written: Some(Written {
        word: "asc",
        encoder: || Box::new(writer::AscEncoder::default()),
        explains_errors: false,
        is_packed: false,
    }),
};

const NANOS_PER_SECOND: i128 = 1_000_000_000;
/// Lines of the head in which the base has to be.
const HEAD: usize = 4;
/// Class of error frames in linux/can/error.h: a fault on the bus.
const BUS_ERROR: u32 = 0x080;
/// Most digits of a channel.
const CHANNEL: usize = 3;
/// What stands before an identifier at the end of a line.
const ID: &[u8] = b" ID ";

/// By `base hex` or `base dec` in one of the first lines, after the date or comments.
fn recognise(head: &[u8]) -> Option<bool> {
    let mut lines = 0;
    for line in head.split_inclusive(|byte| *byte == b'\n').take(HEAD) {
        let is_cut = !line.ends_with(b"\n");
        let (word, rest) = token(line.trim_ascii());
        let may_precede = word.is_empty() || is(word, "date") || word.starts_with(b"//");
        if is_cut {
            let word = word.to_ascii_lowercase();
            let may_become =
                ["base", "date", "//"].iter().any(|it| it.as_bytes().starts_with(&word));
            return if may_precede || may_become { None } else { Some(false) };
        }
        if is(word, "base") {
            let base = token(rest).0;
            return Some(is(base, "hex") || is(base, "dec"));
        }
        if !may_precede {
            return Some(false);
        }
        lines += 1;
    }
    (lines == HEAD).then_some(false)
}

fn is(word: &[u8], name: &str) -> bool {
    word.eq_ignore_ascii_case(name.as_bytes())
}

/// The reader of one log.
struct Asc {
    /// Of identifiers, data and their codes: 16 or 10.
    base: u32,
    /// Whether times count from the event before.
    relative: bool,
    /// The date of the start.
    start: Option<Date>,
    /// What times count from; `None` before the first frame behind a date.
    origin: Option<Origin>,
    /// Time of the newest event since the start, ns.
    now: i128,
    /// Name of the newest frame's interface, for example `channel1`.
    interface: Vec<u8>,
}

impl Default for Asc {
    fn default() -> Self {
        let (start, origin, interface) = (None, None, Vec::new());
        Self { base: 16, relative: false, start, origin, now: 0, interface }
    }
}

impl Reader for Asc {
    fn read<'a>(&'a mut self, unread: Unread<'a>, frame: &mut Frame) -> Item<'a> {
        let cut = match unread.line() {
            Ok(cut) => cut,
            Err(item) => return item,
        };
        match self.line(cut.text.trim_ascii(), frame) {
            Ok(true) => cut.frame(&self.interface, self.start.is_some()),
            Ok(false) => cut.nothing(),
            Err(reason) => cut.bad(reason),
        }
    }
}

impl Asc {
    /// Reads a line; returns whether there is a frame.
    fn line(&mut self, text: &[u8], frame: &mut Frame) -> Result<bool, Reason> {
        let (word, rest) = token(text);
        if word.first().is_some_and(u8::is_ascii_digit) {
            return self.event(word, rest, frame);
        }
        match word.to_ascii_lowercase().as_slice() {
            b"date" => self.begin(rest)?,
            b"base" => self.head(rest)?,
            b"begin" => {
                let (_, when) = token(rest);
                if !when.trim_ascii().is_empty() {
                    self.begin(when)?;
                }
            }
            b"" | b"end" | b"internal" | b"no" | [b'/', b'/', ..] => {}
            _ => {
                let expected =
                    "an event that begins with its time, such as 0.010000 1 181 Rx d 2 E0 2D";
                return Err(Reason::Expected { found: Found::first(text), expected });
            }
        }
        Ok(false)
    }

    /// Takes the date of the start.
    fn begin(&mut self, text: &[u8]) -> Result<(), Reason> {
        (self.start, self.origin) = (Some(Date::parse(text)?), None);
        Ok(())
    }

    /// Takes what follows `base`.
    fn head(&mut self, text: &[u8]) -> Result<(), Reason> {
        let (base, rest) = token(text);
        self.base = match base {
            base if is(base, "hex") => 16,
            base if is(base, "dec") => 10,
            other => {
                let expected = "hex or dec as the base";
                return Err(Reason::Expected { found: Found::first(other), expected });
            }
        };
        let (_, times) = token(rest);
        self.relative = is(token(times).0, "relative");
        Ok(())
    }

    fn event(&mut self, time: &[u8], text: &[u8], frame: &mut Frame) -> Result<bool, Reason> {
        let expected = "the time of an event in seconds, as in 0.010000";
        let time = number(time, NANOS_PER_SECOND)
            .ok_or(Reason::Expected { found: Found::first(time), expected })?;
        self.now = if self.relative { self.now.saturating_add(time) } else { time };
        let (word, rest) = token(text);
        let length = if is(word, "CANFD") {
            let (channel, rest) = token(rest);
            self.name(channel)?;
            self.fd(rest, frame)?
        } else if word.len() <= CHANNEL && !word.is_empty() && word.iter().all(u8::is_ascii_digit) {
            self.name(word)?;
            self.classic(rest, frame)?
        } else {
            None
        };
        let Some(length) = length else { return Ok(false) };
        frame.set_length(length);
        let nanos = i64::try_from(self.since_1970()).map_err(|_| Reason::StampRange)?;
        frame.timestamp = Timestamp::from_nanos(nanos);
        Ok(true)
    }

    /// Time of the newest event since 1970, or since the start where there is no date, ns.
    fn since_1970(&mut self) -> i128 {
        let Some(start) = self.start else { return self.now };
        let (relative, now) = (self.relative, self.now);
        let origin = self.origin.get_or_insert_with(|| match relative {
            true => Origin::start(start),
            false => Origin::of(start, now),
        });
        origin.since_1970(now)
    }

    /// Names the interface after its channel.
    fn name(&mut self, channel: &[u8]) -> Result<(), Reason> {
        let is_number = !channel.is_empty() && channel.iter().all(u8::is_ascii_digit);
        if !is_number || channel.len() > CHANNEL {
            let expected = "the number of a channel";
            return Err(Reason::Expected { found: Found::first(channel), expected });
        }
        self.interface.clear();
        self.interface.extend_from_slice(b"channel");
        self.interface.extend_from_slice(channel);
        Ok(())
    }

    /// Reads what follows the channel of a classic frame; returns the length of the payload, or `None` if it is no
    /// frame of the bus: a request to send one, statistics, and other events.
    fn classic(&self, text: &[u8], frame: &mut Frame) -> Result<Option<usize>, Reason> {
        let (id, rest) = token(text);
        if is(id, "ErrorFrame") {
            return error(frame).map(Some);
        }
        let (direction, rest) = token(rest);
        if !is(direction, "Rx") && !is(direction, "Tx") {
            return Ok(None);
        }
        frame.id = match self.identifier(id) {
            Ok(id) => id,
            Err(reason) => named_identifier(rest).ok_or(reason)?,
        };
        let (kind, rest) = token(rest);
        let (code, data) = token(rest);
        match kind {
            b"d" | b"D" => {
                frame.kind = Kind::Data;
                let announced = self.code(code)?.min(8);
                self.payload(data, announced, frame)?;
                Ok(Some(announced))
            }
            b"r" | b"R" => {
                // Older logs do not tell how long an answer is asked for.
                let is_told = !code.is_empty() && code.iter().all(u8::is_ascii_hexdigit);
                let length = if is_told { self.code(code)?.min(8) as u8 } else { 0 };
                frame.kind = Kind::Remote { length };
                Ok(Some(0))
            }
            other => {
                let expected = "d for a data frame, or r for a remote one";
                Err(Reason::Expected { found: Found::first(other), expected })
            }
        }
    }

    /// Reads what follows the channel of a CAN FD frame, as [`Self::classic`] does.
    fn fd(&self, text: &[u8], frame: &mut Frame) -> Result<Option<usize>, Reason> {
        let (direction, rest) = token(text);
        let (id, rest) = token(rest);
        if is(id, "ErrorFrame") {
            return error(frame).map(Some);
        }
        if !is(direction, "Rx") && !is(direction, "Tx") {
            return Ok(None);
        }
        frame.id = self.identifier(id)?;
        let (mut switch, mut rest) = token(rest);
        if !matches!(switch, b"0" | b"1") {
            // The message's name in a database.
            (switch, rest) = token(rest);
        }
        let (state, rest) = token(rest);
        let (code, rest) = token(rest);
        let (length, data) = token(rest);
        let flag = |word: &[u8], flag| match word {
            b"0" => Ok(0),
            b"1" => Ok(flag),
            other => {
                let expected = "0 or 1 for the bit rate switch and the error state";
                Err(Reason::Expected { found: Found::first(other), expected })
            }
        };
        let flags = flag(switch, BIT_RATE_SWITCH)? | flag(state, ERROR_STATE)?;
        let expected = "the number of bytes of data";
        let length = value(length, 10)
            .ok_or(Reason::Expected { found: Found::first(length), expected })?
            as usize;
        if length == 0 && self.code(code)? > 0 {
            frame.kind = Kind::Remote { length: self.code(code)?.min(8) as u8 };
            return Ok(Some(0));
        }
        if !is_fd_length(length) {
            return Err(Reason::FdLength(length));
        }
        frame.kind = Kind::Fd { flags };
        self.payload(data, length, frame)?;
        Ok(Some(length))
    }

    /// An identifier, with an `x` after an extended one.
    fn identifier(&self, word: &[u8]) -> Result<Id, Reason> {
        let extended = word.strip_suffix(b"x").or(word.strip_suffix(b"X"));
        let digits = extended.unwrap_or(word);
        let expected = "an identifier in the base of the log, with x after an extended one";
        let value = value(digits, self.base)
            .ok_or(Reason::Expected { found: Found::first(word), expected })?;
        match extended {
            Some(_) => Id::extended(value).ok_or(Reason::ExtendedRange(value)),
            None => Id::standard(value).ok_or(Reason::StandardRange(value)),
        }
    }

    /// A data length code.
    fn code(&self, word: &[u8]) -> Result<usize, Reason> {
        let code = value(word, self.base).filter(|code| *code <= 15);
        let expected = "a data length code of 0 to 15 in the base of the log";
        code.map(|code| code as usize)
            .ok_or(Reason::Expected { found: Found::first(word), expected })
    }

    /// Reads the payload of `announced` bytes; what follows is of no interest.
    fn payload(&self, text: &[u8], announced: usize, frame: &mut Frame) -> Result<(), Reason> {
        let mut rest = text;
        for (found, byte) in frame.buffer_mut().iter_mut().take(announced).enumerate() {
            // Nearly always there are a blank and two digits.
            if let ([b' ', high, low, behind @ ..], 16) = (rest, self.base)
                && behind.first().is_none_or(is_blank)
                && let Some(value) = hex::byte([*high, *low])
            {
                (*byte, rest) = (value, behind);
                continue;
            }
            let (word, behind) = token(rest);
            if word.is_empty() {
                return Err(Reason::LengthMismatch { announced, found });
            }
            let expected = "a byte of data in the base of the log";
            *byte = value(word, self.base)
                .and_then(|value| u8::try_from(value).ok())
                .ok_or(Reason::Expected { found: Found::first(word), expected })?;
            rest = behind;
        }
        Ok(())
    }
}

/// The identifier at the end of the line of a frame that has a name in its place: `… BitCount = 84 ID = 513`, in decimal,
/// with an `x` after an extended one.
fn named_identifier(text: &[u8]) -> Option<Id> {
    let at = text.windows(ID.len()).rposition(|word| word.eq_ignore_ascii_case(ID))?;
    let (sign, rest) = token(&text[at + ID.len()..]);
    let (word, _) = token(rest);
    let extended = word.strip_suffix(b"x").or(word.strip_suffix(b"X"));
    let value = value(extended.unwrap_or(word), 10).filter(|_| sign == b"=")?;
    if extended.is_some() { Id::extended(value) } else { Id::standard(value) }
}

fn error(frame: &mut Frame) -> Result<usize, Reason> {
    frame.id = Id::extended(BUS_ERROR).ok_or(Reason::ExtendedRange(BUS_ERROR))?;
    frame.kind = Kind::Error;
    Ok(0)
}

/// A whole number in `base`; `None` for anything else, and beyond 32 bits.
fn value(digits: &[u8], base: u32) -> Option<u32> {
    let digit = |byte: &u8| char::from(*byte).to_digit(base);
    let add = |value: u32, byte: &u8| value.checked_mul(base)?.checked_add(digit(byte)?);
    Some(digits).filter(|digits| !digits.is_empty())?.iter().try_fold(0, add)
}
