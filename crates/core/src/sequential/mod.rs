//! Beyond fixed thresholds: sequential detection, and which transducer it is.
//!
//! ```text
//! C1, C2 ─→ reference ─ residual ─→ baseline ─→ noise, novelty ─→ windows ─→ statistic (GLR) ─ h ─→ alarm
//!    └────→ pair (with u) ─ innovations ──────────────────────────────────────→ suspect, kind
//! ```
//!
//! A threshold on one sample finds millimetres. Here the evidence of all windows up to 1024 samples
//! is weighed, in nats, against what the calibration has seen of healthy residuals: a mean that
//! moved ([`statistic`]), or a spread that grew. Residuals are weighed by what they scatter by at their
//! velocity ([`noise`]), no sample proves more than a wild one does ([`wild`]), and what is in all
//! cylinders alike and goes with the velocity is a matter of time ([`sampling`]). The level h is one number, from the wanted rate of
//! false alarms. Which transducer it is, is told only where the evidence is there: steps and noise
//! by the command ([`pair`]); a slow drift stays undecided, because in the closed loop the machine
//! follows it. A gain that is off is told by its going with the length ([`scale`]). Memory is
//! bounded, and a step allocates nothing.

pub mod alarm;
pub mod archive;
pub mod baseline;
pub mod clip;
pub mod coverage;
pub mod dependence;
pub mod detector;
pub mod drive;
pub mod dwell;
pub mod history;
pub mod kind;
pub mod motion;
pub mod noise;
pub mod novelty;
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
pub use dwell::Dwell;
pub use history::{DwellHistory, Gauging};
pub use noise::Noise;
pub use pair::{Pair, PairDesign};
pub use parameters::Parameters;
pub use rate::{Magnitudes, Rate};
pub use reference::Reference;
pub use sampling::{Apart, Sampling};
pub use scale::Scale;
pub use stops::{Blame, Judgement};
pub use trend::{Forecast, Limits, Trend};
pub use witness::Claim;

/// The level h, nats, at which a healthy machine of `cylinders` that is read every `sample_time`
/// seconds and always judged has `per_year` false alarms a year at the most.
///
/// At each sample the statistic of one window is beyond h with a probability of exp(−h) at most
/// (Chernoff); neighbouring windows and samples say nearly the same, so that this many are not
/// added up. What a recording shows is by a few nats better.
pub fn level(per_year: f64, cylinders: u8, sample_time: f64) -> f64 {
    libm::log(f64::from(cylinders) / sample_time / per_second(per_year))
}
