//! The calibration of C2: a and b of Ĉ2 = a·C2 + b (5-20) on the first part of a recording, and the
//! band that R3 then keeps on the second, as in Figures 5-14 and 5-15.
//!
//! A [`Course`] reads the recording as often as that needs, with memory that does not grow: [`Gathering`] looks at what is
//! there and finds a line that a few faulty samples do not move, on samples thinned to a bounded
//! number; [`Fitting`] is the least squares of all samples near that line; [`Trying`] is the band.
//! For the sequential detector [`Profiling`] fits, in one reading more, what the difference is along
//! the stroke, [`Spreading`] sees, together with the band, how its scatter goes with the velocity, and
//! [`Scattering`], in another one, what is left of it.

mod course;
mod fitting;
mod gathering;
mod line;
mod profile;
mod refusal;
mod residuals;
mod resolution;
mod scatter;
mod spreading;
mod trying;

pub use course::{Calibrated, Course, Recording};
pub use fitting::{Fitted, Fitting};
pub use gathering::Gathering;
pub use line::{Line, Robust};
pub use profile::{LEAST_SAMPLES, Profile, Profiling};
pub use refusal::Refusal;
pub use scatter::{Scatter, Scattering};
pub use spreading::{Spread, Spreading};
pub use trying::{Tried, Trying};

use crate::survey::Window;
use crate::time::Timestamp;
use crate::tune::sequential::Level;

/// The result for a machine.
#[derive(Clone, Debug)]
pub struct Calibration {
    pub machine: String,
    /// The recordings' names.
    pub inputs: String,
    /// Time stamp of the recording's first frame.
    pub first: Timestamp,
    /// The part that the lines were fitted on, and the part that the band is from.
    pub fitted: Window,
    pub tried: Window,
    /// Of every configured cylinder, from 1.
    pub cylinders: Vec<CylinderCalibration>,
    /// What is proposed for R3; `None` where there is not enough of it.
    pub bound: Option<Bound>,
    /// Of the sequential detectors, where the recording asks for a higher one than the wanted rate of
    /// false alarms does by itself: its residuals have bursts that belong together.
    pub level: Option<Level>,
    pub remarks: Vec<String>,
}

#[derive(Clone, Debug)]
pub struct CylinderCalibration {
    /// Of the readings, s.
    pub sample_time: f64,
    pub number: u8,
    pub result: Result<Fitted, Refusal>,
    /// On the second part; `None` without a fit.
    pub tried: Option<Tried>,
    /// For the sequential detector; `None` where there was too little.
    pub sequential: Option<(Profile, Scatter)>,
    pub remarks: Vec<String>,
}

/// The bound of R3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// m.
    pub level: f64,
    /// How often it is expected to be exceeded, all cylinders together, in a year.
    pub per_year: f64,
    /// The largest |R3| of the second part, m.
    pub worst: f64,
    /// The time it was made from, all cylinders together, h.
    pub hours: f64,
    /// A heavy tail was found on one cylinder at least.
    pub heavy: bool,
}
