//! Identifies the recordings that were learnt, so that none counts twice.

use crate::survey::LONGEST_PAUSE;
use crc::{CRC_32_ISO_HDLC, Crc, Digest};
use tertius_core::frame::{Frame, Kind};
use tertius_core::time::Timestamp;

static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// A stretch of a recording without a long pause; a recording of several days has several parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Time stamp of the first frame.
    pub first: Timestamp,
    /// Latest time stamp.
    pub last: Timestamp,
    /// Number of frames that the configuration reads.
    pub frames: u64,
    /// CRC-32 of their time stamps, identifiers and payloads.
    pub crc: u32,
}

/// A part that overlaps in time with one that was learnt, but differs from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clash {
    pub part: Part,
    pub known: Part,
}

impl Part {
    /// Whether a frame with this time stamp may belong to it.
    pub fn holds(&self, at: Timestamp) -> bool {
        self.first <= at && at <= self.last
    }

    /// Whether the same part is among the `known`.
    ///
    /// # Errors
    /// It overlaps with another one: the same recording was cut differently, or a clock
    /// was set.
    pub fn is_among(&self, known: &[Self]) -> Result<bool, Clash> {
        let at_once = |known: &&Self| known.first <= self.last && self.first <= known.last;
        match known.iter().find(at_once) {
            None => Ok(false),
            Some(known) if known == self => Ok(true),
            Some(known) => Err(Clash { part: *self, known: *known }),
        }
    }
}

/// Divides the frames that the configuration reads into parts.
#[derive(Default)]
pub struct Parting {
    done: Vec<Part>,
    open: Option<(Part, Digest<'static, u32>)>,
}

impl Parting {
    /// Takes the next frame.
    pub fn take(&mut self, frame: &Frame) {
        let at = frame.timestamp;
        if self.open.as_ref().is_some_and(|(part, _)| at.since(part.last) > LONGEST_PAUSE) {
            self.close();
        }
        let empty = || (Part { first: at, last: at, frames: 0, crc: 0 }, CRC.digest());
        let (part, digest) = self.open.get_or_insert_with(empty);
        part.first = part.first.min(at);
        part.last = part.last.max(at);
        part.frames += 1;
        digest.update(&at.as_nanos().to_le_bytes());
        digest.update(&frame.id.to_dbc().to_le_bytes());
        let kind = if frame.kind == Kind::Data { 0 } else { 1 };
        digest.update(&[kind, frame.length() as u8]);
        digest.update(frame.data());
    }

    /// All parts, in the order in which they came.
    pub fn finish(mut self) -> Vec<Part> {
        self.close();
        self.done
    }

    fn close(&mut self) {
        if let Some((part, digest)) = self.open.take() {
            self.done.push(Part { crc: digest.finalize(), ..part });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tertius_core::frame::Id;

    fn parts(stamps: &[i64], payload: u8) -> Vec<Part> {
        let id = Id::standard(0x181).expect("11 bits");
        let mut parting = Parting::default();
        for seconds in stamps {
            let at = Timestamp::from_nanos(seconds * 1_000_000_000);
            parting.take(&Frame::new(at, id, Kind::Data, &[payload]));
        }
        parting.finish()
    }

    #[test]
    fn days_are_parts_and_the_same_one_is_known_again() {
        let both = parts(&[0, 60, 120, 86_400, 86_401], 1);
        assert_eq!(both.iter().map(|part| part.frames).collect::<Vec<_>>(), [3, 2]);
        let again = parts(&[86_400, 86_401], 1);
        assert_eq!(again[0].is_among(&both), Ok(true));
        assert_eq!(parts(&[200, 201], 1)[0].is_among(&both), Ok(false));
        // The same time and other frames, or more of them.
        for other in [parts(&[86_400, 86_401], 2), parts(&[86_390, 86_400, 86_401], 1)] {
            let clash = other[0].is_among(&both).expect_err("they are not the same");
            assert_eq!(clash.known, both[1]);
        }
    }
}
