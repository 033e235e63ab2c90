//! Whether a reading follows a rod in motion, judged by its own steps.

use super::parameters::PlausibilityParameters;
use crate::state::whole;

/// Steps in one direction for a motion: noise with three values makes two at most.
const STEPS: usize = 3;

const P: &PlausibilityParameters = &PlausibilityParameters::DEFAULT;

/// Newest steps of a reading.
#[derive(Clone, Copy, Debug, Default)]
pub struct ReadingMotion {
    last: Option<f64>,
    /// Newest step, m.
    newest: f64,
    /// Newest steps other than 0, m, newest first.
    recent: [f64; STEPS],
}

whole! { ReadingMotion { last, newest, recent } }

impl ReadingMotion {
    /// Takes the reading of a cycle, m; `None` where there is none.
    #[inline(always)]
    pub fn follow(&mut self, position: Option<f64>) {
        let Some(position) = position else {
            *self = Self::default();
            return;
        };
        self.newest = self.last.replace(position).map_or(0.0, |last| position - last);
        if self.newest != 0.0 {
            let [first, second, _] = self.recent;
            self.recent = [self.newest, first, second];
        }
    }

    /// Whether the reading moves, and has moved in this direction for a few steps, the newest of
    /// which is no leap. A reading that steps once, or to and fro, has a fault and is not in
    /// motion.
    pub fn goes_on(&self) -> bool {
        let [newest, first, second] = self.recent;
        let is_leap = newest.abs() > P.steepest * (first + second).abs();
        let goes_one_way =
            self.recent.iter().all(|it| *it > 0.0) || self.recent.iter().all(|it| *it < 0.0);
        self.newest != 0.0 && goes_one_way && !is_leap
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(positions: &[f64]) -> bool {
        let mut motion = ReadingMotion::default();
        positions.iter().for_each(|position| motion.follow(Some(*position)));
        motion.goes_on()
    }

    #[test]
    fn a_motion_is_several_steps_one_way() {
        assert!(after(&[0.0, 1.0, 2.0, 3.0]));
        assert!(after(&[0.0, 1.0, 4.0, 10.0]), "it speeds up");
        assert!(after(&[0.0, -1.0, -2.0, -2.0, -3.0]), "slow and coarse");
        assert!(!after(&[0.0, 1.0, 2.0]), "two steps");
        assert!(!after(&[0.0, 1.0, 2.0, 3.0, 3.0]), "it has come to rest");
        assert!(!after(&[0.0, 1.0, 2.0, 60.0]), "a jump");
        assert!(!after(&[-1.0, 0.0, 1.0, -1.0, 0.0, 1.0]), "noise");
    }

    #[test]
    fn what_was_before_a_gap_is_no_motion() {
        let mut motion = ReadingMotion::default();
        for position in [Some(0.0), Some(1.0), Some(2.0), None, Some(3.0), Some(4.0)] {
            motion.follow(position);
        }
        assert!(!motion.goes_on());
    }
}
