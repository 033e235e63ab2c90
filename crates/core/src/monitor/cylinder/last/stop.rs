//! The last transducer on the mechanical stop, where it reads what it read there before.

use super::Cylinder;
use crate::observe::observer::Measurement;
use crate::state::whole;

/// Reading on the mechanical stop.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rest {
    /// Sum of the readings of this stay, m, and their number.
    pub sum: f64,
    pub count: u32,
    /// Mean of the last stay in which nothing was found, m.
    pub healthy: Option<f64>,
}

whole! { Rest { sum, count, healthy } }

impl Cylinder {
    /// Takes the readings on the mechanical stop.
    #[cold]
    pub(super) fn rest_last(&mut self, good: [Option<Measurement>; 2]) {
        for (rest, reading) in self.last.rests.iter_mut().zip(good) {
            let Some(reading) = reading else { continue };
            rest.sum += reading.position;
            rest.count = rest.count.saturating_add(1);
        }
        let agrees = |i: usize| {
            let Rest { sum, count, healthy } = self.last.rests[i];
            let mean = sum / f64::from(count.max(1));
            let enough = count >= self.design.observers[i].settle.max(1);
            enough && healthy.is_some_and(|it| (it - mean).abs() <= self.design.bank.observer.high)
        };
        // The deck's attitude finds an error of C1.
        let is_out = |i: usize| self.last.is_latched(i) || i == 0 && self.tilted.is_some();
        if (0..2).any(is_out) && (0..2).all(|i| !is_out(i) || agrees(i)) {
            self.last.release();
            self.end_tilt_error();
        }
    }

    /// Keeps what was read on the stop that the rod has left, if nothing was found.
    #[cold]
    pub(super) fn leave_stop(&mut self) {
        let is_healthy = !self.finds_anything();
        for rest in &mut self.last.rests {
            if is_healthy && rest.count > 0 {
                rest.healthy = Some(rest.sum / f64::from(rest.count));
            }
            (rest.sum, rest.count) = (0.0, 0);
        }
    }
}
