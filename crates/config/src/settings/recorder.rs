//! `[recorder]`: the flight recorder.

use crate::kinds::{DURATION, number, text, whole};
use crate::schema::{Kind, Limits, Scalar, table};
use crate::text::TextRule;

/// Longest time before or after an incident, s: all of it is in memory until it is written.
const LONGEST: f64 = 300.0;

/// The word for all frames of the bus.
const ALL: &str = "all";

table! {
    /// The flight recorder: the frames around each incident, in a folder of its own.
    pub struct Recorder = RECORDER {
        folder: Option<String> = None => text(TextRule::Path),
            "\"/var/lib/tertius/recordings\"",
            "the folder for the recordings of incidents, relative to this file; absent: nothing is recorded";
        before: f64 = 30.0 => number(Limits::least(0.0, DURATION).most(LONGEST)),
            "30.0", "frames are recorded from this long before an incident began, s";
        after: f64 = 30.0 => number(Limits::least(0.0, DURATION).most(LONGEST)),
            "30.0", "frames are recorded until this long after an incident was opened, s";
        size: u32 = 500 => whole(1, 1_000_000, "what all recordings together take on the disk"),
            "500", "the largest size of all recordings, MB; the oldest ones give way";
        frames: String = "used".to_owned() => Kind::One(Scalar::Choice(&["used", ALL])),
            "\"used\"", "which frames are recorded: those that the gateway uses, or all of the bus";
    }
}

impl Recorder {
    /// Whether all frames of the bus are recorded.
    pub fn records_all(&self) -> bool {
        self.folder.is_some() && self.frames == ALL
    }
}
