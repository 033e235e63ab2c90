//! Quality of a reading before any model is asked.

use crate::state::choice;

/// Verdict of the plausibility checks. From [`Quality::Failed`] on, the variants are in the order of the
/// checks: the first that applies is the quality.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quality {
    /// Nothing speaks against the reading.
    Good,
    /// There is no new reading in this cycle, but not for long enough to be [`Quality::Stale`].
    #[default]
    Missing,
    /// There is no new reading, because the device is not operational, as it says itself.
    NotOperational,
    /// Frames came that cannot be relied on: they contradict each other, or lack what is configured of them. Nobody can tell
    /// which of them is the transducer's, which is not to blame.
    Doubtful,
    /// The device says itself that it has an error.
    Failed,
    /// There has been no new reading for longer than allowed, or the device's heartbeat has stopped.
    Stale,
    /// A code or status bit means a broken wire or a failed sensor.
    BrokenWire,
    /// The reading is outside the valid counts or the stroke.
    OutOfRange,
    /// The reading is exactly constant while the command moves.
    Frozen,
}

choice! {
    Quality { Good, Missing, NotOperational, Doubtful, Failed, Stale, BrokenWire, OutOfRange, Frozen }
}

impl Quality {
    /// Number of qualities.
    pub const COUNT: usize = Self::Frozen as usize + 1;

    /// Whether the reading is good; only good readings reach an estimator.
    pub const fn is_good(self) -> bool {
        matches!(self, Self::Good)
    }
}
