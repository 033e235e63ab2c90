//! The last transducer on the mechanical stop, where it reads what it read there before.

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
    pub fn take(&mut self, reading: f64, far: f64, stands: u32) {
        if (reading - self.mean()).abs() > far {
            (self.sum, self.count) = (0.0, 0);
        }
        self.sum += reading;
        self.count = self.count.saturating_add(1);
        if self.count >= stands {
            self.stood = Some(self.mean());
        }
    }

    /// Whether the rod stands, after `stands` readings, within `far` of where it stood in health, m.
    pub fn agrees(&self, far: f64, stands: u32) -> bool {
        let now = self.stood.filter(|_| self.count >= stands);
        now.zip(self.healthy).is_some_and(|(now, healthy)| (now - healthy).abs() <= far)
    }

    /// Ends the stay, and keeps its mean if nothing was found.
    pub fn leave(&mut self, is_healthy: bool) {
        if is_healthy {
            self.healthy = self.stood.or(self.healthy);
        }
        self.end();
    }
}
