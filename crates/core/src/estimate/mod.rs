//! The virtual third sensor: each cylinder's length with its standard deviation, every cycle.
//!
//! ```text
//! C1 ─────────→ filter ─┐
//! C2 ─→ scale → filter ─┴─ those that are trusted ─→ carrier ─→ length, σ, valid
//! u(k) ─→ dynamics ──────────────────────────────────→ (alone)
//! ```
//!
//! Each transducer has a Kalman filter of its own ([`filter`]), so that the errors of a transducer
//! before it was blamed stay in its own filter and are dropped with it. The estimate is the mean of
//! the trusted transducers, or a single one. Where neither has a reading, the length is predicted
//! from the command ([`dynamics`]), and its standard deviation grows by the error that the same
//! prediction had while there were readings to compare it with ([`growth`]); no figure of the model
//! is trusted. Where no transducer is left because both are blamed, the prediction starts from a
//! second earlier, since the last estimate includes their errors. If it is configured, a transducer whose step stood still
//! is read less that step instead, and no longer than its innovations are small.
//!
//! Lengths are on the scale of C1, whose own error is not known.
//!
//! *Undecided* means that one of the two is wrong by an unknown amount. The mean of both is then
//! wrong by half of their difference, in one direction or the other, so half of the difference is
//! the standard deviation of a choice between them. It is always a part of σ; while a transducer is
//! suspected, the largest value of the last second is used.

mod accommodation;
mod carrier;
pub mod dynamics;
pub mod filter;
pub mod growth;
pub(crate) mod mean;
pub mod parameters;
pub mod scale;
pub mod sensor;

use crate::state::{choice, whole};
pub use accommodation::AccommodationDesign;
pub use dynamics::{Drive, Dynamics};
pub use parameters::EstimateParameters;
pub use scale::LengthScale;
pub use sensor::{SensorDesign, SensorInput, VirtualSensor};

/// Source of an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    Both,
    C1,
    C2,
    /// Prediction by the command alone.
    Model,
    /// C1 less the step that it stands off by.
    C1Corrected,
    /// The same of C2.
    C2Corrected,
}

choice! { Source { Both, C1, C2, Model, C1Corrected, C2Corrected } }

impl Source {
    /// Name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Both => "both",
            Self::C1 => "c1",
            Self::C2 => "c2",
            Self::Model => "model",
            Self::C1Corrected => "c1_corrected",
            Self::C2Corrected => "c2_corrected",
        }
    }
}

/// Estimated length of a cylinder in one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Length, m, on the scale of C1.
    pub position: f64,
    /// Standard deviation of the length, m.
    pub sigma: f64,
    pub source: Source,
    /// Whether there is evidence for the estimate, σ is within its bound, and the length is within
    /// the stroke.
    pub valid: bool,
    /// Time since a trusted transducer was read, s.
    pub without: f64,
}

whole! { Estimate { position, sigma, source, valid, without } }
