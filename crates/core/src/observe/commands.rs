//! Whether the command has lately been beyond those that the thresholds of R1 and R2 were learnt with.
//!
//! A threshold covers the error that the linear model has in the motions it was learnt from. It is worst where the command
//! is large, since the valve's flow bends, and where it changes much from one cycle to the next, since the model does not
//! know when within the cycle the valve follows. Who learns in a calm sea and works in a rough one, or meets the wave of
//! the hundredth hour that drives a rod towards the end of its workspace, has innovations of both transducers that reach
//! several times what was seen.

use super::parameters::ObserverParameters;
use crate::state::state;

/// Largest commands that thresholds were learnt with; infinite where that is not known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LearntCommands {
    /// Either way, m/s.
    pub size: f64,
    /// From one cycle to the next, m/s.
    pub change: f64,
}

impl LearntCommands {
    /// Nothing is known of them.
    pub const ANY: Self = Self { size: f64::INFINITY, change: f64::INFINITY };
}

/// Follows one cylinder's command.
#[derive(Clone, Debug)]
pub struct CommandWatch {
    learnt: LearntCommands,
    is_limited: bool,
    /// Number of cycles for which what is beyond them may be in the innovations.
    lasts: u32,
    newest: Option<f64>,
    left: u32,
    /// Cycles since the first of the commands beyond, see [`Self::is_shared_by`].
    lasted: u32,
}

state! {
    CommandWatch { newest, left, lasted }
    but { learnt, is_limited, lasts }
}

impl CommandWatch {
    /// `lasts` in cycles, as an observer takes to settle.
    pub fn new(learnt: LearntCommands, lasts: u32) -> Self {
        Self {
            learnt,
            is_limited: learnt != LearntCommands::ANY,
            lasts,
            newest: None,
            left: 0,
            lasted: 0,
        }
    }

    /// Takes the command of a cycle, m/s, which is in the innovations from the next cycle on. Where it is absent, the
    /// observers hold the last one.
    #[inline]
    pub fn take(&mut self, command: Option<f64>) {
        if !self.is_limited {
            return;
        }
        self.left = self.left.saturating_sub(1);
        self.lasted = self.lasted.saturating_add(1);
        let Some(command) = command else { return };
        let before = self.newest.replace(command).unwrap_or(command);
        let change = (command - before).abs();
        if command.abs() > self.learnt.size || change > self.learnt.change {
            if self.left == 0 {
                self.lasted = 0;
            }
            self.left = self.lasts;
        }
    }

    /// Whether the innovations of the next cycle may have the error of a larger command, or change of it, than was learnt.
    pub const fn is_beyond(&self) -> bool {
        self.left > 0
    }

    /// Whether an observer that has followed for so many cycles has in its innovation what these commands did, as the other
    /// one has it: it has followed since before the first of them, or for so long that nothing is left of that.
    pub fn is_shared_by(&self, followed: u32) -> bool {
        let forgotten = self.lasts.saturating_mul(ObserverParameters::DEFAULT.forgotten);
        followed >= self.lasted.saturating_add(2).min(forgotten)
    }

    /// Forgets the command, because the observers begin anew.
    pub const fn reset(&mut self) {
        (self.newest, self.left, self.lasted) = (None, 0, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_larger_change_than_was_learnt_lasts_as_long_as_an_observer_settles() {
        let mut watch =
            CommandWatch::new(LearntCommands { change: 0.05, ..LearntCommands::ANY }, 3);
        let mut beyond = |command| {
            watch.take(command);
            watch.is_beyond()
        };
        // The first one changes nothing; up to the largest that was learnt it is as it was learnt.
        assert!([0.9, 0.94, 0.9].into_iter().all(|u| !beyond(Some(u))));
        let braked = [0.6, 0.58, 0.57, 0.57].map(|u| beyond(Some(u)));
        assert_eq!(braked, [true, true, true, false]);
        // A missing one was held by the observers, too.
        let missing = [None, Some(0.5), None, None, None].map(&mut beyond);
        assert_eq!(missing, [false, true, true, true, false]);
        watch.take(Some(0.2));
        watch.reset();
        assert!(!watch.is_beyond());
        watch.take(Some(-0.9));
        assert!(!watch.is_beyond(), "from what to −0.9?");
    }

    #[test]
    fn a_larger_command_than_was_learnt_is_beyond_for_as_long_as_it_lasts_and_then_some() {
        let mut watch = CommandWatch::new(LearntCommands { size: 0.3, ..LearntCommands::ANY }, 2);
        let mut beyond = |u| {
            watch.take(Some(u));
            watch.is_beyond()
        };
        assert_eq!([0.0, 0.3, -0.3].map(&mut beyond), [false; 3], "it leaps, and was learnt");
        assert_eq!([0.31, 0.4, 0.3, 0.2].map(&mut beyond), [true, true, true, false]);
        assert_eq!([-0.31, -0.2, -0.1].map(&mut beyond), [true, true, false]);
    }

    #[test]
    fn an_observer_shares_what_began_while_it_followed_and_what_it_has_followed_for_long() {
        let mut watch = CommandWatch::new(LearntCommands { size: 0.3, ..LearntCommands::ANY }, 2);
        watch.take(Some(0.1));
        // It began in the cycle of the first command beyond, or in the one after it.
        watch.take(Some(0.5));
        assert!(watch.is_shared_by(2) && !watch.is_shared_by(1));
        for _ in 0..5 {
            watch.take(Some(0.5));
        }
        assert!(watch.is_shared_by(7) && !watch.is_shared_by(6));
        for _ in 0..100 {
            watch.take(Some(0.5));
        }
        assert!(watch.is_shared_by(10) && !watch.is_shared_by(9), "nothing is left of it");
        // The next one begins anew.
        (0..3).for_each(|_| watch.take(Some(0.1)));
        watch.take(Some(-0.5));
        assert!(watch.is_shared_by(2) && !watch.is_shared_by(1));
    }

    #[test]
    fn where_nothing_was_learnt_nothing_is_beyond_it() {
        let mut watch = CommandWatch::new(LearntCommands::ANY, 3);
        for command in [0.0, 1e300, -1e300, f64::NAN] {
            watch.take(Some(command));
            assert!(!watch.is_beyond());
        }
    }
}
