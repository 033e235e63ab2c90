//! Usual times within a cycle of the frames of a place.

use super::parameters::{ArrivalParameters, PHASES};
use crate::state::whole;

const P: &ArrivalParameters = &ArrivalParameters::DEFAULT;

/// [`ArrivalParameters::same_time`] in the unit of the phases, µs.
const SAME_TIME: i64 = (P.same_time * 1e6) as i64;

/// Newest phases: time from the opening of a cycle to the frame, µs; negative for one that came
/// before its cycle opened.
#[derive(Clone, Debug)]
pub struct Phases {
    newest: [i32; PHASES],
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
        Self { newest: [0; PHASES], count: 0 }
    }

    /// Takes the phase of a frame, ns.
    #[inline]
    pub fn push(&mut self, phase: i64) {
        // Within a cycle, which is far below the half hour that fits.
        self.newest[self.count % PHASES] = (phase / 1000) as i32;
        self.count += 1;
    }

    /// The usual phase; `None` while it is not known.
    pub fn usual(&self) -> Option<Usual> {
        if self.count < P.timed {
            return None;
        }
        let mut phases = self.newest;
        let phases = &mut phases[..self.count.min(PHASES)];
        let middle = phases.len() / 2;
        let median = *phases.select_nth_unstable(middle).1;
        phases.iter_mut().for_each(|phase| *phase = phase.saturating_sub(median).saturating_abs());
        let deviation = f64::from(*phases.select_nth_unstable(middle).1);
        let tolerance = SAME_TIME.max((P.same_time_deviations * deviation) as i64);
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
