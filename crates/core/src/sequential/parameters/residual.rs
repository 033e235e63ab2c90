//! From readings to residuals, and which of them count.

use crate::time::{self, Decay};

/// Displacements are over no more cycles: those of [`ResidualParameters::motion`] up to 160 Hz.
pub const MOST_CYCLES: usize = 32;

/// The numbers by which readings become residuals.
#[derive(Clone, Debug, PartialEq)]
pub struct ResidualParameters {
    /// Where a reference may be off by more, nothing is known, m; 1e-4 to 3e-4. So much is a fault
    /// elsewhere.
    pub largest_doubt: f64,
    /// A reference may be off by so many of its standard deviations; 2 to 4. Beyond three there is chance
    /// in one node of 370.
    pub doubted: f64,
    /// The time constant of the baseline, s; 30 to 300. Oil warms up in minutes; a fault has to come
    /// faster to be seen beside it.
    pub baseline: f64,
    /// The baseline begins with the mean of so many seconds; 2 to 10. At 50 Hz 250 samples.
    pub baseline_begin: f64,
    /// It follows a residual by at most so many healthy deviations; 2 to 5: as a robust mean does.
    pub baseline_clip: f64,
    /// A residual that may be off by so much teaches the baseline half as much as one that is known, m;
    /// about the dead band.
    pub half_taught: f64,
    /// No temperature does more, m: a sample beyond is wild, and no mean must follow it.
    pub wild: f64,
    /// After a shorter loss of readings the baseline is as good as before, s; up to some seconds.
    /// Temperature takes minutes.
    pub short_loss: f64,
    /// What of the velocity so far is left beside a newer difference of two readings: they move in
    /// counts, and a mean is finer.
    pub velocity_left: Decay,
    /// A displacement is looked at over so long, s; 0.1 to 0.5, up to 160 Hz.
    pub motion: f64,
    /// Slower than this is at rest, m/s; 2e-3 to 1e-2. In `motion` that is 1 mm, more than counts and
    /// noise make.
    pub slowest: f64,
    /// Moves that differ by less are the same, m: the rounding of readings that come as 32-bit floats is
    /// half of that.
    pub rounding: f64,
    /// A residual that differs by less than this part of the healthy deviation is the same; 0 to 1.
    pub alike: f64,
}

impl ResidualParameters {
    pub const DEFAULT: Self = Self {
        largest_doubt: 2e-4,
        doubted: 3.0,
        baseline: 60.0,
        baseline_begin: 5.0,
        baseline_clip: 3.0,
        half_taught: 1e-4,
        wild: 2e-3,
        short_loss: 1.0,
        velocity_left: Decay { left: 0.65, after: 0.02 },
        motion: 0.2,
        slowest: 5e-3,
        rounding: 1e-6,
        alike: 0.5,
    };

    /// The counts for a machine with this `sample_time`, s.
    pub fn cycles(&self, sample_time: f64) -> ResidualCycles {
        let motion = time::cycles(self.motion, sample_time) as usize;
        ResidualCycles {
            baseline_gain: sample_time / self.baseline,
            baseline_begin: libm::round(self.baseline_begin / sample_time),
            velocity_gain: 1.0 - self.velocity_left.per_cycle(sample_time),
            motion: motion.clamp(1, MOST_CYCLES),
        }
    }
}

/// The times of [`ResidualParameters`] in cycles of one machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResidualCycles {
    /// What one sample counts in the baseline.
    pub baseline_gain: f64,
    pub baseline_begin: f64,
    /// What the newest difference of two readings counts in the velocity.
    pub velocity_gain: f64,
    pub motion: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_another_rate_times_are_the_same() {
        let of = |rate: f64| ResidualParameters::DEFAULT.cycles(1.0 / rate);
        assert_eq!([10.0, 50.0, 100.0, 1000.0].map(|rate| of(rate).motion), [2, 10, 20, 32]);
        assert_eq!(of(50.0).velocity_gain, 0.35);
        let left = |rate: f64, cycles: i32| (1.0 - of(rate).velocity_gain).powi(cycles);
        assert!((left(100.0, 10) - left(10.0, 1)).abs() < 1e-12);
        assert_eq!([10.0, 50.0].map(|rate| of(rate).baseline_begin), [50.0, 250.0]);
    }
}
