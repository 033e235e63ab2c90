//! Whether the rod moves.

/// Cycles over which a displacement is looked at.
const OVER: usize = 10;

/// Slower than this is at rest, m/s.
const SLOWEST: f64 = 5e-3;

/// Follows both readings.
#[derive(Clone, Debug)]
pub struct Motion {
    least: f64,
    ring: [[f64; 2]; OVER],
    next: usize,
    held: usize,
}

impl Motion {
    /// For samples every `sample_time` seconds.
    pub fn new(sample_time: f64) -> Self {
        let least = SLOWEST * OVER as f64 * sample_time;
        Self { least, ring: [[0.0; 2]; OVER], next: 0, held: 0 }
    }

    pub fn reset(&mut self) {
        self.held = 0;
    }

    /// Takes the readings of a cycle, m; `true` if the rod moves by either of them.
    pub fn step(&mut self, lengths: [f64; 2]) -> bool {
        let before = std::mem::replace(&mut self.ring[self.next], lengths);
        self.next = (self.next + 1) % OVER;
        if self.held < OVER {
            self.held += 1;
            return false;
        }
        before.iter().zip(lengths).any(|(before, now)| (now - before).abs() > self.least)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_millimetres_a_second_are_motion_and_four_are_not() {
        for (speed, expected) in [(6e-3, true), (4e-3, false), (-6e-3, true)] {
            let mut motion = Motion::new(0.02);
            let moved = (0..40).map(|k| motion.step([speed * 0.02 * f64::from(k), 0.0]));
            assert_eq!(moved.last(), Some(expected), "{speed}");
        }
    }
}
