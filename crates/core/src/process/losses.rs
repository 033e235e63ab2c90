//! Whether so many readings are lost that what the controller commands tells nothing of valve and rod.

use super::parameters::ProcessParameters;
use crate::state::whole;

/// What lost readings add up to: each counts as much as several cycles without one.
#[derive(Clone, Copy, Debug, Default)]
pub struct Losses {
    sum: u32,
}

whole! { Losses { sum } }

impl Losses {
    /// Takes whether a reading of this cycle is lost; returns whether many are, which lasts for so many `cycles` after them at
    /// the most.
    #[inline(always)]
    pub fn take(&mut self, is_lost: bool, cycles: u32) -> bool {
        (is_lost || self.sum > 0) && self.count(is_lost, cycles)
    }

    #[cold]
    fn count(&mut self, is_lost: bool, cycles: u32) -> bool {
        const LOSS: u32 = ProcessParameters::DEFAULT.loss;
        const MANY: u32 = (ProcessParameters::DEFAULT.losses - 1) * LOSS;
        self.sum = match is_lost {
            true => self.sum.saturating_add(LOSS).min(MANY + cycles),
            false => self.sum.saturating_sub(1),
        };
        self.sum > MANY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_one_in_seventeen_are_many_until_their_time_is_over() {
        let mut losses = Losses::default();
        let mut are_many = |is_lost| losses.take(is_lost, 100);
        assert!(!(1..=1020).any(|k| are_many(k % 17 == 1)), "one in 17");
        assert_eq!((0..).find(|_| are_many(true)), Some(5), "the sixth one in a row");
        (0..500).for_each(|k| _ = are_many(k % 10 == 0));
        assert!(are_many(true));
        assert_eq!((0..1000).filter(|_| are_many(false)).count(), 99);
    }
}
