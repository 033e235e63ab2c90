//! Usual times within a cycle of the frames of a place.

use crate::state::whole;

/// Number of frames that are remembered.
const FRAMES: usize = 64;

/// Least number of frames for a usual time.
const FEWEST: usize = 8;

/// Difference below which phases are the same, µs; [`ALIKE_DEVIATIONS`] also applies.
const ALIKE: i64 = 1000;
/// Number of deviations below which phases are the same.
const ALIKE_DEVIATIONS: f64 = 4.4;

/// Newest phases: time from the opening of a cycle to the frame, µs; negative for one that came
/// before its cycle opened.
#[derive(Clone, Debug)]
pub struct Phases {
    newest: [i32; FRAMES],
    count: usize,
}

whole! { Phases { newest, count } }

/// Median and scatter of the phases, ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Usual {
    pub phase: i64,
    /// Difference beyond which phases are different, ns.
    pub tolerance: i64,
}

whole! { Usual { phase, tolerance } }

impl Phases {
    pub const fn new() -> Self {
        Self { newest: [0; FRAMES], count: 0 }
    }

    /// Takes the phase of a frame, ns.
    #[inline]
    pub fn push(&mut self, phase: i64) {
        // Within a cycle, which is far below the half hour that fits.
        self.newest[self.count % FRAMES] = (phase / 1000) as i32;
        self.count += 1;
    }

    /// The usual phase; `None` while it is not known.
    pub fn usual(&self) -> Option<Usual> {
        if self.count < FEWEST {
            return None;
        }
        let mut phases = self.newest;
        let phases = &mut phases[..self.count.min(FRAMES)];
        let middle = phases.len() / 2;
        let median = *phases.select_nth_unstable(middle).1;
        phases.iter_mut().for_each(|phase| *phase = phase.saturating_sub(median).saturating_abs());
        let deviation = f64::from(*phases.select_nth_unstable(middle).1);
        let tolerance = ALIKE.max((ALIKE_DEVIATIONS * deviation) as i64);
        Some(Usual { phase: i64::from(median) * 1000, tolerance: tolerance * 1000 })
    }
}

impl Default for Phases {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_usual_phase_is_a_median_and_a_stray_does_not_move_it() {
        let mut phases = Phases::new();
        (0..7).for_each(|_| phases.push(2_000_000));
        assert_eq!(phases.usual(), None);
        (0..90).for_each(|k| phases.push(2_000_000 + k % 3 * 1000));
        phases.push(15_000_000);
        assert_eq!(phases.usual(), Some(Usual { phase: 2_001_000, tolerance: 1_000_000 }));
        let mut wide = Phases::new();
        (0..64).for_each(|k| wide.push(k * 100_000));
        assert_eq!(wide.usual(), Some(Usual { phase: 3_200_000, tolerance: 7_040_000 }));
    }
}
