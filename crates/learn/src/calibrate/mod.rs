//! The calibration of C2: a and b of Ĉ2 = a·C2 + b (5-20) on one part of a recording, and the band that
//! R3 then keeps on another, as in Figures 5-14 and 5-15; or blocks of both alternate ([`Division`]).
//!
//! A [`Course`] reads the recording as often as that needs, with memory that does not grow: [`Gathering`] looks at what is
//! there and finds a line that a few faulty samples do not move, on samples thinned to a bounded
//! number; [`Fitting`] is the least squares of all samples near that line; [`Trying`] is the band.
//! For the sequential detector [`Profiling`] fits, in one reading more, what the difference is along
//! the stroke, [`Spreading`] sees, together with the band, how its scatter goes with the velocity, and
//! [`Scattering`], in another one, what is left of it. The detectors that follow are tried on the
//! recording at last: what contradicts them is cut out once, and otherwise told ([`Contradiction`]).

mod course;
mod cutting;
mod division;
mod driving;
mod finding;
mod fitting;
mod gathering;
mod judging;
mod line;
mod predicting;
mod profile;
mod refusal;
mod residuals;
mod resolution;
mod roughness;
mod scatter;
mod smoothing;
mod spreading;
mod trying;
pub mod watch;

pub use crate::survey::Recording;
pub use course::{Calibrated, Course};
pub use cutting::{Cuts, Cutting};
pub(crate) use cutting::{are_few, places};
pub use division::{Division, Halves};
pub use finding::Contradiction;
pub use fitting::{Fitted, Fitting};
pub use gathering::Gathering;
pub use line::{Line, Robust};
pub use profile::{Profile, Profiling};
pub use refusal::Refusal;
pub use scatter::{Scatter, Scattering};
pub use spreading::{Spread, Spreading};
pub use trying::{Tried, Trying};

use crate::survey::{Timeline, Window};

/// The result for a machine.
#[derive(Clone, Debug)]
pub struct Calibration {
    pub machine: String,
    /// The recordings' names.
    pub inputs: String,
    /// Where the recording's frames are in time.
    pub timeline: Timeline,
    /// The part that the lines were fitted on, and the part that the band is from.
    pub fitted: Window,
    pub tried: Window,
    /// Of every configured cylinder, from 1.
    pub cylinders: Vec<CylinderCalibration>,
    /// What is proposed for R3; `None` where there is not enough of it.
    pub bound: Option<Bound>,
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
    /// For the sequential detector; `None` where there was too little, or the recording contradicts it.
    pub sequential: Option<(Profile, Scatter)>,
    /// Of the sequential detector, nats; `None` where the wanted rate alone makes it.
    pub level: Option<f64>,
    /// Why the detector has no tables although there was enough to make them from.
    pub contradiction: Option<Contradiction>,
    /// Times, s, that do not look healthy, and from which nothing was learnt.
    pub left_out: Vec<[f64; 2]>,
    pub remarks: Vec<String>,
}

/// The bound of R3 that the thesis has, m: less is not asked for.
pub const LEAST_BOUND: f64 = 1.5e-3;

/// A bound is at most this part of the difference at which the machine itself trips.
pub const LARGEST_BOUND: f64 = 0.1;

/// The bound of R3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// m.
    pub level: f64,
    /// How often [`LEAST_BOUND`] is expected to be exceeded, all cylinders together, in a year.
    pub often: f64,
    /// Cylinders that it is of.
    pub cylinders: usize,
    /// How often it is expected to be exceeded, all cylinders together, in a year.
    pub per_year: f64,
    /// The largest |R3| of the second part, m.
    pub worst: f64,
    /// The time it was made from, all cylinders together, h.
    pub hours: f64,
    /// A heavy tail was found on one cylinder at least.
    pub heavy: bool,
}
