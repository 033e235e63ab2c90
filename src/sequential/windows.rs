//! Sums over the newest samples.

/// Samples in each window: about as many as an octave needs, so that what begins between two of
/// them loses little.
pub const WIDTHS: [usize; 20] =
    [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024];

/// Values that are summed.
pub const VALUES: usize = 3;

/// Running sums of some values over the newest `N` samples at most, in constant time; `N` is a power of
/// two, so that a place in the ring is a few bits of a number.
#[derive(Clone, Debug)]
pub struct Sums<const N: usize> {
    /// Of everything before each of the newest samples; a ring.
    before: Box<[[f64; VALUES]; N]>,
    total: [f64; VALUES],
    next: usize,
    held: usize,
}

impl<const N: usize> Sums<N> {
    pub fn new() -> Self {
        const { assert!(N.is_power_of_two()) };
        Self { before: Box::new([[0.0; VALUES]; N]), total: [0.0; VALUES], next: 0, held: 0 }
    }

    pub fn clear(&mut self) {
        (self.total, self.next, self.held) = ([0.0; VALUES], 0, 0);
    }

    /// Samples that are held.
    pub const fn held(&self) -> usize {
        self.held
    }

    /// Takes a sample.
    #[inline]
    pub fn push(&mut self, values: [f64; VALUES]) {
        self.before[self.next % N] = self.total;
        for (total, value) in self.total.iter_mut().zip(values) {
            *total += value;
        }
        self.next = (self.next + 1) % N;
        self.held = (self.held + 1).min(N);
        if self.next == 0 {
            self.rebase();
        }
    }

    /// The sums over the newest `width` samples; `None` if there are not so many.
    #[inline]
    pub fn over(&self, width: usize) -> Option<[f64; VALUES]> {
        (width <= self.held).then(|| {
            let before = &self.before[self.next.wrapping_sub(width) % N];
            std::array::from_fn(|i| self.total[i] - before[i])
        })
    }

    /// Sums that run for years lose their last digits.
    #[cold]
    fn rebase(&mut self) {
        let base = self.total;
        for before in self.before.iter_mut() {
            for (before, base) in before.iter_mut().zip(base) {
                *before -= base;
            }
        }
        self.total = [0.0; VALUES];
    }
}

impl<const N: usize> Default for Sums<N> {
    fn default() -> Self {
        Self::new()
    }
}

/// Sums of some values over the newest `N` samples at most, of which there are so few that they are added
/// up each time. `TWICE` is 2 `N`.
#[derive(Clone, Debug)]
pub struct Few<const N: usize, const TWICE: usize> {
    /// A ring, twice: from `next` on it has the newest in a row, the oldest first.
    rings: [[f64; VALUES]; TWICE],
    next: usize,
    held: usize,
}

impl<const N: usize, const TWICE: usize> Few<N, TWICE> {
    pub const fn new() -> Self {
        const { assert!(TWICE == 2 * N) };
        Self { rings: [[0.0; VALUES]; TWICE], next: 0, held: 0 }
    }

    pub const fn clear(&mut self) {
        self.held = 0;
    }

    /// Samples that are held.
    pub const fn held(&self) -> usize {
        self.held
    }

    /// Takes a sample.
    #[inline]
    pub fn push(&mut self, values: [f64; VALUES]) {
        self.rings[self.next] = values;
        self.rings[self.next + N] = values;
        self.next = if self.next + 1 == N { 0 } else { self.next + 1 };
        self.held = (self.held + 1).min(N);
    }

    /// The sums over the newest sample, over the newest two, and so on. Only the first [`Self::held`] of
    /// them mean anything.
    #[inline]
    pub fn sums(&self) -> [[f64; VALUES]; N] {
        let newest = &self.rings[self.next..][..N];
        let mut sum = [0.0; VALUES];
        std::array::from_fn(|i| {
            let values = newest[N - 1 - i];
            sum = if i == 0 { values } else { std::array::from_fn(|j| sum[j] + values[j]) };
            sum
        })
    }
}

impl<const N: usize, const TWICE: usize> Default for Few<N, TWICE> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sums_are_those_of_the_newest_samples() {
        let (mut sums, mut few) = (Sums::<8>::new(), Few::<6, 12>::new());
        let value = |k: i32| [f64::from(k * k % 17), f64::from(k), 0.5];
        let mut follow = |from: i32| {
            for k in from..from + 200 {
                sums.push(value(k));
                few.push(value(k));
                let pushed = (k - from) as usize + 1;
                assert_eq!((sums.held(), few.held()), (pushed.min(8), pushed.min(6)));
                for width in 1..=8 {
                    let newest = (k - width + 1..=k).map(value);
                    let sum =
                        newest.fold([0.0; VALUES], |s, v| std::array::from_fn(|i| s[i] + v[i]));
                    let width = width as usize;
                    let expected = (width <= sums.held()).then_some(sum);
                    assert_eq!(sums.over(width), expected, "{k} {width}");
                    if width <= few.held() {
                        assert_eq!(few.sums()[width - 1], sum, "{k} {width}");
                    }
                }
            }
            sums.clear();
            few.clear();
            assert_eq!((sums.over(1), few.held()), (None, 0));
        };
        follow(0);
        follow(1000);
    }

    #[test]
    fn months_lose_no_digits() {
        let mut sums = Sums::<1024>::new();
        for _ in 0..20_000_000 {
            sums.push([0.1, 1.0, 0.0]);
        }
        let [sum, count, _] = sums.over(1024).expect("it is full");
        assert!((sum - 102.4).abs() < 1e-10 && count == 1024.0, "{sum}");
    }
}
