//! Detection of the rod's motion.
//!
//! One wild sample makes a displacement and another one back, so motion needs two successive
//! displacements in the same direction.

use super::parameters::{MOST_CYCLES, ResidualParameters};
use crate::state::state;

/// Follows both readings.
#[derive(Clone, Debug)]
pub struct Motion {
    least: f64,
    /// The newest readings, of as many cycles as a displacement is over.
    ring: [[f64; 2]; MOST_CYCLES],
    over: usize,
    next: usize,
    held: usize,
    /// Displacement of each reading in the previous cycle, m; 0 where it was small.
    way: [f64; 2],
}

state! {
    Motion { ring, next, held, way }
    but { least, over }
    sound |it| it.next < it.over.max(1) && it.held <= it.over
}

impl Motion {
    /// A detector for samples every `sample_time` seconds.
    pub fn new(parameters: &ResidualParameters, sample_time: f64) -> Self {
        let over = parameters.cycles(sample_time).motion;
        let least = parameters.slowest * over as f64 * sample_time;
        Self { least, ring: [[0.0; 2]; MOST_CYCLES], over, next: 0, held: 0, way: [0.0; 2] }
    }

    pub fn reset(&mut self) {
        (self.held, self.way) = (0, [0.0; 2]);
    }

    /// Takes the readings of a cycle, m; returns `true` if the rod moves by either of them.
    #[inline]
    pub fn step(&mut self, lengths: [f64; 2]) -> bool {
        let before = core::mem::replace(&mut self.ring[self.next % MOST_CYCLES], lengths);
        self.next = if self.next + 1 == self.over { 0 } else { self.next + 1 };
        if self.held < self.over {
            self.held += 1;
            return false;
        }
        let way = [0, 1].map(|which: usize| {
            let displaced = lengths[which] - before[which];
            if displaced.abs() > self.least { displaced } else { 0.0 }
        });
        let last = core::mem::replace(&mut self.way, way);
        // Both not 0, and of one sign.
        way[0] * last[0] > 0.0 || way[1] * last[1] > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_millimetres_a_second_are_motion_and_four_are_not() {
        for (speed, expected) in [(6e-3, true), (4e-3, false), (-6e-3, true)] {
            let mut motion = Motion::new(&ResidualParameters::DEFAULT, 0.02);
            let moved = (0..40).map(|k| motion.step([speed * 0.02 * f64::from(k), 0.0]));
            assert_eq!(moved.last(), Some(expected), "{speed}");
        }
    }

    #[test]
    fn a_wild_sample_is_no_motion() {
        for size in [2e-3, -0.3] {
            let mut motion = Motion::new(&ResidualParameters::DEFAULT, 0.02);
            let moved =
                (0..80).filter(|k| motion.step([if k % 25 == 20 { size } else { 0.0 }, 0.0]));
            assert_eq!(moved.count(), 0, "{size}");
        }
    }
}
