//! The sea and the vessel in it: waves of a JONSWAP spectrum, and the motion that they cause in
//! six degrees of freedom, as a sum of components.
//!
//! A seed fixes frequencies and phases. [`Sea::advance`] advances by one sample and allocates
//! nothing.

mod motion;
mod spectrum;
mod vessel;

pub use motion::{Motion, Sea};
pub use spectrum::{COMPONENTS, Component, Spectrum};
pub use vessel::{Response, Vessel};

/// Standard gravity, m/s².
pub const GRAVITY: f64 = 9.80665;

/// Why a sea cannot exist.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SeaError {
    #[error("the significant wave height is {0} m, expected 0 to 20")]
    Height(f64),
    #[error("the peak period is {0} s, expected 2 to 30")]
    Period(f64),
}
