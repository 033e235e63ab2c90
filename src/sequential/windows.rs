//! Sums over the newest samples.

/// Samples in each window: about as many as an octave needs, so that what begins between two of
/// them loses little.
pub const WIDTHS: [usize; 20] =
    [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024];

/// Values that are summed.
pub const VALUES: usize = 6;

/// Running sums of some values over the newest `N` − 1 samples at most, in constant time.
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
        self.before[self.next] = self.total;
        for (total, value) in self.total.iter_mut().zip(values) {
            *total += value;
        }
        self.next += 1;
        self.held = (self.held + 1).min(N - 1);
        if self.next == N {
            self.next = 0;
            self.rebase();
        }
    }

    /// The sums over the newest `width` samples; `None` if there are not so many.
    #[inline]
    pub fn over(&self, width: usize) -> Option<[f64; VALUES]> {
        (width <= self.held).then(|| {
            let i = self.next + if self.next < width { N } else { 0 } - width;
            let before = &self.before[i];
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sums_are_those_of_the_newest_samples() {
        let mut sums = Sums::<9>::new();
        let value = |k: i32| [f64::from(k * k % 17), f64::from(k), 1.0, -f64::from(k), 0.5, 2.0];
        for k in 0..200 {
            sums.push(value(k));
            let held = (k as usize + 1).min(8);
            assert_eq!(sums.held(), held);
            for width in 1..=8 {
                let newest = (k - width + 1..=k).map(value);
                let sum = newest.fold([0.0; VALUES], |s, v| std::array::from_fn(|i| s[i] + v[i]));
                let expected = (width as usize <= held).then_some(sum);
                assert_eq!(sums.over(width as usize), expected, "{k} {width}");
            }
        }
        sums.clear();
        assert_eq!(sums.over(1), None);
    }

    #[test]
    fn months_lose_no_digits() {
        let mut sums = Sums::<1025>::new();
        for _ in 0..20_000_000 {
            sums.push([0.1, 1.0, 0.0, 0.0, 1.0, 1.0]);
        }
        let [sum, count, ..] = sums.over(1024).expect("it is full");
        assert!((sum - 102.4).abs() < 1e-10 && count == 1024.0, "{sum}");
    }
}
