//! What a recording contains that a healthy cylinder does not show, in words.

use super::watch::{OwnLevel, Sight};
use crate::extremes::{Asked, LARGEST_LEVEL};
use std::fmt;

/// Judged time from which on a recording can tell a cylinder that is not healthy from tables that too little has taught,
/// s. Of the built-in machine 3 min have all six cylinders contradicted, 5 min three of them, and 8 min none; a cylinder
/// with a fault is named from ten minutes on.
pub const ENOUGH: f64 = 540.0;

/// Evidence that contradicts the theory of a healthy cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contradiction {
    pub worst: Sight,
    pub asked: Asked,
}

impl Contradiction {
    pub fn of(level: &OwnLevel) -> Option<Self> {
        Some(Self { worst: level.contradiction()?, asked: level.asked? })
    }

    /// Judged time, s, if there is too little of it to say that the cylinder is not healthy.
    pub fn too_short(&self) -> Option<f64> {
        Some(self.asked.seconds).filter(|seconds| *seconds < ENOUGH)
    }
}

impl fmt::Display for Contradiction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Sight { nats, t, length, width, scatter, .. } = self.worst;
        let what = if scatter { "a scatter that grew" } else { "a mean that moved" };
        let most = LARGEST_LEVEL;
        let seen = format!(
            "{nats:.1} nats of evidence at {t:.1} s, C1 at {length:.3} m, by {what} over {width} samples"
        );
        if let Some(seconds) = self.too_short() {
            return write!(
                f,
                "{:.1} min are too few to say whether it is healthy. What one half of them taught does not hold for the \
                 other half, by the shortness or by a fault: {seen}",
                seconds / 60.0
            );
        }
        write!(f, "this is not a recording of a healthy cylinder: {seen}")?;
        if self.asked.nats > most {
            write!(
                f,
                "; to tolerate it, a level of {:.0} nats would be needed, and beyond {most} the \
                 detector would hardly find any fault",
                self.asked.nats
            )?;
        }
        f.write_str(
            "; look there (`replay --report`) for a fault, spikes, a stop or a valve that sticks, and \
             leave that part out (--from, --to)",
        )
    }
}

/// That `seconds` of judged time are too few, and how long to record.
pub fn too_short(seconds: f64) -> String {
    format!(
        "the recording is too short: {:.1} min of it could be judged, and {:.0} min are needed; record a quarter of an \
         hour of the machine at work",
        seconds / 60.0,
        ENOUGH / 60.0
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use tertius_core::time::Timestamp;

    fn contradiction(seconds: f64) -> Contradiction {
        let at = Timestamp::default();
        let worst = Sight { nats: 31.3, t: 115.6, at, length: 0.088, width: 12, scatter: true };
        let asked = Asked {
            nats: 43.0,
            floor: 5.0,
            slope: 1.0,
            peaks: 5,
            worst: 31.3,
            seconds,
            least: 15.0,
            slower: None,
        };
        Contradiction { worst, asked }
    }

    #[test]
    fn a_short_recording_accuses_no_cylinder() {
        let told = contradiction(168.0).to_string();
        assert!(told.starts_with("2.8 min are too few to say whether it is healthy."), "{told}");
        assert!(told.contains("31.3 nats of evidence at 115.6 s"), "{told}");
        assert!(!told.contains("not a recording of a healthy cylinder"), "{told}");
        let told = contradiction(880.0).to_string();
        assert!(
            told.starts_with("this is not a recording of a healthy cylinder: 31.3 nats"),
            "{told}"
        );
        assert!(told.contains("a level of 43 nats would be needed"), "{told}");
    }
}
