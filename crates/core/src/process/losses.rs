//! Whether so many readings are lost that what the controller commands tells nothing of valve and rod. A transducer that is
//! gone for good makes no gaps: beside it a valve that did not follow its command would be a fault of the other transducer.

use super::parameters::ProcessParameters;
use crate::state::whole;

/// What lost readings add up to: each counts as much as several cycles without one.
#[derive(Clone, Copy, Debug, Default)]
pub struct Losses {
    sum: u32,
    /// Cycles in a row in which a reading is lost.
    row: u32,
}

whole! { Losses { sum, row } }

impl Losses {
    /// Takes whether a reading of this cycle is lost; returns whether many are, which lasts for so many `cycles` after them at
    /// the most. After `steady` lost readings in a row the transducer is gone for good.
    #[inline(always)]
    pub fn take(&mut self, is_lost: bool, cycles: u32, steady: u32) -> bool {
        (is_lost || self.sum | self.row > 0) && self.count(is_lost, cycles, steady)
    }

    #[cold]
    fn count(&mut self, is_lost: bool, cycles: u32, steady: u32) -> bool {
        const LOSS: u32 = ProcessParameters::DEFAULT.loss;
        const MANY: u32 = (ProcessParameters::DEFAULT.losses - 1) * LOSS;
        self.row = if is_lost { self.row.saturating_add(1) } else { 0 };
        self.sum = match is_lost && self.row <= steady {
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
        let mut are_many = |is_lost| losses.take(is_lost, 100, 500);
        assert!(!(1..=1020).any(|k| are_many(k % 17 == 1)), "one in 17");
        assert_eq!((0..).find(|_| are_many(true)), Some(5), "the sixth one in a row");
        (0..500).for_each(|k| _ = are_many(k % 10 == 0));
        assert!(are_many(true));
        assert_eq!((0..1000).filter(|_| are_many(false)).count(), 99);
    }

    #[test]
    fn a_reading_that_is_gone_for_good_makes_no_gaps_but_one_that_comes_now_and_then_does() {
        let mut losses = Losses::default();
        let mut are_many = |is_lost| losses.take(is_lost, 100, 500);
        assert_eq!((0..10_000).filter(|_| are_many(true)).count(), 594);
        assert!(!are_many(false), "it is back");
        assert!((0..10_000).filter(|k| are_many(k % 400 != 0)).count() > 9900);
    }
}
