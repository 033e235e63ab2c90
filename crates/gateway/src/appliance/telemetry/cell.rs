//! Numbers that one thread writes and any thread reads, without a lock.

use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};

/// A total. Only one thread adds to it, so a load and a store are enough.
#[derive(Debug, Default)]
pub(super) struct Total(AtomicU64);

impl Total {
    pub fn add(&self, more: u64) {
        if more > 0 {
            self.0.store(self.get().wrapping_add(more), Ordering::Relaxed);
        }
    }

    /// Adds the growth of a count since it was `last`. A count that restarted has grown by its
    /// present value.
    pub fn follow(&self, last: u64, now: u64) {
        self.add(now.checked_sub(last).unwrap_or(now));
    }

    pub fn get(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// A number that may be absent; inside, not-a-number stands for none.
#[derive(Debug)]
pub(super) struct Gauge(AtomicU64);

impl Default for Gauge {
    fn default() -> Self {
        Self(AtomicU64::new(f64::NAN.to_bits()))
    }
}

impl Gauge {
    pub fn set(&self, value: Option<f64>) {
        self.0.store(value.unwrap_or(f64::NAN).to_bits(), Ordering::Relaxed);
    }

    pub fn get(&self) -> Option<f64> {
        let value = f64::from_bits(self.0.load(Ordering::Relaxed));
        value.is_finite().then_some(value)
    }
}

/// One of a few states by its number, or none.
#[derive(Debug)]
pub(super) struct State(AtomicU8);

/// Number for no state; no enumeration here has this many.
const NO_STATE: u8 = u8::MAX;

impl Default for State {
    fn default() -> Self {
        Self(AtomicU8::new(NO_STATE))
    }
}

impl State {
    pub fn set(&self, number: Option<u8>) {
        self.0.store(number.unwrap_or(NO_STATE), Ordering::Relaxed);
    }

    pub fn get(&self) -> Option<u8> {
        Some(self.0.load(Ordering::Relaxed)).filter(|&number| number != NO_STATE)
    }
}

/// Number of values between fixed bounds.
#[derive(Debug)]
pub(super) struct Histogram {
    bounds: &'static [f64],
    /// One count for each bound, which includes the bound, and one for values beyond.
    counts: Box<[AtomicU64]>,
    sum: AtomicU64,
}

impl Histogram {
    /// A histogram with these `bounds`, which ascend.
    pub fn new(bounds: &'static [f64]) -> Self {
        let counts = (0..=bounds.len()).map(|_| AtomicU64::new(0)).collect();
        Self { bounds, counts, sum: AtomicU64::new(0.0_f64.to_bits()) }
    }

    /// Counts `value`. As with [`Total`], only one thread may do so.
    pub fn observe(&self, value: f64) {
        let place = self.bounds.partition_point(|&bound| bound < value);
        let count = &self.counts[place];
        count.store(count.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
        self.sum.store((self.sum() + value).to_bits(), Ordering::Relaxed);
    }

    pub fn sum(&self) -> f64 {
        f64::from_bits(self.sum.load(Ordering::Relaxed))
    }

    /// Upper bounds, the last one infinite, and the number of values between each and the previous
    /// one.
    pub fn buckets(&self) -> Vec<(f64, u64)> {
        let bounds = self.bounds.iter().copied().chain([f64::INFINITY]);
        bounds.zip(self.counts.iter().map(|count| count.load(Ordering::Relaxed))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_total_goes_on_over_a_count_that_begins_again() {
        let total = Total::default();
        for (last, now, shown) in [(0, 5, 5), (5, 7, 7), (7, 3, 10), (3, 3, 10)] {
            total.follow(last, now);
            assert_eq!(total.get(), shown);
        }
    }

    #[test]
    fn a_bound_belongs_to_its_bucket() {
        let histogram = Histogram::new(&[0.1, 1.0]);
        for value in [0.0, 0.1, 0.100_1, 1.0, 1.5, 1e9] {
            histogram.observe(value);
        }
        assert_eq!(histogram.buckets(), [(0.1, 2), (1.0, 2), (f64::INFINITY, 2)]);
        assert_eq!(histogram.sum(), 1_000_000_002.700_1);
    }
}
