//! Sequential detection beyond fixed thresholds, and location of the faulty transducer.
//!
//! ```text
//! C1, C2 ─→ reference ─ residual ─→ baseline ─→ noise, thinning ─→ windows ─→ statistic (GLR) ─ h ─→ alarm
//!    └────→ pair (with u) ─ innovations ──────────────────────────────────────→ suspect, kind
//! ```
//!
//! A threshold on one sample finds millimetres. Here the evidence of all windows up to 1024
//! samples, in nats, is weighed against the healthy residuals of the calibration: evidence for a
//! mean that moved, or a spread that grew ([`statistic`]). Residuals are weighted by their scatter
//! at the present velocity ([`noise`]), no sample proves more than a wild one does ([`wild`]), and
//! a residual in proportion to the velocity in all cylinders alike is attributed to the sampling
//! times ([`sampling`]). The level h is one number, from the wanted rate of false alarms. The
//! faulty transducer is named only where there is evidence: for steps and noise by the command
//! ([`pair`]); a slow drift stays undecided, because in the closed loop the machine follows it. A
//! gain error is recognised by its proportion to the length ([`scale`]). Memory is bounded, and a
//! step allocates nothing.

pub mod alarm;
pub mod archive;
pub mod baseline;
pub mod clip;
pub mod coverage;
pub mod dependence;
pub mod detector;
pub mod drive;
pub mod dwell;
pub mod excursions;
pub mod history;
pub mod kind;
pub mod motion;
pub mod noise;
pub mod pair;
pub mod parameters;
pub mod rate;
pub mod reference;
pub mod samples;
pub mod sampling;
pub mod scale;
pub mod search;
pub mod skew;
pub mod statistic;
pub mod stops;
mod student;
pub mod tanh;
pub mod thinning;
pub mod trend;
pub mod velocity;
pub mod whitening;
pub mod wild;
pub mod windows;
pub mod witness;

use crate::time::per_second;
pub use alarm::{Alarm, Cause};
pub use archive::Archive;
pub use coverage::{Coverage, Unknown};
pub use detector::{Design, Input, Sequential};
pub use drive::Drive;
pub use dwell::{Dwell, StopReadings};
pub use excursions::ExcursionLimits;
pub use history::{DwellHistory, Gauging};
pub use noise::Noise;
pub use pair::{Pair, PairDesign};
pub use parameters::SequentialParameters;
pub use rate::{Magnitudes, Rate};
pub use reference::Reference;
pub use sampling::{Apart, Sampling};
pub use scale::Scale;
pub use stops::{Blame, Judgement};
pub use trend::{DriftLimits, Forecast, Trend};
pub use witness::Claim;

/// The level h, nats, at which a healthy machine of `cylinders` that is read every `sample_time`
/// seconds and always judged has at most `per_year` false alarms a year.
///
/// At each sample the statistic of one window is beyond h with a probability of exp(−h) at most
/// (Chernoff); neighbouring windows and samples are nearly the same, so that their number is not
/// added up. The level from a recording is better by a few nats.
pub fn level(per_year: f64, cylinders: u8, sample_time: f64) -> f64 {
    libm::log(f64::from(cylinders) / sample_time / per_second(per_year))
}
