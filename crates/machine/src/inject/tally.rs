//! What became of a fault.

/// Counts of frames during one fault.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Frames that carried the signal.
    pub frames: u64,
    /// Frames with the signal that the fault changed or dropped.
    pub altered: u64,
    /// Frames in which the value exceeded what the signal's bits can hold: the nearest possible
    /// value was written, or nothing if it was not a number. Where several faults meet in one
    /// signal, each counts such a frame.
    pub clamped: u64,
    /// Frames of the message without the signal, because they were too short or carried another
    /// multiplexed signal. They pass unchanged.
    pub absent: u64,
}
