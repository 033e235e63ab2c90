//! The mechanical stops of a machine as a reference, to find the transducer whose reading has
//! drifted.
//!
//! On the stops the rods always stand in the same place, so that a changed reading means a drifting
//! transducer. But temperature moves all of them, stops wear, and a slow drift already affects the
//! first dwells, so no reading is compared with the first ones. The readings of a day are averaged
//! ([`Day`]), the movement common to all cylinders is their temperature and is subtracted
//! (`thermometer`), and ramps and steps are fitted to the difference of the two transducers and to
//! their mean (`fit`). Where the difference has moved beyond chance by any of them, the likeliest of
//! these is taken for what happened, and the transducer that has moved is named as soon as the mean
//! of both shows clearly enough which it is (`rule`).

mod days;
mod fit;
mod parameters;
mod rule;
mod thermometer;

use super::history::DwellHistory;
use alloc::vec::Vec;
pub use days::Day;
pub(super) use days::put;
pub use parameters::{Scatter, StopParameters};
pub use rule::{Blame, Course, Judgement};

/// Judgement of each cylinder from the dwells of a machine; `None` where too little was read.
pub fn judge<'a>(histories: impl IntoIterator<Item = &'a DwellHistory>) -> Vec<Option<Judgement>> {
    let coarse = |count: f64| if count > StopParameters::DEFAULT.dithered { count } else { 0.0 };
    let read = |history: &DwellHistory| (history.days(), coarse(history.gauging().count));
    let (days, counts): (Vec<Vec<Day>>, Vec<f64>) = histories.into_iter().map(read).unzip();
    rule::judge(&days, &counts)
}
