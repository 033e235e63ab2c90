//! The calibration of C2: a and b of Ĉ2 = a·C2 + b (5-20) on one part of a recording, and the band
//! of R3 on another, as in Figures 5-14 and 5-15. The two parts may also be alternating blocks
//! ([`Division`]).
//!
//! A [`CalibrationCourse`] reads the recording several times, in bounded memory. [`Gathering`] checks the data
//! and finds a line that a few faulty samples do not move, on samples thinned to a bounded number.
//! [`Fitting`] is the least squares of all samples near that line, and [`Trying`] finds the band.
//! For the sequential detector [`Profiling`] fits, in another pass, the difference along the
//! stroke; that pass also looks for a step of the difference that lasts. [`Spreading`], in the same
//! pass as the band, finds how its scatter depends on the velocity, and [`Scattering`], in one more
//! pass, the distribution of what is left. Finally the resulting detectors are tried on the
//! recording: what contradicts them is cut out once, and otherwise reported ([`Contradiction`]).

mod bound;
mod constancy;
mod course;
mod cutting;
mod division;
mod driving;
mod finding;
mod fitting;
mod fluctuating;
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
pub use bound::{Bound, LARGEST_BOUND, LEAST_BOUND};
pub use course::{Calibrated, CalibrationCourse};
pub use cutting::{Cuts, Cutting};
pub(crate) use cutting::{are_few, places};
pub use division::{Division, Halves};
pub use finding::{Contradiction, ENOUGH, too_short};
pub use fitting::{Fitted, Fitting};
pub use fluctuating::LearntExcursions;
pub use gathering::Gathering;
pub use line::{Line, Robust};
pub use profile::{Profile, Profiling};
pub use refusal::CalibrationRefusal;
pub use scatter::{Scatter, Scattering};
pub use spreading::{ResidualSpread, Spreading};
pub use trying::{TriedBand, Trying};

use crate::relate::{LearntProcess, ProcessRefusal};
use crate::survey::{Timeline, Window};
use tertius_config::settings::SupplyTable;

/// Result for a machine.
#[derive(Clone, Debug)]
pub struct Calibration {
    pub machine: String,
    /// Names of the recordings.
    pub inputs: String,
    /// Times of the recording's frames.
    pub timeline: Timeline,
    /// Part of the recording that the lines were fitted on.
    pub fitted: Window,
    /// Part of the recording that the band is from.
    pub tried: Window,
    /// Results of all configured cylinders, from cylinder 1.
    pub cylinders: Vec<CylinderCalibration>,
    /// Proposed bound of R3; `None` where there are not enough data.
    pub bound: Option<Bound>,
    /// What the supply's pressure does by what all rods take; `None` where the configuration does not name it.
    pub supply: Option<Result<SupplyTable, ProcessRefusal>>,
    pub remarks: Vec<String>,
}

#[derive(Clone, Debug)]
pub struct CylinderCalibration {
    /// Sample time of the readings, s.
    pub sample_time: f64,
    pub number: u8,
    pub result: Result<Fitted, CalibrationRefusal>,
    /// Validation on the second part; `None` without a fit.
    pub tried: Option<TriedBand>,
    /// Tables of the sequential detector; `None` where there were not enough data, or the recording
    /// contradicts them.
    pub sequential: Option<(Profile, Scatter)>,
    /// Level of the sequential detector, nats; `None` where it follows from the wanted rate alone.
    pub level: Option<f64>,
    /// Why the detector has no tables although there were enough data.
    pub contradiction: Option<Contradiction>,
    /// What spool and pressures say of each other; `None` where the configuration does not name them.
    pub process: Option<LearntProcess>,
    /// Times that do not look healthy and from which nothing was learnt, s.
    pub left_out: Vec<[f64; 2]>,
    pub remarks: Vec<String>,
}
