//! Converts the time stamps in the lines to instants.

use tertius_core::frame::Frame;
use tertius_core::time::Timestamp;

use super::{Extent, Line, Reason, TimeStamps, Unread, blank_frame};
use crate::format::End;
use crate::limits::MAX_LINE;

/// Number of lines by which `-td` and `-tz` are told apart.
const VOTERS: usize = 64;
/// Number of bytes examined for them: enough for that many lines of any length.
const HORIZON: usize = VOTERS * MAX_LINE;

/// Least time that counts from 1970, ns: nine digits of seconds. What is padded with zeros to as many may still be a
/// time since the previous line.
pub(super) const LEAST_ABSOLUTE: i64 = 100_000_000_000_000_000;

/// Meaning of the short time stamps of one input.
#[derive(Debug)]
enum Meaning {
    /// Not yet decided, after examining some of the lines or none.
    Undecided(Vote),
    AsTheyStand,
    /// In the console form each counts from the previous line.
    ConsoleDelta,
    /// In both forms each counts from the previous line.
    Delta,
}

/// Converts the time stamps of one input to instants.
#[derive(Debug)]
pub struct StampClock {
    meaning: Meaning,
    /// Sum of the deltas, ns.
    elapsed: i64,
}

impl StampClock {
    pub fn new(option: TimeStamps) -> Self {
        let meaning = match option {
            TimeStamps::Auto => Meaning::Undecided(Vote::default()),
            TimeStamps::Absolute | TimeStamps::Zero => Meaning::AsTheyStand,
            TimeStamps::Delta => Meaning::Delta,
        };
        Self { meaning, elapsed: 0 }
    }

    /// Whether the line can be placed in time only after [`Self::look_ahead`].
    pub fn must_look_ahead(&self, line: &Line<'_>) -> bool {
        matches!(self.meaning, Meaning::Undecided(_)) && line.is_short_console()
    }

    /// Examines the unread bytes, which begin with the line that must wait. Returns false if it must be
    /// called again with more bytes behind the same ones.
    pub fn look_ahead(&mut self, unread: Unread<'_>) -> bool {
        if let Meaning::Undecided(vote) = &mut self.meaning {
            match vote.count(unread.bytes, unread.end != End::Open) {
                None => return false,
                Some(true) => self.meaning = Meaning::ConsoleDelta,
                Some(false) => self.meaning = Meaning::AsTheyStand,
            }
        }
        true
    }

    /// The line's instant. Must be called once for every line, even with a bad frame, because
    /// deltas add up.
    ///
    /// # Errors
    /// The sum of the deltas is out of range.
    pub fn instant(&mut self, line: &Line<'_>) -> Result<Timestamp, Reason> {
        let is_delta = match self.meaning {
            Meaning::ConsoleDelta => line.is_short_console(),
            Meaning::Delta => {
                line.stamp.extent == Extent::Short || line.stamp.nanos < LEAST_ABSOLUTE
            }
            Meaning::AsTheyStand | Meaning::Undecided(_) => false,
        };
        if !is_delta {
            return Ok(Timestamp::from_nanos(line.stamp.nanos));
        }
        self.elapsed = self.elapsed.checked_add(line.stamp.nanos).ok_or(Reason::StampRange)?;
        Ok(Timestamp::from_nanos(self.elapsed))
    }
}

/// Examination of the first lines with short time stamps.
#[derive(Debug, Default)]
struct Vote {
    /// Number of bytes examined, up to the start of a line.
    seen: usize,
    voters: usize,
    last: Option<i64>,
}

impl Vote {
    /// Whether they are deltas; `None` where more bytes are needed. The answer depends on the bytes
    /// alone, not on the sizes of the reads.
    fn count(&mut self, unread: &[u8], whole: bool) -> Option<bool> {
        let horizon = &unread[..unread.len().min(HORIZON)];
        let mut scratch = blank_frame();
        while self.voters < VOTERS {
            let rest = &horizon[self.seen..];
            let (length, taken) = match memchr::memchr(b'\n', rest) {
                Some(length) => (length, length + 1),
                None if whole && unread.len() < HORIZON => (rest.len(), rest.len()),
                None if unread.len() < HORIZON => return None,
                None => break,
            };
            if taken == 0 {
                break;
            }
            self.seen += taken;
            let Some(nanos) = voice(&rest[..length], &mut scratch) else { continue };
            if self.last.is_some_and(|last| nanos < last) {
                return Some(true);
            }
            self.last = Some(nanos);
            self.voters += 1;
        }
        Some(false)
    }
}

/// The time stamp of a good line of the console form, if it is short.
fn voice(text: &[u8], scratch: &mut Frame) -> Option<i64> {
    if text.len() > MAX_LINE {
        return None;
    }
    let line = Line::parse(text).ok()??;
    let counts = line.is_short_console() && line.read_frame(scratch).is_ok();
    counts.then_some(line.stamp.nanos)
}
