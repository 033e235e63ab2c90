//! The machine's own supervision of its transducers: *difference too big* (section 5-2), which is a code black.

use crate::hexapod::LEGS;

/// Compares C1 and C2 of each cylinder as they read.
#[derive(Clone, Debug, PartialEq)]
pub struct Supervision {
    /// The largest difference allowed, m.
    limit: f64,
    /// Cycles in a row in which the difference has to be larger before it trips.
    patience: u32,
    /// Cycles in a row in which it was, of each cylinder.
    beyond: [u32; LEGS],
    left_out: [bool; LEGS],
    tripped: bool,
}

impl Supervision {
    /// Trips where a difference is larger than `limit`, m, in `patience` cycles in a row, one at least.
    pub fn new(limit: f64, patience: u32) -> Self {
        let patience = patience.max(1);
        Self { limit, patience, beyond: [0; LEGS], left_out: [false; LEGS], tripped: false }
    }

    /// Compares the cylinder of this index no more: one of its transducers is known to be wrong.
    pub fn leave_out(&mut self, leg: usize) {
        self.left_out[leg] = true;
    }

    /// Takes the lengths of a cycle by C1 and C2, m; whether it has tripped, which it does once and for all.
    pub fn step(&mut self, lengths: &[[f64; 2]; LEGS]) -> bool {
        for (leg, [first, second]) in lengths.iter().enumerate() {
            let is_beyond = !self.left_out[leg] && (first - second).abs() > self.limit;
            self.beyond[leg] = if is_beyond { self.beyond[leg] + 1 } else { 0 };
            self.tripped |= self.beyond[leg] >= self.patience;
        }
        self.tripped
    }

    /// Trips whatever the readings are, as where a cylinder has no reading left to rely on.
    pub fn trip(&mut self) {
        self.tripped = true;
    }

    pub fn has_tripped(&self) -> bool {
        self.tripped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Readings of which the third cylinder's differ by so much, m.
    fn apart(by: f64) -> [[f64; 2]; LEGS] {
        let mut lengths = [[0.3, 0.301]; LEGS];
        lengths[2] = [0.3, 0.3 - by];
        lengths
    }

    #[test]
    fn it_trips_when_the_difference_has_lasted_and_stays_tripped() {
        let mut supervision = Supervision::new(0.05, 3);
        let mut step = |by| supervision.step(&apart(by));
        assert!(![0.06, 0.06, 0.04, -0.06, -0.06].map(&mut step).contains(&true));
        assert!(step(0.051) && step(0.0));
    }

    #[test]
    fn what_is_left_out_does_not_trip_it_and_others_still_do() {
        let mut supervision = Supervision::new(0.05, 1);
        supervision.leave_out(2);
        assert!(!supervision.step(&apart(0.5)));
        let mut lengths = apart(0.5);
        lengths[3][1] += 0.06;
        assert!(supervision.step(&lengths) && supervision.has_tripped());
    }
}
