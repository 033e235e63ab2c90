//! Sums over the newest samples.

use crate::state::{state, whole};
use alloc::boxed::Box;

/// Samples in each window: about as many as an octave needs, so that what begins between two of
/// them loses little.
pub const WIDTHS: [usize; 20] =
    [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024];

/// Index of the narrowest window that holds `width` samples.
pub const fn window_of(width: usize) -> usize {
    let mut index = 0;
    while WIDTHS[index] < width {
        index += 1;
    }
    index
}

/// Number of windows, those of up to 16 samples, that are looked at with every sample, …
pub const NARROW_WINDOWS: usize = window_of(16) + 1;

/// … and samples from one look at the wider ones to the next: what fills them comes no sooner.
pub const WIDE_EVERY: u32 = 4;

/// Values that are summed.
pub const VALUES: usize = 4;

/// Running sums of `V` values over at most the newest `N` samples, in constant time; `N` is a
/// power of two, so that a place in the ring is a few bits of a number. They are restarted after `R` times as many samples,
/// which costs as much as to add up all that are held; ten times as many cost the sums a digit.
#[derive(Clone, Debug)]
pub struct Sums<const N: usize, const V: usize = VALUES, const R: usize = 1> {
    /// Sums of everything before each of the newest samples; a ring.
    before: Box<[[f64; V]; N]>,
    total: [f64; V],
    /// Number of samples that came.
    count: usize,
}

state! { Sums<N, V, R> [const N: usize, const V: usize, const R: usize] { before, total, count } }

impl<const N: usize, const V: usize, const R: usize> Sums<N, V, R> {
    pub fn new() -> Self {
        const { assert!(N.is_power_of_two() && R.is_power_of_two()) };
        Self { before: Box::new([[0.0; V]; N]), total: [0.0; V], count: 0 }
    }

    pub const fn clear(&mut self) {
        (self.total, self.count) = ([0.0; V], 0);
    }

    /// Number of samples that are held.
    #[inline]
    pub fn held(&self) -> usize {
        self.count.min(N)
    }

    /// Number of samples that came since it was cleared.
    #[inline]
    pub const fn count(&self) -> usize {
        self.count
    }

    /// Takes a sample.
    #[inline]
    pub fn push(&mut self, values: [f64; V]) {
        self.before[self.count % N] = self.total;
        for (total, value) in self.total.iter_mut().zip(values) {
            *total += value;
        }
        self.count += 1;
        if self.count.is_multiple_of(R * N) {
            self.rebase();
        }
    }

    /// The sums over the newest `width` samples; `None` if there are not so many.
    #[inline]
    pub fn over(&self, width: usize) -> Option<[f64; V]> {
        (width <= self.held()).then(|| self.newest(width))
    }

    /// The sums over the newest `width` samples, which are known to be held.
    #[inline]
    pub fn newest(&self, width: usize) -> [f64; V] {
        let before = &self.before[self.count.wrapping_sub(width) % N];
        core::array::from_fn(|i| self.total[i] - before[i])
    }

    /// Restarts the sums, which would lose their last digits over years.
    #[cold]
    fn rebase(&mut self) {
        let base = self.total;
        for before in self.before.iter_mut() {
            for (before, base) in before.iter_mut().zip(base) {
                *before -= base;
            }
        }
        self.total = [0.0; V];
    }
}

impl<const N: usize, const V: usize, const R: usize> Default for Sums<N, V, R> {
    fn default() -> Self {
        Self::new()
    }
}

/// Samples that [`Few`] holds.
const HELD_BY_FEW: usize = 8;

/// The newest samples, few enough to be added up each time.
#[derive(Clone, Debug, Default)]
pub struct Few {
    /// Ring stored twice, so that the newest samples are contiguous somewhere.
    rings: [[f64; VALUES]; 2 * HELD_BY_FEW],
    count: usize,
}

whole! { Few { rings, count } }

impl Few {
    pub const fn clear(&mut self) {
        self.count = 0;
    }

    /// Number of samples that are held.
    #[inline]
    pub fn held(&self) -> usize {
        self.count.min(HELD_BY_FEW)
    }

    /// Takes a sample.
    #[inline]
    pub fn push(&mut self, values: [f64; VALUES]) {
        let place = self.count % HELD_BY_FEW;
        self.rings[place] = values;
        self.rings[place + HELD_BY_FEW] = values;
        self.count += 1;
    }

    /// The sample of `ago` pushes before, less than eight.
    #[inline]
    pub fn ago(&self, ago: usize) -> [f64; VALUES] {
        let newest = self.count.wrapping_sub(1) % HELD_BY_FEW + HELD_BY_FEW;
        self.rings[newest - ago % HELD_BY_FEW]
    }

    /// The sums over the newest `width` samples; `None` if there are not so many.
    pub fn over(&self, width: usize) -> Option<[f64; VALUES]> {
        (width <= self.held()).then(|| (0..width).map(|ago| self.ago(ago)).fold([0.0; VALUES], add))
    }
}

/// Sum of both, value by value.
#[inline]
pub fn add(sums: [f64; VALUES], values: [f64; VALUES]) -> [f64; VALUES] {
    core::array::from_fn(|i| sums[i] + values[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sums_are_those_of_the_newest_samples() {
        let (mut sums, mut few) = (Sums::<8>::new(), Few::default());
        let value = |k: i32| [f64::from(k * k % 17), f64::from(k), 0.5, 1.0];
        for from in [0, 1000] {
            for k in from..from + 200 {
                sums.push(value(k));
                few.push(value(k));
                let held = (k - from + 1).min(8) as usize;
                assert_eq!((sums.held(), few.held()), (held, held));
                assert_eq!(few.ago(0), value(k));
                for width in 1..=8 {
                    let newest = (k - width + 1..=k).map(value);
                    let sum = newest.fold([0.0; VALUES], add);
                    let width = width as usize;
                    let expected = (width <= held).then_some(sum);
                    assert_eq!([sums.over(width), few.over(width)], [expected; 2], "{k} {width}");
                }
                assert_eq!(sums.over(9), None);
            }
            sums.clear();
            few.clear();
            assert_eq!((sums.over(1), few.over(1)), (None, None));
        }
    }

    #[test]
    fn months_lose_no_digits() {
        let mut sums = Sums::<1024>::new();
        for _ in 0..20_000_000 {
            sums.push([0.1, 1.0, 0.0, 1.0]);
        }
        let [sum, count, ..] = sums.over(1024).expect("it is full");
        assert!((sum - 102.4).abs() < 1e-10 && count == 1024.0, "{sum}");
    }
}
