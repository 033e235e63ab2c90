//! Histogram of a residual against its threshold.

/// Number of bins on either side of zero.
const SIDE: usize = 60;

/// Range of the scale, as a multiple of the threshold.
const REACH: f64 = 3.0;

/// Equal bins around zero; values beyond the scale are counted by their side.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// Width of a bin, in the unit of the values.
    width: f64,
    counts: [u64; 2 * SIDE],
    beyond: u64,
}

impl Histogram {
    /// A histogram that reaches to three times `threshold`.
    pub fn new(threshold: f64) -> Self {
        let sound = threshold > 0.0 && threshold.is_finite();
        let reach = REACH * if sound { threshold } else { 1e-3 };
        Self { width: reach / SIDE as f64, counts: [0; 2 * SIDE], beyond: 0 }
    }

    /// Adds a value; not-a-number is ignored.
    pub fn add(&mut self, value: f64) {
        let place = (value / self.width).floor() + SIDE as f64;
        if (0.0..(2 * SIDE) as f64).contains(&place) {
            self.counts[place as usize] += 1;
        } else if !value.is_nan() {
            self.beyond += 1;
        }
    }

    /// End of the scale.
    pub fn reach(&self) -> f64 {
        self.width * SIDE as f64
    }

    pub const fn width(&self) -> f64 {
        self.width
    }

    /// Number of values beyond the scale.
    pub const fn beyond(&self) -> u64 {
        self.beyond
    }

    /// Number of all values, including those beyond the scale.
    pub fn count(&self) -> u64 {
        self.counts.iter().sum::<u64>() + self.beyond
    }

    /// Lower end of each bin and its count, and the end of the last one.
    pub fn steps(&self) -> Vec<(f64, f64)> {
        let place = |k: usize| (k as f64 - SIDE as f64) * self.width;
        let bins = self.counts.iter().enumerate().map(|(k, count)| (place(k), *count as f64));
        bins.chain([(place(2 * SIDE), 0.0)]).collect()
    }

    /// Adds the counts of `other`, whose scale is the same.
    pub fn merge(&mut self, other: &Self) {
        self.counts.iter_mut().zip(other.counts).for_each(|(count, more)| *count += more);
        self.beyond += other.beyond;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_counted_where_it_belongs() {
        let mut histogram = Histogram::new(1e-3);
        for value in
            [0.0, 1e-6, -1e-6, 2.999e-3, -2.999e-3, 3.001e-3, -1.0, f64::INFINITY, f64::NAN]
        {
            histogram.add(value);
        }
        assert_eq!((histogram.count(), histogram.beyond()), (8, 3));
        let steps = histogram.steps();
        assert_eq!((steps[59].1, steps[60].1, steps[0].1, steps[119].1), (1.0, 2.0, 1.0, 1.0));
        assert!((steps[0].0 + 3e-3).abs() < 1e-12 && (steps[120].0 - 3e-3).abs() < 1e-12);
        let mut twice = histogram.clone();
        twice.merge(&histogram);
        assert_eq!((twice.count(), twice.steps()[60].1), (16, 4.0));
    }
}
