//! What a reading is worth before any model is asked.

/// The verdict of the plausibility checks. The order of the variants is the order of the checks:
/// the first that applies is the quality.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quality {
    /// Nothing speaks against the reading.
    Good,
    /// No new reading in this cycle, yet not for long enough to be [`Quality::Stale`].
    #[default]
    Missing,
    /// No new reading for longer than allowed.
    Stale,
    /// A code or status bit that means a broken wire or a failed sensor.
    BrokenWire,
    /// Outside the valid counts or the stroke.
    OutOfRange,
    /// Exactly constant while the command moves.
    Frozen,
}

impl Quality {
    /// Only good readings reach an estimator.
    pub const fn is_good(self) -> bool {
        matches!(self, Self::Good)
    }
}
