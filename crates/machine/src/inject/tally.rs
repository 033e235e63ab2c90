//! What became of a fault.

/// Counts of frames in the time of one fault.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Frames that carried the signal.
    pub frames: u64,
    /// Of these, frames that the fault changed or dropped.
    pub altered: u64,
    /// Of these, frames in which the value was beyond what the signal's bits can hold: the nearest
    /// that they can was written, or nothing where it was not a number. Where several faults meet
    /// in one signal, each counts it.
    pub clamped: u64,
    /// Frames of the message that did not carry the signal: too short, or another multiplexed
    /// signal in its place. They are passed on untouched.
    pub absent: u64,
}
