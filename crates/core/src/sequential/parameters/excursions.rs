//! What of C1 − C2 no healthy excursions of a transducer explain.

/// The numbers of [`crate::sequential::excursions`], beside the limits that a calibration reckons.
#[derive(Clone, Debug, PartialEq)]
pub struct ExcursionParameters {
    /// Largest part of a sample's uncertainty that the limits allow for, m; 1e-5 to 1e-4, as their dead bands. Only what is more
    /// is taken off the sample.
    pub allowed_doubt: f64,
    /// Deviations of the noise beyond which a sample is off; 2.5 to 4. One in 370 of normal noise is.
    pub off: f64,
    /// From the lower end of one box of |C1 − C2| to that of the next, m; 5e-5 to 3e-4. A box is about four times as wide, so
    /// that a displacement is in three or four.
    pub spacing: f64,
}

impl ExcursionParameters {
    pub const DEFAULT: Self = Self { allowed_doubt: 3e-5, off: 3.0, spacing: 1.25e-4 };
}
