//! The last transducer on the mechanical stop, where it reads what it read there before.

use super::{Cycle, Cylinder};
use crate::state::whole;

/// Reading on the mechanical stop.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rest {
    /// Sum of the readings since the rod stands, m, and their number.
    sum: f64,
    count: u32,
    /// Mean when it last stood, m: at the end of a stay it moves again.
    stood: Option<f64>,
    /// Mean of the last stay in which nothing was found, m.
    healthy: Option<f64>,
}

whole! { Rest { sum, count, stood, healthy } }

impl Rest {
    fn mean(&self) -> f64 {
        self.sum / f64::from(self.count.max(1))
    }

    /// Ends the stay.
    pub fn end(&mut self) {
        (self.sum, self.count, self.stood) = (0.0, 0, None);
    }

    /// Takes a reading; one that is farther than `far` from the mean, m, begins anew. A rod that still retracts passes by
    /// every mean, and that of its last stay among them. The rod stands after `stands` readings.
    fn take(&mut self, reading: f64, far: f64, stands: u32) {
        if (reading - self.mean()).abs() > far {
            (self.sum, self.count) = (0.0, 0);
        }
        self.sum += reading;
        self.count = self.count.saturating_add(1);
        if self.count >= stands {
            self.stood = Some(self.mean());
        }
    }
}

impl Cylinder {
    /// Takes the readings on the mechanical stop.
    #[cold]
    pub(super) fn rest_last(&mut self, cycle: &Cycle) {
        let stands = self.design.observers[0].settle.max(1);
        for (rest, reading) in self.last.rests.iter_mut().zip(cycle.lengths()) {
            let Some(reading) = reading else { continue };
            rest.take(reading, self.design.bank.observer.high, stands);
        }
        let agrees = |i: usize| {
            let Rest { count, stood, healthy, .. } = self.last.rests[i];
            let (now, high) = (stood.filter(|_| count >= stands), self.design.bank.observer.high);
            now.zip(healthy).is_some_and(|(now, healthy)| (now - healthy).abs() <= high)
        };
        // The deck's attitude finds an error of C1.
        let is_out = |i: usize| {
            self.last.is_latched(i) || self.last.shared.is_some() || i == 0 && self.tilted.is_some()
        };
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
            if is_healthy {
                rest.healthy = rest.stood.or(rest.healthy);
            }
            rest.end();
        }
    }
}
