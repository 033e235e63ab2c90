//! What the observers are judged by, beside their thresholds and gains, which are configured.

/// Numbers of the observers and of what their innovations may still have of the past.
#[derive(Clone, Debug, PartialEq)]
pub struct ObserverParameters {
    /// Part of its first effect on the innovation below which a missed correction no longer matters; 0.05 to 0.3.
    pub recovered: f64,
    /// Times that an observer takes to settle after which nothing is left of what it began with; 3 to 10.
    pub forgotten: u32,
}

impl ObserverParameters {
    /// The same for every machine.
    pub const DEFAULT: Self = Self { recovered: 0.1, forgotten: 5 };
}
