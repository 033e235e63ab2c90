//! Time stamps that cannot be those of the frames that have them.

use super::counted;
use crate::bus::Statistics;
use crate::monitor::Counts;
use crate::time::{Span, Timestamp};

/// Least time that counts from 1970: nine digits of seconds.
const LEAST_ABSOLUTE: Timestamp = Timestamp::from_nanos(100_000_000_000_000_000);
/// One in so many frames is before the frame ahead of it where each counts from that one, at the least.
const BACKWARDS: u64 = 8;
/// Fewest frames by which that is known.
const FRAMES: u64 = 50;
/// Fewest jumps of the time stamps, and of which number of cycles one is a jump at the least, where a logger has written
/// in pieces: a clock is not set that often, and no observer settles between the jumps.
const JUMPS: [u64; 2] = [8, 100];

/// The time of a recording.
#[derive(Clone, Copy, Debug)]
pub struct Stamped {
    /// Time stamp of the first frame.
    pub first: Timestamp,
    /// Time from there to the last one.
    pub length: Span,
}

/// Why the time stamps are of no use, and what to do; `None` where they are.
pub fn unusable(
    statistics: &Statistics,
    counts: &Counts,
    Stamped { first, length }: Stamped,
) -> Option<String> {
    let frames = statistics.frames - statistics.other_interface_frames;
    if frames > 1 && length == Span::ZERO && counts.backwards == 0 {
        return Some(
            "every frame has the same time stamp, so it was recorded without time stamps, or with those of a controller \
             that has none (candump -H): record without -H"
                .to_owned(),
        );
    }
    let is_short = first < LEAST_ABSOLUTE && first.after(length) < LEAST_ABSOLUTE;
    if is_short && counts.used >= FRAMES && counts.backwards >= counts.used / BACKWARDS {
        return Some(format!(
            "{} of {} have an earlier time stamp than a frame ahead of them, as where each counts from the frame before: \
             replay with --time-stamps delta",
            counts.backwards,
            counted(counts.used, "frame"),
        ));
    }
    let [least, of_cycles] = JUMPS;
    if counts.backwards >= least && counts.time_jumps >= least.max(counts.cycles / of_cycles) {
        return Some(format!(
            "the time stamps go back {}, as where a logger writes some frames later than others: put the frames in order, \
             with tertius convert RECORDING all.log, then sort -s -k 1,1 all.log > sorted.log",
            super::wording::times(counts.backwards),
        ));
    }
    None
}
