//! What a monitor counts.

/// What the monitor counts of the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Frames that the monitor listens to.
    pub used: u64,
    /// Frames of other identifiers, remote frames and error frames.
    pub ignored: u64,
    /// Of these, error frames.
    pub errors: u64,
    /// Cycles that opened.
    pub cycles: u64,
    /// Of these, cycles in which something configured did not arrive.
    pub incomplete: u64,
    /// Cycles that should have opened and did not.
    pub missing: u64,
    /// Frames that came when their cycle was decided: after its deadline, or in a later cycle.
    pub late: u64,
    /// Frames that came twice.
    pub repeated: u64,
    /// Frames that came before their cycle opened, and were kept for it.
    pub held: u64,
    /// Signals that their frame was too short for, or whose value is not a finite number.
    pub bad_signals: u64,
    /// Frames with a time stamp before the one before.
    pub backwards: u64,
    /// Jumps in time after which everything started anew.
    pub time_jumps: u64,
    /// Times that the bus was lost, after which everything started anew.
    pub interruptions: u64,
}
