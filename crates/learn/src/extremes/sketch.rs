//! Quantiles of a stream.

/// Lower end of the first bin of magnitudes.
const LEAST: f64 = 1e-9;

/// Ratio of neighbouring bins: the accuracy of a quantile.
const RATIO: f64 = 1.005;

/// Number of bins, up to about 1e3.
const BINS: usize = 5600;

/// A histogram of magnitudes in bins of equal ratio.
#[derive(Clone, Debug, PartialEq)]
pub struct Sketch {
    bins: Vec<u64>,
    count: u64,
    largest: f64,
}

impl Sketch {
    pub fn new() -> Self {
        Self { bins: vec![0; BINS], count: 0, largest: 0.0 }
    }

    /// Adds the magnitude of a finite value; other values are ignored.
    pub fn add(&mut self, value: f64) {
        let magnitude = value.abs();
        if !magnitude.is_finite() {
            return;
        }
        // Below the first bin the logarithm is negative and the cast gives 0.
        let place = (magnitude / LEAST).ln() / RATIO.ln();
        self.bins[(place as usize).min(BINS - 1)] += 1;
        self.count += 1;
        self.largest = self.largest.max(magnitude);
    }

    pub const fn count(&self) -> u64 {
        self.count
    }

    pub const fn largest(&self) -> f64 {
        self.largest
    }

    /// Bins that are not empty, merged in groups of `group`: lower and upper end, and the count.
    pub fn bins(&self, group: usize) -> impl Iterator<Item = (f64, f64, u64)> + '_ {
        let group = group.max(1);
        let end = move |bin: usize| LEAST * RATIO.powi(bin as i32);
        let groups = self.bins.chunks(group).enumerate();
        groups
            .map(move |(k, bins)| {
                // What is below the first bin is in it, too.
                let low = if k == 0 { 0.0 } else { end(k * group) };
                (low, end((k + 1) * group), bins.iter().sum())
            })
            .filter(|(_, _, count)| *count > 0)
    }

    /// A magnitude that the share `part` (0 to 1) does not exceed, at most 0.5 % too large; `None`
    /// without data.
    pub fn quantile(&self, part: f64) -> Option<f64> {
        let wanted = (part * self.count as f64).ceil().max(1.0) as u64;
        let mut below = 0;
        let bin = self.bins.iter().position(|bin| {
            below += bin;
            below >= wanted
        })?;
        let upper = LEAST * RATIO.powi(bin as i32 + 1);
        Some(if bin == BINS - 1 { self.largest } else { upper.min(self.largest) })
    }
}

impl Default for Sketch {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_what_came() {
        let mut sketch = Sketch::new();
        assert_eq!(sketch.quantile(0.5), None);
        for k in 1..=1000 {
            sketch.add(if k % 2 == 0 { 1e-6 } else { -1e-6 } * f64::from(k));
        }
        sketch.add(f64::NAN);
        assert_eq!((sketch.count(), sketch.largest()), (1000, 1e-3));
        for part in [0.001, 0.5, 0.95, 0.999] {
            let (found, exact) = (sketch.quantile(part).expect("of a thousand"), part * 1e-3);
            assert!((exact..exact * 1.0051).contains(&found), "{part}: {found}");
        }
        assert_eq!(sketch.quantile(1.0), Some(1e-3));
    }

    #[test]
    fn bins_hold_what_they_counted() {
        let mut sketch = Sketch::new();
        [0.0, 1e-4, 1.001e-4, -2e-3].into_iter().for_each(|value| sketch.add(value));
        let bins: Vec<_> = sketch.bins(8).collect();
        assert_eq!(bins.iter().map(|(_, _, count)| count).sum::<u64>(), 4);
        for value in [0.0, 1e-4, 2e-3] {
            assert!(bins.iter().any(|(low, high, _)| *low <= value && value < *high), "{value}");
        }
    }

    #[test]
    fn nothing_and_the_enormous_are_counted_too() {
        let mut sketch = Sketch::new();
        [0.0, 0.0, 1e9].into_iter().for_each(|value| sketch.add(value));
        assert!(sketch.quantile(0.5).expect("of three") <= 1.1e-9);
        assert_eq!(sketch.quantile(0.9), Some(1e9));
    }
}
