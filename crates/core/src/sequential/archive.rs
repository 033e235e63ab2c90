//! The file format in which the dwells of a whole machine are kept from one start to the next.
//!
//! ```text
//! tertius dwells 2
//! machine Ampelmann E-type
//! cylinder 1 dwells 20 count 0.000109 gain 1.0 offset -0.0021
//! 1700000000123456789 -1.4000123 -1.3900456 1
//! …
//! crc32 0f3a9c1e
//! ```
//!
//! The line of a dwell has its time, ns since 1970, the readings of C1 and C2, m, in the shortest
//! form that reads back the same, and the number of dwells of which it is the mean. `count` is the
//! resolution of the readings, m; `gain` and `offset` are a and b of (5-20), left out where they
//! are not known. In version 3 a dwell of a cylinder with one transducer has `-` for the reading of
//! C2; a machine without such a cylinder is written as version 2, which earlier programs read.
//! Version 1 had `cylinder 1 anchors 10 dwells 20` instead, no means, and up to 512
//! dwells; it can also be read. The checksum in the last line covers all bytes before it, because a
//! reading with a wrong digit would blame a sound transducer.

use super::dwell::{Dwell, StopReadings};
use super::history::{DwellHistory, Flaw, Gauging, MOST_READ};
use crate::time::Timestamp;
use alloc::borrow::ToOwned;
use alloc::format;
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;
use core::fmt::Write as _;
use crc::{CRC_32_ISO_HDLC, Crc};
use thiserror::Error;

/// Of the form above; a newer one may mean anything.
const VERSION: u32 = 3;

/// The one before, in which each dwell has a reading of C2.
const PAIRS_VERSION: u32 = 2;

/// The first one, which is read as well.
const FIRST_VERSION: u32 = 1;

/// The reading of a C2 that is not fitted.
const NO_READING: &str = "-";

/// The longest text that is one, bytes: six full cylinders have a quarter of it.
pub const MAX_SIZE: usize = 1 << 20;

/// Characters of a line that are shown.
const SHOWN: usize = 60;

/// CRC-32 of Ethernet and zip.
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// The dwells of a machine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Archive {
    /// Name of the machine.
    pub machine: String,
    /// History of each cylinder, in order.
    pub cylinders: Vec<DwellHistory>,
}

/// Why a text is not the archive of a machine.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Refusal {
    #[error("line {line} is {found:?}, expected {expected}")]
    Line { line: usize, found: String, expected: String },
    #[error(
        "line {line} begins the dwells of cylinder {cylinder}, which are not valid: expected {flaw}"
    )]
    Flaw { line: usize, cylinder: usize, flaw: Flaw },
    #[error(
        "its last line is {found:?}, but its content gives {expected:?}: it was changed or \
         truncated"
    )]
    Changed { found: String, expected: String },
    #[error("it has version {0}, this program knows {VERSION}: a newer one wrote it")]
    Newer(u32),
    #[error("it belongs to the machine {found:?}, expected {expected:?}")]
    Foreign { found: String, expected: String },
    #[error("it has cylinder {found}, the machine has {expected}")]
    Cylinders { found: usize, expected: usize },
    #[error("it is not text")]
    Binary,
    #[error("it is longer than {MAX_SIZE} bytes")]
    TooLong,
}

impl Archive {
    /// An archive of a machine of which nothing was read yet.
    pub fn new(machine: &str, cylinders: u8) -> Self {
        let cylinders = vec![DwellHistory::default(); usize::from(cylinders)];
        Self { machine: machine.to_owned(), cylinders }
    }

    pub fn is_empty(&self) -> bool {
        self.cylinders.iter().all(|history| history.dwells().is_empty())
    }

    /// The text to write.
    pub fn to_text(&self) -> String {
        let mut dwells = self.cylinders.iter().flat_map(DwellHistory::dwells);
        let is_single = dwells.any(|dwell| dwell.readings.c2.is_none());
        let version = if is_single { VERSION } else { PAIRS_VERSION };
        let mut text = format!("tertius dwells {version}\nmachine {}\n", self.machine);
        for (n, history) in (1..).zip(&self.cylinders) {
            let (dwells, Gauging { count, corrected }) = (history.dwells(), history.gauging());
            // Writing to a string cannot fail.
            _ = write!(text, "cylinder {n} dwells {} count {count:?}", dwells.len());
            if let Some([gain, offset]) = corrected {
                _ = write!(text, " gain {gain:?} offset {offset:?}");
            }
            text.push('\n');
            for (Dwell { at, readings }, of) in dwells.iter().zip(history.counts()) {
                let c2 = readings.c2.map_or(NO_READING.to_owned(), |c2| format!("{c2:?}"));
                _ = writeln!(text, "{} {:?} {c2} {of}", at.as_nanos(), readings.c1);
            }
        }
        let seal = seal(&text);
        text + &seal + "\n"
    }

    /// Reads a text back; `machine` and `cylinders` are those of the configuration.
    ///
    /// # Errors
    /// What was found and what was expected, for any bytes.
    pub fn parse(bytes: &[u8], machine: &str, cylinders: u8) -> Result<Self, Refusal> {
        if bytes.len() > MAX_SIZE {
            return Err(Refusal::TooLong);
        }
        let text = core::str::from_utf8(bytes).map_err(|_| Refusal::Binary)?;
        let mut lines = Lines { rest: text, line: 0 };
        let version = lines.after("tertius dwells ", "`tertius dwells` and a version")?;
        let version = match version.parse() {
            Ok(version @ FIRST_VERSION..=VERSION) => version,
            Ok(newer) if newer > VERSION => return Err(Refusal::Newer(newer)),
            _ => return Err(lines.wrong(version, "a version")),
        };
        check_seal(text)?;
        let found = lines.after("machine ", "`machine` and its name")?;
        if found != machine {
            return Err(Refusal::Foreign { found: shown(found), expected: machine.to_owned() });
        }
        let mut archive = Self::new(machine, cylinders);
        let mut count = 0;
        while lines.rest.starts_with("cylinder ") {
            count += 1;
            let history = lines.cylinder(count, version)?;
            let Some(place) = archive.cylinders.get_mut(count - 1) else {
                return Err(Refusal::Cylinders { found: count, expected: cylinders.into() });
            };
            *place = history;
        }
        lines.after("crc32 ", "the next cylinder, or the crc32 of the last line")?;
        if lines.rest.is_empty() { Ok(archive) } else { Err(lines.wrong(lines.rest, "no more")) }
    }
}

/// The last line of a text.
fn seal(body: &str) -> String {
    format!("crc32 {:08x}", CRC.checksum(body.as_bytes()))
}

fn check_seal(text: &str) -> Result<(), Refusal> {
    let whole = text.strip_suffix('\n');
    let begin = whole.and_then(|text| text.rfind('\n')).map_or(text.len(), |end| end + 1);
    let (body, found) = text.split_at(begin);
    let expected = seal(body);
    match found.strip_suffix('\n') {
        Some(found) if found == expected => Ok(()),
        _ => Err(Refusal::Changed { found: shown(found.trim_end()), expected }),
    }
}

/// Text that is left to be read.
struct Lines<'a> {
    rest: &'a str,
    /// Number of the newest line, counted from 1.
    line: usize,
}

impl<'a> Lines<'a> {
    fn next(&mut self) -> &'a str {
        let (line, rest) = self.rest.split_once('\n').unwrap_or((self.rest, ""));
        self.rest = rest;
        self.line += 1;
        line
    }

    /// The rest of the next line after `prefix`.
    fn after(&mut self, prefix: &str, expected: &str) -> Result<&'a str, Refusal> {
        let line = self.next();
        line.strip_prefix(prefix).ok_or_else(|| self.wrong(line, expected))
    }

    /// The next cylinder, which has to be number `n`.
    fn cylinder(&mut self, n: usize, version: u32) -> Result<DwellHistory, Refusal> {
        let heading = self.next();
        let begin = self.line;
        let read = if version == FIRST_VERSION { first_heading } else { self::heading };
        let known =
            read(heading).filter(|(number, dwells, _)| *number == n && *dwells <= MOST_READ);
        let Some((_, count, gauging)) = known else {
            let form = match version {
                FIRST_VERSION => "anchors A dwells D",
                _ => "dwells D count C gain A offset B",
            };
            let expected = format!("`cylinder {n} {form}`, D up to {MOST_READ}");
            return Err(self.wrong(heading, &expected));
        };
        let (mut dwells, mut counts) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for _ in 0..count {
            let line = self.next();
            let wrong = || {
                let of = if version == FIRST_VERSION { "" } else { ", and of how many dwells" };
                let none = if version == VERSION { ", `-` for no C2" } else { "" };
                self.wrong(line, &format!("a time in ns and two readings in m{none}{of}"))
            };
            let (dwell, of) = dwell(line, version).ok_or_else(wrong)?;
            dwells.push(dwell);
            counts.push(of);
        }
        let flawed = |flaw| Refusal::Flaw { line: begin, cylinder: n, flaw };
        DwellHistory::restore(dwells, counts, gauging).map_err(flawed)
    }

    /// The error in the newest line.
    fn wrong(&self, found: &str, expected: &str) -> Refusal {
        Refusal::Line { line: self.line, found: shown(found), expected: expected.to_owned() }
    }
}

/// The number after the next word, which has to be `name`.
fn named<T: core::str::FromStr>(words: &mut core::str::Split<'_, char>, name: &str) -> Option<T> {
    words.next().filter(|word| *word == name)?;
    words.next()?.parse().ok()
}

/// Number, dwells and gauging of a cylinder.
fn heading(line: &str) -> Option<(usize, usize, Gauging)> {
    let words = &mut line.split(' ');
    let (number, dwells) = (named(words, "cylinder")?, named(words, "dwells")?);
    let count = named(words, "count")?;
    let rest = words.clone().next().is_some();
    let corrected =
        if rest { Some([named(words, "gain")?, named(words, "offset")?]) } else { None };
    words.next().is_none().then_some((number, dwells, Gauging { count, corrected }))
}

/// Heading of a cylinder in version 1, which had no gauging; its anchors are no longer used.
fn first_heading(line: &str) -> Option<(usize, usize, Gauging)> {
    let words = &mut line.split(' ');
    let number = named(words, "cylinder")?;
    let _: usize = named(words, "anchors")?;
    let dwells = named(words, "dwells")?;
    words.next().is_none().then_some((number, dwells, Gauging::default()))
}

fn dwell(line: &str, version: u32) -> Option<(Dwell, u32)> {
    let mut words = line.split(' ');
    let at = Timestamp::from_nanos(words.next()?.parse().ok()?);
    let c1 = words.next()?.parse().ok()?;
    let c2 = match words.next()? {
        NO_READING if version == VERSION => None,
        word => Some(word.parse().ok()?),
    };
    let readings = StopReadings { c1, c2 };
    let of = if version == FIRST_VERSION { 1 } else { words.next()?.parse().ok()? };
    words.next().is_none().then_some((Dwell { at, readings }, of))
}

fn shown(text: &str) -> String {
    text.chars().take(SHOWN).collect()
}

#[cfg(test)]
mod tests;
