//! The file format of what is kept.
//!
//! ```text
//! tertius learnt 1
//! machine Ampelmann E-type
//! seals 0f3a9c1e 1b2c3d4e 5f607182 93a4b5c6
//! part 1700000000123456789 1700000899987654321 1080000 8d7c6b5a
//! …
//! piece 1700000000123456789 1700000059987654321 72000 251234
//! …
//! data 3768510
//! (the bytes of the pieces, one after the other)
//! crc32 0f3a9c1e
//! ```
//!
//! A part is its first and last time stamp, ns since 1970, its frames, and their CRC-32; a piece its time
//! stamps, frames, and bytes. The last line is over all bytes before it.

use super::piece::MOST_FRAMES;
use super::{Learnt, MOST_BYTES, MOST_PARTS, Part, Piece, Seals};
use crc::{CRC_32_ISO_HDLC, Crc};
use std::fmt::Write as _;
use tertius_core::time::Timestamp;
use thiserror::Error;

/// Version of this format; a newer one may mean anything.
const VERSION: u32 = 1;

/// Text with which every version begins.
pub const MAGIC: &str = "tertius learnt ";

/// Largest file, bytes: all pieces, with their lines and those of the parts.
pub const MAX_SIZE: usize = MOST_BYTES + (4 << 20);

/// Most characters of a line that are shown.
const SHOWN: usize = 60;

/// CRC-32 of Ethernet and zip.
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Why bytes are not the file of a machine.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Refusal {
    #[error("it does not begin with `tertius learnt`: something else is in it")]
    Foreign,
    #[error("it has version {0}, this program knows {VERSION}: a newer one wrote it")]
    Newer(u32),
    #[error("its content is not what was written: it was changed or truncated")]
    Changed,
    #[error("line {line} is {found:?}, expected {expected}")]
    Line { line: usize, found: String, expected: &'static str },
    #[error("it is longer than {MAX_SIZE} bytes")]
    TooLong,
}

impl Learnt {
    /// The bytes to write.
    pub fn to_bytes(&self) -> Vec<u8> {
        let Self { machine, seals, parts, pieces } = self;
        let [readings, model, weights, calibration] = seals.all();
        // Writing to a string cannot fail.
        let mut text = format!(
            "{MAGIC}{VERSION}\nmachine {machine}\n\
             seals {readings:08x} {model:08x} {weights:08x} {calibration:08x}\n"
        );
        for Part { first, last, frames, crc } in parts {
            let [first, last] = [first, last].map(|at| at.as_nanos());
            _ = writeln!(text, "part {first} {last} {frames} {crc:08x}");
        }
        for piece in pieces {
            let [first, last] = [piece.first(), piece.last()].map(Timestamp::as_nanos);
            _ = writeln!(text, "piece {first} {last} {} {}", piece.frames(), piece.bytes());
        }
        _ = writeln!(text, "data {}", self.bytes());
        let mut bytes = text.into_bytes();
        pieces.iter().for_each(|piece| bytes.extend(piece.packed()));
        bytes.push(b'\n');
        let seal = seal(&bytes);
        bytes.extend(seal.as_bytes());
        bytes
    }

    /// Reads the bytes back.
    ///
    /// # Errors
    /// What was found and what was expected, for any bytes.
    pub fn parse(bytes: &[u8]) -> Result<Self, Refusal> {
        let version = bytes.strip_prefix(MAGIC.as_bytes()).ok_or(Refusal::Foreign)?;
        let version = version.split(|byte| *byte == b'\n').next().unwrap_or_default();
        let version = std::str::from_utf8(version).ok().and_then(|it| it.parse().ok());
        match version {
            Some(VERSION) => {}
            Some(newer) if newer > VERSION => return Err(Refusal::Newer(newer)),
            _ => return Err(Refusal::Changed),
        }
        if bytes.len() > MAX_SIZE {
            return Err(Refusal::TooLong);
        }
        let seal_begins = bytes.len().checked_sub(SEAL).ok_or(Refusal::Changed)?;
        let (body, found) = bytes.split_at(seal_begins);
        if seal(body).as_bytes() != found {
            return Err(Refusal::Changed);
        }
        Lines { rest: body, line: 0 }.learnt()
    }
}

/// Length of the last line.
const SEAL: usize = "crc32 01234567\n".len();

fn seal(body: &[u8]) -> String {
    format!("crc32 {:08x}\n", CRC.checksum(body))
}

/// Text that is left to be read.
struct Lines<'a> {
    rest: &'a [u8],
    /// Number of the newest line, counted from 1.
    line: usize,
}

impl<'a> Lines<'a> {
    fn learnt(mut self) -> Result<Learnt, Refusal> {
        let mut learnt = Learnt::default();
        _ = self.after(MAGIC, "`tertius learnt`")?;
        self.after("machine ", "`machine` and its name")?.clone_into(&mut learnt.machine);
        let seals = self.after("seals ", "`seals` and four of them")?;
        let all: Option<Vec<u32>> = seals.split(' ').map(hexadecimal).collect();
        let all = all.and_then(|all| all.try_into().ok());
        let wrong = |found| self.wrong(found, "`seals` and four of them");
        learnt.seals = Seals::of_parts(all.ok_or_else(|| wrong(seals))?);
        let mut heads = Vec::new();
        let length = loop {
            let line = self.next()?;
            let expected = "a part, a piece, or `data` and its length";
            let (kind, values) = line.split_once(' ').unwrap_or_default();
            let known = match kind {
                "part" if learnt.parts.len() < MOST_PARTS => {
                    part(values).map(|it| learnt.parts.push(it))
                }
                "piece" => head(values).map(|it| heads.push(it)),
                "data" => match values.parse::<usize>() {
                    Ok(length) => break length,
                    Err(_) => None,
                },
                _ => None,
            };
            known.ok_or_else(|| self.wrong(line, expected))?;
        };
        let whole: usize = heads.iter().map(|(.., bytes)| bytes).sum();
        if whole != length || self.rest.len() != length + 1 {
            return Err(Refusal::Changed);
        }
        for (ends, frames, bytes) in heads {
            let (packed, rest) = self.rest.split_at(bytes);
            self.rest = rest;
            learnt.pieces.push(Piece::of_parts(ends, frames, packed.to_vec()));
        }
        Ok(learnt)
    }

    fn next(&mut self) -> Result<&'a str, Refusal> {
        self.line += 1;
        let end = self.rest.iter().position(|byte| *byte == b'\n').ok_or(Refusal::Changed)?;
        let (line, rest) = self.rest.split_at(end);
        self.rest = &rest[1..];
        std::str::from_utf8(line).map_err(|_| Refusal::Changed)
    }

    /// The rest of the next line after `prefix`.
    fn after(&mut self, prefix: &str, expected: &'static str) -> Result<&'a str, Refusal> {
        let line = self.next()?;
        line.strip_prefix(prefix).ok_or_else(|| self.wrong(line, expected))
    }

    /// The error in the newest line.
    fn wrong(&self, found: &str, expected: &'static str) -> Refusal {
        Refusal::Line { line: self.line, found: found.chars().take(SHOWN).collect(), expected }
    }
}

fn hexadecimal(text: &str) -> Option<u32> {
    u32::from_str_radix(text, 16).ok()
}

fn part(values: &str) -> Option<Part> {
    let mut words = values.split(' ');
    let [first, last] = [stamp(words.next()?)?, stamp(words.next()?)?];
    let (frames, crc) = (words.next()?.parse().ok()?, hexadecimal(words.next()?)?);
    words.next().is_none().then_some(Part { first, last, frames, crc })
}

/// Time stamps, frames and bytes of a piece.
fn head(values: &str) -> Option<([Timestamp; 2], u32, usize)> {
    let mut words = values.split(' ');
    let ends = [stamp(words.next()?)?, stamp(words.next()?)?];
    let (frames, bytes): (u32, usize) = (words.next()?.parse().ok()?, words.next()?.parse().ok()?);
    let sound = words.next().is_none() && frames as usize <= MOST_FRAMES && bytes <= MOST_BYTES;
    sound.then_some((ends, frames, bytes))
}

fn stamp(text: &str) -> Option<Timestamp> {
    text.parse().ok().map(Timestamp::from_nanos)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learnt::{Packing, Parting};
    use tertius_core::frame::{Frame, Id, Kind};

    fn learnt() -> Learnt {
        let id = Id::standard(0x181).expect("11 bits");
        let (mut packing, mut parting) = (Packing::default(), Parting::default());
        for k in 0..9000_i64 {
            let at = Timestamp::from_nanos(k * 20_000_000);
            let frame = Frame::new(at, id, Kind::Data, &(k * k).to_le_bytes());
            packing.take(&frame);
            parting.take(&frame);
        }
        let mut learnt = Learnt {
            machine: "A\u{b5} machine".to_owned(),
            seals: Seals::of_parts([1, 2, 3, u32::MAX]),
            ..Learnt::default()
        };
        learnt.add(parting.finish(), packing.finish());
        learnt
    }

    #[test]
    fn what_is_read_back_is_what_was_written() {
        for learnt in [learnt(), Learnt::default()] {
            assert_eq!(Learnt::parse(&learnt.to_bytes()), Ok(learnt));
        }
    }

    /// Every bit of every byte is changed, and the file is cut at every place.
    #[test]
    fn whatever_is_changed_is_noticed() {
        let whole = learnt().to_bytes();
        for at in (0..whole.len()).step_by(7).chain(whole.len() - 40..whole.len()) {
            let mut changed = whole.clone();
            changed[at] ^= 1 << (at % 8);
            assert!(Learnt::parse(&changed).is_err(), "byte {at}");
            assert!(Learnt::parse(&whole[..at]).is_err(), "cut at {at}");
        }
        let newer = b"tertius learnt 2\nwhatever\n";
        assert_eq!(Learnt::parse(newer), Err(Refusal::Newer(2)));
        assert_eq!(Learnt::parse(b"[machine]\n"), Err(Refusal::Foreign));
    }
}
