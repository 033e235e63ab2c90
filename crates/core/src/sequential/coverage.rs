//! Coverage of a detector: for how long it could judge, and why not otherwise.

use crate::state::{choice, whole};

/// Why a detector cannot judge a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknown {
    /// The platform is in no monitored state.
    NotMonitored,
    /// C1, C2 or the speed is missing or implausible.
    NoReading,
    /// The rod is where the calibration had no samples, or too few.
    NotCalibrated,
    /// The difference of C1 and C2 in this stretch of motion is still being learnt.
    NoBaseline,
}

choice! { Unknown { NotMonitored, NoReading, NotCalibrated, NoBaseline } }

impl Unknown {
    pub const ALL: [Self; 4] =
        [Self::NotMonitored, Self::NoReading, Self::NotCalibrated, Self::NoBaseline];

    /// Name in files and columns.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NotMonitored => "not_monitored",
            Self::NoReading => "no_reading",
            Self::NotCalibrated => "not_calibrated",
            Self::NoBaseline => "no_baseline",
        }
    }
}

/// Number of cycles in which a detector judged, and of those in which it did not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Coverage {
    pub judged: u64,
    /// Cycles in which it did not judge, in the order of [`Unknown::ALL`].
    pub unknown: [u64; Unknown::ALL.len()],
}

whole! { Coverage { judged, unknown } }

impl Coverage {
    /// Counts a cycle.
    pub const fn count(&mut self, unknown: Option<Unknown>) {
        match unknown {
            None => self.judged += 1,
            Some(why) => self.unknown[why as usize] += 1,
        }
    }
}
