//! The last hour of a cylinder for pictures: the least and the largest of each quantity in each half second.

use std::sync::atomic::{AtomicI64, AtomicU32, AtomicU64, Ordering};
use tertius_core::estimate::Estimate;
use tertius_core::monitor::Record;
use tertius_core::time::{Span, Timestamp};

/// Length of a bin.
pub const STEP: Span = Span::from_nanos(500_000_000);

/// Number of bins that are kept: an hour of them.
pub const KEPT: usize = 7200;

/// Bins at the old end that are not read, since the writer may replace them meanwhile. It takes 4 s for these.
const MARGIN: u64 = 8;

/// What is followed, in the order of a [`Bin`]'s ranges.
pub const QUANTITIES: [&str; 7] = ["c1", "c2", "r1", "r2", "r3", "estimate", "sigma"];

/// Least and largest value of each quantity in a bin, m; not-a-number for none.
pub type Ranges = [[f32; 2]; QUANTITIES.len()];

/// Of a bin without values.
pub(super) const EMPTY: Ranges = [[f32::NAN; 2]; QUANTITIES.len()];

/// A bin as it was written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bin {
    pub begin: Timestamp,
    pub ranges: Ranges,
}

/// A bin in atomics.
#[derive(Debug)]
struct Place {
    begin: AtomicI64,
    ranges: [[AtomicU32; 2]; QUANTITIES.len()],
}

/// The bins of one cylinder. One thread writes, any may read.
#[derive(Debug)]
pub struct Trend {
    places: Box<[Place]>,
    /// Number of bins so far; the place of the next is this modulo [`KEPT`].
    written: AtomicU64,
}

impl Default for Trend {
    fn default() -> Self {
        let number = || [AtomicU32::new(0), AtomicU32::new(0)];
        let place =
            |_| Place { begin: AtomicI64::new(0), ranges: std::array::from_fn(|_| number()) };
        Self { places: (0..KEPT).map(place).collect(), written: AtomicU64::new(0) }
    }
}

impl Trend {
    fn push(&self, bin: &Bin) {
        let written = self.written.load(Ordering::Relaxed);
        let place = &self.places[written as usize % KEPT];
        place.begin.store(bin.begin.as_nanos(), Ordering::Relaxed);
        for (to, from) in place.ranges.iter().flatten().zip(bin.ranges.iter().flatten()) {
            to.store(from.to_bits(), Ordering::Relaxed);
        }
        self.written.store(written + 1, Ordering::Release);
    }

    fn bin(&self, number: u64) -> Bin {
        let place = &self.places[number as usize % KEPT];
        let value = |number: &AtomicU32| f32::from_bits(number.load(Ordering::Relaxed));
        let ranges = place.ranges.each_ref().map(|range| range.each_ref().map(value));
        Bin { begin: Timestamp::from_nanos(place.begin.load(Ordering::Relaxed)), ranges }
    }

    /// The newest bins that began after `since`, in the order of time. Bins from before the clock was set
    /// back are left out.
    pub fn after(&self, since: Timestamp) -> Vec<Bin> {
        let written = self.written.load(Ordering::Acquire);
        let oldest = written.saturating_sub(KEPT as u64 - MARGIN);
        let mut bins: Vec<Bin> = Vec::new();
        for number in (oldest..written).rev() {
            let bin = self.bin(number);
            if bin.begin <= since || bins.last().is_some_and(|newer| newer.begin <= bin.begin) {
                break;
            }
            bins.push(bin);
        }
        bins.reverse();
        bins
    }

    /// The newest complete bin.
    pub fn newest(&self) -> Option<Bin> {
        let written = self.written.load(Ordering::Acquire);
        written.checked_sub(1).map(|number| self.bin(number))
    }
}

/// The bin that the writer's thread fills.
#[derive(Debug)]
pub(super) struct Filling {
    /// Begin of the bin; `None` before the first cycle.
    begin: Option<Timestamp>,
    ranges: Ranges,
}

impl Default for Filling {
    fn default() -> Self {
        Self { begin: None, ranges: EMPTY }
    }
}

impl Filling {
    /// Takes a cycle of the cylinder that `trend` is of.
    pub fn record(&mut self, record: &Record, trend: &Trend) {
        let begin = floor(record.timestamp);
        if self.begin != Some(begin) {
            let ranges = std::mem::replace(&mut self.ranges, EMPTY);
            if let Some(begin) = self.begin.replace(begin) {
                trend.push(&Bin { begin, ranges });
            }
        }
        let values = [record.c1, record.c2_corrected.or(record.c2)];
        let values = values.iter().chain(&record.residuals);
        for (range, value) in self.ranges.iter_mut().zip(values) {
            widen(range, *value);
        }
    }

    /// Takes the valid estimate of the cycle whose record came last.
    pub fn estimate(&mut self, estimate: Option<&Estimate>) {
        let [.., position, sigma] = &mut self.ranges;
        widen(position, estimate.map(|it| it.position));
        widen(sigma, estimate.map(|it| it.sigma));
    }
}

/// Begin of the bin that `at` is in.
fn floor(at: Timestamp) -> Timestamp {
    let nanos = at.as_nanos();
    Timestamp::from_nanos(nanos - nanos.rem_euclid(STEP.as_nanos()))
}

/// `min` and `max` ignore not-a-number.
fn widen(range: &mut [f32; 2], value: Option<f64>) {
    if let Some(value) = value {
        let value = value as f32;
        *range = [range[0].min(value), range[1].max(value)];
    }
}

/// At most `most` bins in which `bins` are merged, neighbours with neighbours.
pub fn merged(bins: &[Bin], most: usize) -> Vec<Bin> {
    let size = bins.len().div_ceil(most.max(1)).max(1);
    let merge = |bins: &[Bin]| {
        let mut merged = bins[0];
        for (range, other) in
            bins[1..].iter().flat_map(|bin| (0..QUANTITIES.len()).map(move |i| (i, bin.ranges[i])))
        {
            let [least, largest] = merged.ranges[range];
            merged.ranges[range] = [least.min(other[0]), largest.max(other[1])];
        }
        merged
    };
    bins.chunks(size).map(merge).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bin(half_seconds: i64, value: f32) -> Bin {
        let begin = Timestamp::from_nanos(half_seconds * STEP.as_nanos());
        Bin { begin, ranges: [[value; 2]; QUANTITIES.len()] }
    }

    #[test]
    fn an_hour_is_kept_and_a_clock_that_was_set_back_begins_a_new_one() {
        let trend = Trend::default();
        assert_eq!(trend.after(Timestamp::from_nanos(i64::MIN)), []);
        (0..2 * KEPT as i64).for_each(|k| trend.push(&bin(k, k as f32)));
        let all = trend.after(Timestamp::from_nanos(i64::MIN));
        assert_eq!(all.len(), KEPT - MARGIN as usize);
        assert_eq!(all.last(), Some(&bin(2 * KEPT as i64 - 1, (2 * KEPT - 1) as f32)));
        assert!(all.is_sorted_by(|a, b| a.begin < b.begin));
        let since = bin(2 * KEPT as i64 - 4, 0.0).begin;
        assert_eq!(trend.after(since).len(), 3);
        (5..8).for_each(|k| trend.push(&bin(k, 0.0)));
        assert_eq!(trend.after(Timestamp::from_nanos(i64::MIN)).len(), 3, "those of the new time");
    }

    #[test]
    fn what_is_merged_keeps_its_extremes() {
        let bins: Vec<Bin> = [3.0, -1.0, f32::NAN, 7.0, 2.0]
            .into_iter()
            .enumerate()
            .map(|(k, value)| bin(k as i64, value))
            .collect();
        let merged = merged(&bins, 2);
        let ranges: Vec<[f32; 2]> = merged.iter().map(|bin| bin.ranges[0]).collect();
        assert_eq!(ranges, [[-1.0, 3.0], [2.0, 7.0]]);
        assert_eq!(merged[1].begin, bins[3].begin);
    }
}
