//! What is asked of a recording.

use super::format::TimeStamps;
use super::selection::Interfaces;

/// Options for reading a recording.
#[derive(Clone, Debug, Default)]
pub struct Options {
    pub time_stamps: TimeStamps,
    /// Interfaces whose frames are returned; the others are counted.
    pub interfaces: Interfaces,
}
