//! What the commands that read recordings share of their options.

use crate::bus::TimeStamps;
use clap::ValueEnum;

/// Help for an argument that names recordings, which may also be `packed` so.
pub fn recordings(packed: &str) -> String {
    let formats = crate::bus::format_names();
    format!("Recordings, read in turn, in any of these formats: {formats}; may be .gz{packed}")
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StampOption {
    /// Determined from the time stamps
    Auto,
    /// Time of day (candump -ta, -tA)
    Absolute,
    /// Time since the previous frame (candump -td)
    Delta,
    /// Time since the first frame (candump -tz)
    Zero,
}

impl From<StampOption> for TimeStamps {
    fn from(stamps: StampOption) -> Self {
        match stamps {
            StampOption::Auto => Self::Auto,
            StampOption::Absolute => Self::Absolute,
            StampOption::Delta => Self::Delta,
            StampOption::Zero => Self::Zero,
        }
    }
}
