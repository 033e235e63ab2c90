//! What the commands share that pass frames on from a recording to another.

use crate::bus::Statistics;
use crate::text::counted;

/// Determines the interface of the newest frame from the counts of the recording.
#[derive(Default)]
pub struct Newest {
    frames: Vec<u64>,
}

impl Newest {
    /// The interface whose count grew; `None` for one beyond those that are told apart.
    pub fn interface<'a>(&mut self, statistics: &'a Statistics) -> Option<&'a str> {
        self.frames.resize(statistics.interfaces.len(), 0);
        let mut newest = None;
        for (known, interface) in self.frames.iter_mut().zip(&statistics.interfaces) {
            if *known != interface.frames {
                *known = interface.frames;
                newest = Some(interface.name.as_str());
            }
        }
        newest
    }
}

/// Reports the numbers of frames, on standard error, since the recording may be on standard output.
pub fn report(read: u64, written: u64, statistics: &Statistics) {
    tell!("{} read, {written} written", counted(read, "frame"));
    if statistics.bad_lines > 0 {
        let were = if statistics.bad_lines == 1 {
            "was not a frame and is"
        } else {
            "were not frames and are"
        };
        tell!("{} {were} left out", counted(statistics.bad_lines, "line"));
        statistics.first_bad_lines.iter().for_each(|line| tell!("  {line}"));
    }
}
