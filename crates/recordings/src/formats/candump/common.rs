//! A fast reader for the most common line of a recording, which does not search for its end:
//! `(1700000000.000516) can0 181#E02D00000000`. Other lines are left to [`super::Line`], which
//! reads these lines the same way.

use tertius_core::frame::{BusNumber, Frame, Id, Kind, MAX_DATA};
use tertius_core::time::Timestamp;

use crate::formats::hex;

/// Number of bytes that must be available so that no access beyond the end needs a check; more than
/// the longest line read here.
const WINDOW: usize = 64;
/// Most bytes of a classic frame.
const MAX_CLASSIC: usize = 8;
/// Length of the longest payload with its line end, characters.
const LONGEST_DATA: usize = 2 * MAX_CLASSIC + 2;
/// Length of `(1700000000.`.
const PREFIX: usize = 12;
/// Position of the interface, after `(1700000000.000516) `.
const NAME: usize = PREFIX + 8;
/// First second that counts from 1970 in any case: [`super::clock::StampClock`] reads earlier ones.
const FIRST_SECOND: i64 = super::clock::LEAST_ABSOLUTE / NANOS_PER_SECOND;
/// Last second all of whose nanoseconds are in range.
const LAST_SECOND: i64 = i64::MAX / NANOS_PER_SECOND - 1;
const NANOS_PER_SECOND: i64 = 1_000_000_000;

/// An interface that was seen before.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// Index in the list of interfaces.
    pub place: usize,
    /// Whether its frames are returned.
    pub wanted: bool,
    /// Bus that it is.
    pub bus: BusNumber,
}

/// Reads lines that begin like the previous one: the same second, the same interface.
#[derive(Debug)]
pub struct Common {
    /// The first eight and the next four bytes.
    prefix: (u64, u32),
    /// The second that they state, in nanoseconds.
    base: i64,
    /// The interface and the blank after it.
    name: u64,
    /// Mask of the significant bytes of `name`.
    mask: u64,
    /// Number of these bytes, at most eight.
    name_length: u8,
    interface: Known,
}

impl Common {
    pub fn new() -> Self {
        // No line has a zero byte first and none equals one under an empty mask.
        let interface = Known { place: 0, wanted: false, bus: BusNumber::First };
        Self { prefix: (0, 0), base: 0, name: 1, mask: 0, name_length: 0, interface }
    }

    /// The interface of the lines that [`Self::read`] reads.
    #[inline(always)]
    pub fn interface(&self) -> Known {
        self.interface
    }

    /// Reads the line at the start of `text` into `frame`, if it begins like the previous one;
    /// returns its length with its line end. `None`, with `frame` undefined, if it is another line,
    /// or too near the end of `text`.
    #[inline(always)]
    pub fn read(&self, text: &[u8], frame: &mut Frame) -> Option<usize> {
        let window: &[u8; WINDOW] = text.first_chunk()?;
        if prefix(window)? != self.prefix {
            return None;
        }
        let fraction = hex::six_decimals(word(window, PREFIX)?)?;
        if word(window, NAME)? & self.mask != self.name {
            return None;
        }
        self.read_frame(window, NAME, fraction, frame)
    }

    /// Reads a line that differs only in its second or its interface, or has nine decimals. `find`
    /// looks interfaces up.
    #[inline(never)]
    pub fn read_new(
        &mut self,
        text: &[u8],
        frame: &mut Frame,
        find: impl FnOnce(&[u8]) -> Option<Known>,
    ) -> Option<usize> {
        let window: &[u8; WINDOW] = text.first_chunk()?;
        if prefix(window)? != self.prefix {
            self.learn_second(window)?;
        }
        let (fraction, name_at) = match hex::six_decimals(word(window, PREFIX)?) {
            Some(nanos) => (nanos, NAME),
            None => (nine_decimals(window)?, NAME + 3),
        };
        if word(window, name_at)? & self.mask != self.name {
            self.learn_interface(window, name_at, find)?;
        }
        self.read_frame(window, name_at, fraction, frame)
    }

    /// Reads the rest of the line after the interface, which is at `name_at`.
    #[inline(always)]
    fn read_frame(
        &self,
        window: &[u8; WINDOW],
        name_at: usize,
        fraction: u32,
        frame: &mut Frame,
    ) -> Option<usize> {
        let id_at = name_at + usize::from(self.name_length);
        let (id, data_at) = identifier(window, id_at)?;
        let rest: &[u8; LONGEST_DATA] = chunk(window, data_at)?;
        let length = payload(rest, frame.buffer_mut());
        let end = 2 * length;
        let ending = match (rest[end], rest[end + 1]) {
            (b'\n', _) => 1,
            (b'\r', b'\n') => 2,
            _ => return None,
        };
        frame.set_length(length);
        frame.timestamp = Timestamp::from_nanos(self.base + i64::from(fraction));
        frame.bus = self.interface.bus;
        frame.id = id;
        frame.kind = Kind::Data;
        Some(data_at + end + ending)
    }

    /// Takes the second from the line; `None` if it has another form.
    #[cold]
    fn learn_second(&mut self, window: &[u8; WINDOW]) -> Option<()> {
        let [b'(', digits @ .., b'.'] = window.first_chunk::<PREFIX>()? else { return None };
        let mut second = 0;
        for digit in digits {
            second = second * 10 + i64::from(char::from(*digit).to_digit(10)?);
        }
        if !(FIRST_SECOND..=LAST_SECOND).contains(&second) {
            return None;
        }
        self.base = second * NANOS_PER_SECOND;
        self.prefix = prefix(window)?;
        Some(())
    }

    /// Takes the interface from the line; `None` if it is not known or its name too long.
    #[inline(never)]
    fn learn_interface(
        &mut self,
        window: &[u8; WINDOW],
        at: usize,
        find: impl FnOnce(&[u8]) -> Option<Known>,
    ) -> Option<()> {
        let name: &[u8; 8] = chunk(window, at)?;
        let length = name.iter().position(|byte| *byte == b' ')?;
        self.interface = find(&name[..length])?;
        self.name_length = length as u8 + 1;
        self.mask = u64::MAX >> (64 - 8 * self.name_length);
        self.name = word(window, at)? & self.mask;
        Some(())
    }
}

/// Nine decimals after the prefix, as written for a clock in the controller.
#[inline(never)]
fn nine_decimals(window: &[u8; WINDOW]) -> Option<u32> {
    let last = hex::six_decimals(word(window, PREFIX + 3)?)? / 1000;
    let first = window.get(PREFIX..PREFIX + 3)?;
    let add = |value, digit: &u8| Some(value * 10 + char::from(*digit).to_digit(10)?);
    Some(first.iter().try_fold(0, add)? * 1_000_000 + last)
}

#[inline(always)]
fn identifier(window: &[u8; WINDOW], at: usize) -> Option<(Id, usize)> {
    let [first, second, third, b'#'] = *chunk(window, at)? else {
        return extended_identifier(window, at);
    };
    let id = Id::standard(hex::three([first, second, third])?.into())?;
    Some((id, at + 4))
}

#[inline(never)]
fn extended_identifier(window: &[u8; WINDOW], at: usize) -> Option<(Id, usize)> {
    let digits = word(window, at)?;
    if *window.get(at + 8)? != b'#' || hex::leading_digits(digits) != 8 {
        return None;
    }
    Some((Id::extended(hex::bytes(digits).swap_bytes())?, at + 9))
}

/// Reads digits in pairs, up to eight bytes or the first pair that is no byte, and returns the
/// number of bytes.
#[inline(always)]
fn payload(text: &[u8; LONGEST_DATA], bytes: &mut [u8; MAX_DATA]) -> usize {
    // As pairs, so that each is one load. Iterators zipped and counted here cost ten instructions a
    // byte more.
    let (pairs, _) = text.as_chunks();
    for place in 0..MAX_CLASSIC {
        match hex::byte(pairs[place]) {
            Some(byte) => bytes[place] = byte,
            None => return place,
        }
    }
    MAX_CLASSIC
}

#[inline(always)]
fn prefix(window: &[u8; WINDOW]) -> Option<(u64, u32)> {
    Some((word(window, 0)?, u32::from_le_bytes(*chunk(window, 8)?)))
}

/// Eight bytes as a word, the first lowest.
#[inline(always)]
fn word(window: &[u8; WINDOW], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(*chunk(window, at)?))
}

/// The bytes from `at` on, with one comparison, where a slice of the rest and a chunk of that need
/// two.
#[inline(always)]
fn chunk<const N: usize>(window: &[u8; WINDOW], at: usize) -> Option<&[u8; N]> {
    window.get(at..at + N)?.first_chunk()
}
