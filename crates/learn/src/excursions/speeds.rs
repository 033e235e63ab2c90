//! Times spent at the speeds of a rod, and in which third of the time a speed is.

/// Width of a bin, m/s.
const BIN: f64 = 2e-3;

/// Number of bins; the last one has no upper end. Rods of gangways move at up to about 1 m/s.
const BINS: usize = 1024;

/// Classes of speed with equal times.
pub(super) const CLASSES: usize = 3;

/// Number of samples by speed.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SpeedTimes {
    bins: Vec<u64>,
}

/// In which bin a speed, m/s, is.
fn bin(speed: f64) -> usize {
    // Not a number becomes 0.
    ((speed.abs() / BIN) as usize).min(BINS - 1)
}

impl Default for SpeedTimes {
    fn default() -> Self {
        Self { bins: vec![0; BINS] }
    }
}

impl SpeedTimes {
    /// Adds a sample at a speed, m/s.
    pub fn add(&mut self, speed: f64) {
        self.bins[bin(speed)] += 1;
    }

    /// Numbers of `speeds`, m/s, in the classes of equal times, from the slowest. A bin that is in
    /// more than one class, as of a rod that stands half of the time, is shared among them.
    pub fn count_by_class(&self, speeds: impl Iterator<Item = f64>) -> [f64; CLASSES] {
        let shares = self.shares();
        let mut counts = [0.0; CLASSES];
        for share in speeds.map(|speed| shares[bin(speed)]) {
            for (count, part) in counts.iter_mut().zip(share) {
                *count += part;
            }
        }
        counts
    }

    /// How each bin is shared among the classes.
    fn shares(&self) -> Vec<[f64; CLASSES]> {
        let all = self.bins.iter().sum::<u64>().max(1) as f64;
        let mut until = 0;
        let share = |count: &u64| {
            let from = until as f64 / all;
            until += count;
            let to = until as f64 / all;
            std::array::from_fn(|class| {
                let [low, high] = [class, class + 1].map(|end| end as f64 / CLASSES as f64);
                if to > from {
                    (to.min(high) - from.max(low)).max(0.0) / (to - from)
                } else {
                    // Nothing was counted there; the slowest class takes the first bins.
                    f64::from(u8::from((low..high).contains(&from.min(1.0 - f64::EPSILON))))
                }
            })
        };
        self.bins.iter().map(share).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_have_equal_times() {
        let mut times = SpeedTimes::default();
        (0..300).for_each(|k| times.add(2e-3 * f64::from(k) + 1e-3));
        let counts = times.count_by_class([0.0, 0.1, 0.3, 0.59, 5.0].into_iter());
        assert!(counts.iter().zip([2.0, 1.0, 2.0]).all(|(one, other)| (one - other).abs() < 1e-9));
    }

    #[test]
    fn a_rod_that_stands_has_no_classes() {
        let mut times = SpeedTimes::default();
        (0..1000).for_each(|_| times.add(0.0));
        let counts = times.count_by_class([0.0; 30].into_iter());
        assert!(counts.iter().all(|count| (count - 10.0).abs() < 1e-9), "{counts:?}");
        // Of one that stands half of the time, a third of the standing is in the middle class.
        (0..1000).for_each(|k| times.add(0.1 + 1e-4 * f64::from(k)));
        let counts = times.count_by_class([0.0; 30].into_iter());
        assert!((counts[0] - 20.0).abs() < 1e-9 && (counts[1] - 10.0).abs() < 1e-9, "{counts:?}");
    }

    #[test]
    fn no_speed_is_beyond_the_bins() {
        let mut times = SpeedTimes::default();
        let odd = [f64::NAN, f64::INFINITY, -1e300, 1e-300];
        for speed in odd {
            times.add(speed);
        }
        let none = SpeedTimes::default();
        for times in [times, none] {
            let counts = times.count_by_class(odd.into_iter());
            assert!((counts.iter().sum::<f64>() - 4.0).abs() < 1e-9, "{counts:?}");
        }
    }
}
