//! Counts that a monitor keeps.

use crate::state::whole;

/// Counts of the frames and cycles of a monitor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Frames that the monitor uses.
    pub used: u64,
    /// Frames of other identifiers, remote frames and error frames.
    pub ignored: u64,
    /// Error frames, which `ignored` includes.
    pub errors: u64,
    /// Cycles that opened.
    pub cycles: u64,
    /// Cycles in which something configured did not arrive.
    pub incomplete: u64,
    /// Cycles that should have opened and did not.
    pub missing: u64,
    /// Frames that came when their cycle was already decided: after its deadline, or in a later
    /// cycle.
    pub late: u64,
    /// Frames that came twice.
    pub repeated: u64,
    /// Frames that contradict another one, with the same count and another payload.
    pub contradicting: u64,
    /// Frames that are too short for what is configured of them.
    pub short: u64,
    /// Seconds in which Sync was missing or too frequent.
    pub sync_doubted: u64,
    /// Frames that came before their cycle opened, and were kept for it.
    pub held: u64,
    /// Signals for which the frame was too short, or whose value is not a finite number.
    pub bad_signals: u64,
    /// Bits of status signals that were set without a meaning in the configuration, each of a transducer counted once.
    pub unnamed_status_bits: u64,
    /// Frames with a time stamp earlier than that of the previous frame.
    pub backwards: u64,
    /// Jumps in time, after which everything restarted.
    pub time_jumps: u64,
    /// Losses of the bus, after which everything restarted.
    pub interruptions: u64,
}

whole! {
    Counts {
        used, ignored, errors, cycles, incomplete, missing, late, repeated, contradicting, short, sync_doubted, held,
        bad_signals, unnamed_status_bits, backwards, time_jumps, interruptions,
    }
}
