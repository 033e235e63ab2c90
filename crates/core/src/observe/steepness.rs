//! Whether the command has lately changed by more than the thresholds of R1 and R2 were learnt with.
//!
//! A threshold covers the error that the linear model has in the motions it was learnt from. A change of command from one
//! cycle to the next is what the model is worst at, since it knows neither when within the cycle the valve follows nor
//! how its flow bends: where a rod brakes before the end of its workspace in a wave of the hundredth hour, the innovations
//! of both transducers reach several times what two hours have shown.

use crate::state::state;

/// Follows one cylinder's command.
#[derive(Clone, Debug)]
pub struct Steepness {
    /// Largest change from one cycle to the next that the thresholds were learnt with, m/s; infinite where it is not
    /// known.
    most: f64,
    /// Number of cycles for which a larger change may be in the innovations.
    lasts: u32,
    newest: Option<f64>,
    left: u32,
}

state! {
    Steepness { newest, left }
    but { most, lasts }
}

impl Steepness {
    /// `most` in m/s from one cycle to the next; `lasts` in cycles, as an observer takes to settle.
    pub const fn new(most: f64, lasts: u32) -> Self {
        Self { most, lasts, newest: None, left: 0 }
    }

    /// Takes the command of a cycle, m/s, which is in the innovations from the next cycle on. Where it is absent, the
    /// observers hold the last one.
    #[inline]
    pub fn take(&mut self, command: Option<f64>) {
        if self.most == f64::INFINITY {
            return;
        }
        self.left = self.left.saturating_sub(1);
        let Some(command) = command else { return };
        let before = self.newest.replace(command).unwrap_or(command);
        if (command - before).abs() > self.most {
            self.left = self.lasts;
        }
    }

    /// Whether the innovations of the next cycle may have the error of a larger change than was learnt.
    pub const fn is_beyond(&self) -> bool {
        self.left > 0
    }

    /// Forgets the command, because the observers begin anew.
    pub const fn reset(&mut self) {
        (self.newest, self.left) = (None, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_larger_change_than_was_learnt_lasts_as_long_as_an_observer_settles() {
        let mut steepness = Steepness::new(0.05, 3);
        let mut beyond = |command| {
            steepness.take(command);
            steepness.is_beyond()
        };
        // The first one changes nothing; up to the largest that was learnt it is as it was learnt.
        assert!([0.9, 0.94, 0.9].into_iter().all(|u| !beyond(Some(u))));
        let braked = [0.6, 0.58, 0.57, 0.57].map(|u| beyond(Some(u)));
        assert_eq!(braked, [true, true, true, false]);
        // A missing one was held by the observers, too.
        let missing = [None, Some(0.5), None, None, None].map(&mut beyond);
        assert_eq!(missing, [false, true, true, true, false]);
        steepness.take(Some(0.2));
        steepness.reset();
        assert!(!steepness.is_beyond());
        steepness.take(Some(-0.9));
        assert!(!steepness.is_beyond());
    }

    #[test]
    fn without_a_limit_any_change_is_as_it_was_learnt() {
        let mut steepness = Steepness::new(f64::INFINITY, 3);
        for command in [Some(1.2), Some(-1.2), None, Some(1e9)] {
            steepness.take(command);
            assert!(!steepness.is_beyond());
        }
    }
}
