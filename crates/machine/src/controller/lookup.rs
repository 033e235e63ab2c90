//! From control speed to spool position: the look-up table of Figures 2-3 and 3-11.

use crate::plant::Cylinder;

/// Number of intervals of the table.
const INTERVALS: usize = 64;

/// Number of halvings of the spool's stroke: to 1e-12 of it.
const HALVINGS: usize = 40;

/// The inverse of one cylinder's flow curve, as motion tests would give it: at its usual load and a
/// steady supply pressure. It is linear between its points, which the flow is not.
#[derive(Clone, Debug, PartialEq)]
pub struct LookUp {
    spools: [f64; INTERVALS + 1],
    limit: f64,
}

impl LookUp {
    /// The table for speeds up to `limit`, m/s, at load pressure `pressure` and supply pressure
    /// `supply`, bar.
    pub fn of(cylinder: &Cylinder, limit: f64, pressure: f64, supply: f64) -> Self {
        let spool_for = |speed: f64| {
            let (mut low, mut high) = (-1.0, 1.0);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if cylinder.settled_speed(middle, pressure, supply) < speed {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            0.5 * (low + high)
        };
        let speed = |node: usize| limit * (2.0 * node as f64 / INTERVALS as f64 - 1.0);
        Self { spools: std::array::from_fn(|node| spool_for(speed(node))), limit }
    }

    /// The spool position for `speed`, m/s; beyond the table, its end.
    pub fn spool(&self, speed: f64) -> f64 {
        let place = (speed / self.limit + 1.0) * (INTERVALS as f64 / 2.0);
        // A speed that is no number lands at 0, the retracting end.
        let node = (place.max(0.0) as usize).min(INTERVALS - 1);
        let part = (place - node as f64).clamp(0.0, 1.0);
        self.spools[node] + part * (self.spools[node + 1] - self.spools[node])
    }
}
