//! What incidents are told apart by: every number of the family, with its unit and source.

/// All of them. They were chosen on simulated machines.
#[derive(Clone, Debug, PartialEq)]
pub struct IncidentParameters {
    /// Cycles within which what several cylinders show has one cause, and for which an incident is held back until it is
    /// known whether others show the same, 1 to 10: a frame that is late is missed in this cycle or in the next one.
    pub moment: u32,
    /// Least number of cylinders that have something in common, …
    pub least: usize,
    /// … and the part of the machine's cylinders that has to be exceeded, 0 to 1: most of them.
    pub most: f64,
    /// Time after which what a single cylinder is left with is its own, s: that of a warning to clear.
    pub alone: f64,
    /// The same of a slow drift, s: transducers warm within minutes of each other, and cool likewise.
    pub alone_drift: f64,
}

impl IncidentParameters {
    pub const DEFAULT: Self =
        Self { moment: 2, least: 2, most: 0.5, alone: 1.0, alone_drift: 300.0 };
}
