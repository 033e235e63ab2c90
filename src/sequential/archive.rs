//! The dwells of a whole machine as they are kept from one start to the next.
//!
//! ```text
//! tertius dwells 1
//! machine Ampelmann E-type
//! cylinder 1 anchors 10 dwells 20
//! 1700000000123456789 -1.4000123 -1.3900456
//! …
//! crc32 0f3a9c1e
//! ```
//!
//! A dwell is its time, ns since 1970, and the readings of C1 and C2, m, in the shortest form that
//! reads back the same. The last line is over all bytes before it: a reading with a wrong digit would
//! blame a transducer that is sound.

use super::dwell::Dwell;
use super::history::{DwellHistory, Flaw, MOST};
use crate::time::Timestamp;
use crc::{CRC_32_ISO_HDLC, Crc};
use std::fmt::Write as _;
use thiserror::Error;

/// Of the form above; a newer one may mean anything.
const VERSION: u32 = 1;

/// The longest text that is one, bytes: six full cylinders have a quarter of it.
pub const MAX_SIZE: usize = 1 << 20;

/// Characters of a line that are shown.
const SHOWN: usize = 60;

/// CRC-32 of Ethernet and zip.
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// A machine's dwells.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Archive {
    /// The machine's name.
    pub machine: String,
    /// Of each cylinder, in their order.
    pub cylinders: Vec<DwellHistory>,
}

/// Why a text is not the archive of a machine.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Refusal {
    #[error("line {line} is {found:?}, expected {expected}")]
    Line { line: usize, found: String, expected: String },
    #[error(
        "line {line} begins the dwells of cylinder {cylinder}, which are none: expected {flaw}"
    )]
    Flaw { line: usize, cylinder: usize, flaw: Flaw },
    #[error(
        "its last line is {found:?} where its content makes {expected:?}: it was changed or cut"
    )]
    Changed { found: String, expected: String },
    #[error("it has version {0}, this program knows {VERSION}: a newer one wrote it")]
    Newer(u32),
    #[error("it is that of the machine {found:?}, expected {expected:?}")]
    Foreign { found: String, expected: String },
    #[error("it has cylinder {found}, the machine has {expected}")]
    Cylinders { found: usize, expected: usize },
    #[error("it is not text")]
    Binary,
    #[error("it is longer than {MAX_SIZE} bytes")]
    TooLong,
}

impl Archive {
    /// Of a machine of which nothing was read yet.
    pub fn new(machine: &str, cylinders: u8) -> Self {
        let cylinders = vec![DwellHistory::default(); usize::from(cylinders)];
        Self { machine: machine.to_owned(), cylinders }
    }

    pub fn is_empty(&self) -> bool {
        self.cylinders.iter().all(|history| history.dwells().is_empty())
    }

    /// The text to keep.
    pub fn to_text(&self) -> String {
        let mut text = format!("tertius dwells {VERSION}\nmachine {}\n", self.machine);
        for (n, history) in (1..).zip(&self.cylinders) {
            let (anchors, dwells) = (history.anchor_count(), history.dwells());
            // Writing to a string cannot fail.
            _ = writeln!(text, "cylinder {n} anchors {anchors} dwells {}", dwells.len());
            for Dwell { at, readings: [c1, c2] } in dwells {
                _ = writeln!(text, "{} {c1:?} {c2:?}", at.as_nanos());
            }
        }
        let seal = seal(&text);
        text + &seal + "\n"
    }

    /// Reads back a text; `machine` and `cylinders` are what the configuration says.
    ///
    /// # Errors
    /// What was found and what was expected, whatever the bytes are.
    pub fn parse(bytes: &[u8], machine: &str, cylinders: u8) -> Result<Self, Refusal> {
        if bytes.len() > MAX_SIZE {
            return Err(Refusal::TooLong);
        }
        let text = std::str::from_utf8(bytes).map_err(|_| Refusal::Binary)?;
        let mut lines = Lines { rest: text, line: 0 };
        let version = lines.after("tertius dwells ", "`tertius dwells` and a version")?;
        match version.parse() {
            Ok(VERSION) => {}
            Ok(newer) if newer > VERSION => return Err(Refusal::Newer(newer)),
            _ => return Err(lines.wrong(version, "a version")),
        }
        check_seal(text)?;
        let found = lines.after("machine ", "`machine` and its name")?;
        if found != machine {
            return Err(Refusal::Foreign { found: shown(found), expected: machine.to_owned() });
        }
        let mut archive = Self::new(machine, cylinders);
        let mut count = 0;
        while lines.rest.starts_with("cylinder ") {
            count += 1;
            let history = lines.cylinder(count)?;
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

/// What is left to be read.
struct Lines<'a> {
    rest: &'a str,
    /// Of the newest line, from 1.
    line: usize,
}

impl<'a> Lines<'a> {
    fn next(&mut self) -> &'a str {
        let (line, rest) = self.rest.split_once('\n').unwrap_or((self.rest, ""));
        self.rest = rest;
        self.line += 1;
        line
    }

    /// What follows `prefix` on the next line.
    fn after(&mut self, prefix: &str, expected: &str) -> Result<&'a str, Refusal> {
        let line = self.next();
        line.strip_prefix(prefix).ok_or_else(|| self.wrong(line, expected))
    }

    /// The next cylinder, which has to be number `n`.
    fn cylinder(&mut self, n: usize) -> Result<DwellHistory, Refusal> {
        let heading = self.next();
        let begin = self.line;
        let mut numbers = [0; 3];
        let mut words = heading.split(' ');
        for (name, number) in ["cylinder", "anchors", "dwells"].iter().zip(&mut numbers) {
            let found = words.next().filter(|word| word == name).and_then(|_| words.next());
            *number = found.and_then(|word| word.parse().ok()).unwrap_or(usize::MAX);
        }
        let [number, anchors, count] = numbers;
        let sound = number == n && anchors < usize::MAX && words.next().is_none();
        if !sound || count > MOST {
            let expected = format!("`cylinder {n} anchors A dwells D`, D up to {MOST}");
            return Err(self.wrong(heading, &expected));
        }
        let mut dwells = Vec::with_capacity(count);
        for _ in 0..count {
            let line = self.next();
            let wrong = || self.wrong(line, "a time in ns and two readings in m");
            dwells.push(dwell(line).ok_or_else(wrong)?);
        }
        DwellHistory::restore(dwells, anchors).map_err(|flaw| Refusal::Flaw {
            line: begin,
            cylinder: n,
            flaw,
        })
    }

    /// What is wrong with the newest line.
    fn wrong(&self, found: &str, expected: &str) -> Refusal {
        Refusal::Line { line: self.line, found: shown(found), expected: expected.to_owned() }
    }
}

fn dwell(line: &str) -> Option<Dwell> {
    let mut words = line.split(' ');
    let at = Timestamp::from_nanos(words.next()?.parse().ok()?);
    let readings = [words.next()?.parse().ok()?, words.next()?.parse().ok()?];
    words.next().is_none().then_some(Dwell { at, readings })
}

fn shown(text: &str) -> String {
    text.chars().take(SHOWN).collect()
}

#[cfg(test)]
mod tests;
