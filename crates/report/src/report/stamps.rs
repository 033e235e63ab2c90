//! Time stamps that cannot be those of the frames that have them.

use super::counted;
use tertius_core::monitor::Counts;
use tertius_core::time::{Span, Timestamp};
use tertius_recordings::Statistics;

/// Least time that counts from 1970: nine digits of seconds.
const LEAST_ABSOLUTE: Timestamp = Timestamp::from_nanos(100_000_000_000_000_000);
/// One in so many frames is before the frame ahead of it where each counts from that one, at the least.
const BACKWARDS: u64 = 8;
/// Fewest frames by which that is known.
const FRAMES: u64 = 50;
/// Fewest jumps of the time stamps, and of which number of cycles one is a jump at the least, where a logger has written
/// in pieces: a clock is not set that often, and no observer settles between the jumps.
const JUMPS: [u64; 2] = [8, 100];
/// Fewest where all of them go back, as frames that were written late do. Who sets a clock sets it forward, too.
const BACK: u64 = 2;
/// Most time from one frame to the next, where a counter of time stamps began again between them.
const BETWEEN: Span = Span::from_nanos(100_000_000);
/// Times after which counters begin again, ns, and whose they are.
const WRAPS: [(i64, &str); 6] = [
    (1 << 32, "a counter of 32 bits of ns"),
    (60_000_000_000, "the counter of an SLCAN adapter"),
    (65_536_000_000, "a counter of 16 bits of ms"),
    ((1 << 32) * 1000, "a counter of 32 bits of µs"),
    (86_400_000_000_000, "a time of day"),
    ((1 << 32) * 1_000_000, "a counter of 32 bits of ms"),
];

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
    let least = if counts.backwards == counts.time_jumps { BACK } else { least };
    if counts.backwards >= least && counts.time_jumps >= least.max(counts.cycles / of_cycles) {
        return Some(format!(
            "the time stamps go back {}, as where a logger writes some frames later than others: put the frames in order, \
             with tertius convert RECORDING all.log, then sort -s -k 1,1 all.log > sorted.log",
            super::wording::times(counts.backwards),
        ));
    }
    None
}

/// Jumps of the time stamps that are those of a counter which began again, by `WRAPS`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wraps([u64; WRAPS.len()]);

impl Wraps {
    /// Takes a jump of the time stamps `by` so much.
    pub fn take(&mut self, by: Span) {
        let is = |(nanos, _): &(i64, &str)| {
            (0..=BETWEEN.as_nanos()).contains(&by.as_nanos().saturating_add(*nanos))
        };
        if let Some(place) = WRAPS.iter().position(is) {
            self.0[place] += 1;
        }
    }

    /// What the counters were, where there are any.
    pub fn remarks(&self) -> impl Iterator<Item = String> {
        let counted = WRAPS.iter().zip(self.0).filter(|(_, count)| *count > 0);
        counted.map(|((nanos, whose), count)| {
            format!(
                "the time stamps: {whose} began again {}, so that each time what follows is stamped {} s too early. The observers \
                 settled anew, and nothing of it is a fault of the machine",
                super::wording::times(count),
                Span::from_nanos(*nanos).as_seconds(),
            )
        })
    }
}
