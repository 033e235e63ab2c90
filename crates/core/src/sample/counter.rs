//! The alive counter of a frame, which tells the frame's cycle.
//!
//! A sender counts its frames, one or several in each cycle, so a counter distinguishes a frame
//! that is late by a cycle from the punctual one, and a repetition from both. It says nothing where
//! the sender counts something else, or sends irregularly; it is then not trusted until it fits
//! again.

use super::parameters::ArrivalParameters;
use crate::state::{state, whole};

const P: &ArrivalParameters = &ArrivalParameters::DEFAULT;

/// Meaning of a frame's counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Count {
    /// No meaning: it is the first frame, or the counter is not trusted.
    Silent,
    /// The counter stands still: the sender, or the way from it, repeats a frame.
    Same,
    /// The frame is this many cycles after the newest: −[`ArrivalParameters::latest`] to 1.
    Off(i64),
    /// The counter fits no cycle nearby.
    Jumped,
}

/// A count and the cycle in which it came.
#[derive(Clone, Copy, Debug)]
struct Point {
    cycle: u64,
    value: u64,
    /// Counts a cycle since the previous point, where that is an integer.
    step: Option<u64>,
}

whole! {
    Point { cycle }
    bits { value, step }
}

/// Follows one alive counter.
#[derive(Clone, Debug)]
pub struct AliveCounter {
    /// Width of the counter, bits.
    bits: u32,
    /// Mask with `bits` ones.
    ones: u64,
    /// Counts in a cycle.
    step: u64,
    /// Count of the newest frame that was taken.
    last: Option<Point>,
    /// Newest count since then that did not fit.
    misfit: Option<Point>,
    believed: bool,
    fitting: u32,
    jumps: u64,
}

state! {
    AliveCounter { last, misfit, believed, fitting, jumps }
    bits { step }
    but { bits, ones }
    sound |it| it.fitting <= P.fitting && (1..=i64::MAX as u64).contains(&it.step)
}

impl AliveCounter {
    /// A counter of `bits` bits (1 to 64) that wraps to zero and rises by `step` in a cycle, the
    /// number of pages that share it.
    pub fn new(bits: u32, step: u64) -> Self {
        let bits = bits.clamp(1, 64);
        Self {
            bits,
            ones: u64::MAX >> (64 - bits),
            step: step.max(1),
            last: None,
            misfit: None,
            believed: true,
            fitting: 0,
            jumps: 0,
        }
    }

    /// Whether it tells the cycle of a frame.
    pub const fn is_believed(&self) -> bool {
        self.believed
    }

    /// Number of counts that fitted no cycle.
    pub const fn jumps(&self) -> u64 {
        self.jumps
    }

    pub const fn count_anew(&mut self) {
        self.jumps = 0;
    }

    /// Whether `value` is the count of the frame that is due in cycle number `cycle`, for which
    /// [`Self::read`] returns [`Count::Off`] by 0.
    #[inline(always)]
    pub fn is_due(&self, cycle: u64, value: u64) -> bool {
        let Some(last) = self.last else { return false };
        let elapsed = cycle.wrapping_sub(last.cycle);
        let expected = last.value.wrapping_add(elapsed.wrapping_mul(self.step));
        let differ = |other: u64| (value ^ other) & self.ones != 0;
        self.believed && !differ(expected) && differ(last.value)
    }

    /// Meaning of the count `value` in a frame that came in cycle number `cycle`.
    #[inline]
    pub fn read(&self, cycle: u64, value: u64) -> Count {
        let Some(last) = self.last else { return Count::Silent };
        let elapsed = cycle.wrapping_sub(last.cycle);
        let expected = last.value.wrapping_add(elapsed.wrapping_mul(self.step));
        // The difference as a signed number of as many bits.
        let unused = 64 - self.bits;
        let off = (value.wrapping_sub(expected) << unused) as i64 >> unused;
        if value.wrapping_sub(last.value) << unused == 0 {
            Count::Same
        } else if !self.believed {
            Count::Silent
        } else if off == 0 {
            Count::Off(0)
        } else {
            let step = self.step as i64;
            match (off % step, off / step) {
                (0, cycles) if (-P.latest..=1).contains(&cycles) => Count::Off(cycles),
                _ => Count::Jumped,
            }
        }
    }

    /// Notes that the frame was taken as that of `cycle`.
    #[inline(always)]
    pub fn accept(&mut self, cycle: u64, value: u64) {
        if !self.believed {
            self.regain(cycle, value);
        }
        self.misfit = None;
        self.last = Some(Point { cycle, value, step: None });
    }

    /// Notes that the frame does not belong to `cycle`, in which it came; `empty` if nothing else
    /// was taken in it yet, and `behind` if it seems to be late. Returns whether it is to be taken
    /// after all, because the sender has begun another count.
    ///
    /// Another count is recognised by two misfits with the known step from cycle to cycle, as after
    /// a restart, or by three with another step. Frames that are behind by the same number of
    /// cycles are only late, however.
    #[cold]
    pub fn reject(&mut self, cycle: u64, value: u64, empty: bool, behind: bool) -> bool {
        let Some(before) = self.misfit.or(self.last) else { return empty };
        if !behind && self.believed && self.is_of_silence(cycle, value) {
            return false;
        }
        let counts = self.distance(before.value, value);
        let elapsed = cycle.wrapping_sub(before.cycle);
        if elapsed == 0 && counts == 0 {
            return false;
        }
        self.jumps += u64::from(!behind);
        if elapsed == 0 && self.misfit.is_some() && !behind && counts == self.step {
            // Several in a cycle: it counts frames.
            self.disbelieve();
            return empty;
        }
        let whole = elapsed > 0 && counts > 0 && counts.is_multiple_of(elapsed);
        let step = whole.then(|| counts / elapsed);
        let again = self.misfit.is_some_and(|misfit| step.is_some() && misfit.step == step);
        let same_step = step == Some(self.step);
        let goes_on = if same_step { self.misfit.is_some() && !behind } else { again };
        if empty && goes_on {
            self.step = step.unwrap_or(self.step);
            return true;
        }
        if empty || !behind {
            self.misfit = Some(Point { cycle, value, step: step.filter(|_| empty) });
        }
        false
    }

    /// Stops trusting the counter: only a repeated count means anything until the counts fit again.
    pub fn disbelieve(&mut self) {
        self.believed = false;
        self.fitting = 0;
        self.misfit = None;
    }

    /// Notes a second frame in one cycle: the counter does not count cycles.
    pub const fn surplus(&mut self) {
        self.fitting = 0;
    }

    /// Forgets the last count, after a gap in time.
    pub const fn forget(&mut self) {
        self.last = None;
        self.misfit = None;
    }

    fn regain(&mut self, cycle: u64, value: u64) {
        let Some(last) = self.last else { return };
        let counts = self.distance(last.value, value);
        let elapsed = cycle.wrapping_sub(last.cycle).max(1);
        if counts.is_multiple_of(elapsed) && counts / elapsed == self.step {
            self.fitting += 1;
            self.believed = self.fitting >= P.fitting;
        } else {
            self.fitting = 0;
            // Another step is one to be tried, if it is a small part of the counter.
            if counts.is_multiple_of(elapsed) && counts / elapsed <= self.distance(0, u64::MAX) / 4
            {
                self.step = (counts / elapsed).max(1);
            }
        }
    }

    /// Whether `value` was counted in a silence that lasts until `cycle`, and is longer than frames
    /// are otherwise late.
    fn is_of_silence(&self, cycle: u64, value: u64) -> bool {
        self.last.is_some_and(|last| {
            let silent = cycle.wrapping_sub(last.cycle);
            let counts = self.distance(last.value, value);
            (P.latest as u64 + 1..=P.backlog).contains(&silent)
                && counts.is_multiple_of(self.step)
                && counts / self.step < silent
        })
    }

    /// Distance from the count `from` up to `to`.
    const fn distance(&self, from: u64, to: u64) -> u64 {
        let unused = 64 - self.bits;
        to.wrapping_sub(from) << unused >> unused
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(last: u64, cycle: u64) -> AliveCounter {
        let mut counter = AliveCounter::new(8, 1);
        counter.accept(cycle, last);
        counter
    }

    #[test]
    fn wraps_and_tells_repetition_loss_and_lateness() {
        assert_eq!(AliveCounter::new(8, 1).read(7, 3), Count::Silent);
        let counter = at(254, 10);
        assert_eq!(counter.read(11, 255), Count::Off(0));
        assert_eq!(counter.read(11, 254), Count::Same);
        assert_eq!(counter.read(12, 0), Count::Off(0), "one was lost");
        assert_eq!(counter.read(12, 255), Count::Off(-1), "late by a cycle");
        assert_eq!(counter.read(12, 1), Count::Off(1), "early");
        assert_eq!(counter.read(12, 250), Count::Jumped);
        assert_eq!(counter.read(12, 77), Count::Jumped);
        assert_eq!(counter.read(10 + 300, 42), Count::Off(0), "300 cycles are 44 counts");
    }

    #[test]
    fn a_counter_of_full_width_does_not_overflow() {
        let mut counter = AliveCounter::new(64, 1);
        counter.accept(0, u64::MAX);
        assert_eq!(counter.read(1, 0), Count::Off(0));
        assert_eq!(counter.read(2, 0), Count::Off(-1));
    }

    #[test]
    fn pages_that_share_a_counter_make_its_step() {
        let mut counter = AliveCounter::new(8, 6);
        counter.accept(1, 250);
        assert_eq!(counter.read(2, 0), Count::Off(0));
        assert_eq!(counter.read(3, 0), Count::Off(-1));
        assert_eq!(counter.read(2, 6), Count::Off(1));
        assert_eq!(counter.read(2, 3), Count::Jumped);
    }

    #[test]
    fn what_is_due_is_what_is_read_as_of_this_cycle() {
        for (bits, step) in [(8, 1), (8, 6), (2, 1), (3, 2), (1, 1), (1, 2), (64, 1)] {
            let mut counter = AliveCounter::new(bits, step);
            assert!(!counter.is_due(1, 1), "nothing is known");
            counter.accept(7, u64::MAX);
            for (cycle, value) in (5..12).flat_map(|cycle| (0..70_u64).map(move |k| (cycle, k))) {
                // Values of a signed signal are negative numbers.
                for value in [value, value.wrapping_neg()] {
                    let due = counter.read(cycle, value) == Count::Off(0);
                    assert_eq!(counter.is_due(cycle, value), due, "{bits} {step} {cycle} {value}");
                }
            }
            counter.disbelieve();
            assert!(!counter.is_due(8, step.wrapping_sub(1)), "it is not believed");
        }
    }

    #[test]
    fn two_misfits_one_cycle_apart_are_another_count() {
        let mut counter = at(100, 10);
        assert_eq!(counter.read(11, 0), Count::Jumped);
        assert!(!counter.reject(11, 0, true, false));
        assert!(counter.reject(12, 1, true, false));
        counter.accept(12, 1);
        assert_eq!((counter.read(13, 2), counter.jumps()), (Count::Off(0), 2));
    }

    #[test]
    fn another_step_takes_three() {
        let mut counter = AliveCounter::new(8, 6);
        counter.accept(0, 0);
        // One page in each cycle: the counter goes up by one, and the page comes each sixth.
        assert_eq!(counter.read(6, 6), Count::Off(-5));
        assert!(!counter.reject(6, 6, true, true));
        assert!(counter.reject(12, 12, true, true));
        counter.accept(12, 12);
        assert_eq!(counter.read(18, 18), Count::Off(0));
    }

    #[test]
    fn what_is_behind_alone_stays_late() {
        let mut counter = at(10, 10);
        for (cycle, value) in [(12, 11), (13, 12), (14, 13), (15, 14)] {
            assert_eq!(counter.read(cycle, value), Count::Off(-1));
            assert!(!counter.reject(cycle, value, true, true));
        }
    }

    #[test]
    fn who_counts_frames_is_not_believed_until_it_counts_cycles() {
        let mut counter = at(10, 1);
        assert_eq!(counter.read(1, 11), Count::Off(1));
        assert!(!counter.reject(1, 11, false, false));
        assert!(!counter.reject(1, 12, false, false));
        assert_eq!(counter.read(1, 13), Count::Silent);
        assert_eq!(counter.read(2, 10), Count::Same);
        for cycle in 2..=19 {
            assert_eq!(counter.read(cycle, 40 + cycle), Count::Silent, "{cycle}");
            counter.accept(cycle, 40 + cycle);
        }
        assert_eq!(counter.read(20, 60), Count::Off(0));
    }
}
