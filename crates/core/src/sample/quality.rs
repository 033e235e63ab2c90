//! Quality of a reading before any model is asked.

/// Verdict of the plausibility checks. The variants are in the order of the checks: the first that
/// applies is the quality.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quality {
    /// Nothing speaks against the reading.
    Good,
    /// There is no new reading in this cycle, but not for long enough to be [`Quality::Stale`].
    #[default]
    Missing,
    /// There has been no new reading for longer than allowed.
    Stale,
    /// A code or status bit means a broken wire or a failed sensor.
    BrokenWire,
    /// The reading is outside the valid counts or the stroke.
    OutOfRange,
    /// The reading is exactly constant while the command moves.
    Frozen,
}

impl Quality {
    /// Whether the reading is good; only good readings reach an estimator.
    pub const fn is_good(self) -> bool {
        matches!(self, Self::Good)
    }
}
