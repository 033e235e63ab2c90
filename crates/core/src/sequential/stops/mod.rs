//! The mechanical stops of a machine as a reference: which transducer's reading there has drifted.
//!
//! On the stops the rods stand where they stood, so that a reading that has changed is that of a
//! transducer that drifts. But temperature moves all of them, stops wear, and a slow drift is among the
//! first dwells already, so no reading is compared with the first ones. The readings of a day are one
//! ([`Day`]), what all cylinders do alike is their temperature and is taken off (`thermometer`), and
//! ramps and steps are fitted to the difference of the two transducers and to their mean (`fit`). Where
//! the difference has moved beyond chance, the one that has moved is named as soon as the mean of both
//! says clearly enough which of them it is (`rule`).

mod days;
mod fit;
mod parameters;
mod rule;
mod thermometer;

use super::history::DwellHistory;
use alloc::vec::Vec;
pub use days::Day;
pub(super) use days::put;
pub use fit::Scatter;
pub use parameters::StopParameters;
pub use rule::{Blame, Course, Judgement};

/// What the dwells of a machine say of each cylinder; `None` where too little was read.
pub fn judge<'a>(histories: impl IntoIterator<Item = &'a DwellHistory>) -> Vec<Option<Judgement>> {
    let coarse = |count: f64| if count > StopParameters::DEFAULT.dithered { count } else { 0.0 };
    let read = |history: &DwellHistory| (history.days(), coarse(history.gauging().count));
    let (days, counts): (Vec<Vec<Day>>, Vec<f64>) = histories.into_iter().map(read).unzip();
    rule::judge(&days, &counts)
}
