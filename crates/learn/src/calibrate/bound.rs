//! The bound of R3 that a recording gives.

/// Bound of R3 in the thesis, m; no smaller one is proposed.
pub const LEAST_BOUND: f64 = 1.5e-3;

/// Largest bound, as a part of the difference at which the machine itself trips.
pub const LARGEST_BOUND: f64 = 0.1;

/// Bound of R3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// Bound of |R3|, m.
    pub level: f64,
    /// Expected number of times a year that [`LEAST_BOUND`] is exceeded, all cylinders together.
    pub often: f64,
    /// Number of cylinders to which the bound applies.
    pub cylinders: usize,
    /// Expected number of times a year that the bound is exceeded, all cylinders together.
    pub per_year: f64,
    /// Largest |R3| of the second part, m.
    pub worst: f64,
    /// Time that the bound was made from, all cylinders together, h.
    pub hours: f64,
    /// Whether at least one cylinder has a heavy tail.
    pub heavy: bool,
}
