//! Scatter of healthy residuals: noise, and a part that grows with the speed of the rod.
//!
//! Two transducers are never sampled at exactly the same time. The random part of that time, times
//! the velocity, appears in their difference: σ² + (s v)².

use super::parameters::SamplingParameters;
use crate::state::whole;

/// Nobody has sampled two devices more alike than this, s: a calibration that says so was lucky.
pub const LEAST_TIMING: f64 = SamplingParameters::DEFAULT.least_timing;

/// Scatter of healthy residuals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation σ at rest, m.
    pub rest: f64,
    /// Standard deviation s of the time between the samples of C1 and C2, s.
    pub timing: f64,
}

whole! { Noise { rest, timing } }

impl Noise {
    /// Least scatter from the rounding of readings with this `resolution`, m.
    pub fn of_rounding(resolution: [f64; 2]) -> f64 {
        let squares: f64 = resolution.iter().map(|count| count * count / 12.0).sum();
        libm::sqrt(squares)
    }

    /// This scatter, with a timing that can be relied on.
    pub fn relied_on(self) -> Self {
        Self { timing: self.timing.max(LEAST_TIMING), ..self }
    }

    /// Variance at a `velocity`, m/s, in m².
    pub fn variance(&self, velocity: f64) -> f64 {
        let by_timing = self.timing * velocity;
        self.rest * self.rest + by_timing * by_timing
    }

    /// Factor with which a residual at a `velocity`, m/s, scatters as one at rest does; 0 to 1.
    pub fn share(&self, velocity: f64) -> f64 {
        libm::sqrt(self.rest * self.rest / self.variance(velocity))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faster_is_wider() {
        let noise = Noise { rest: 3e-4, timing: 4e-4 };
        assert!((noise.variance(-1.0) - 25e-8).abs() < 1e-20);
        assert!((noise.share(1.0) - 0.6).abs() < 1e-12 && noise.share(0.0) == 1.0);
        let lucky = Noise { timing: 0.0, ..noise }.relied_on();
        assert_eq!(lucky.timing, LEAST_TIMING);
        assert!((Noise::of_rounding([3e-4, 4e-4]) - 5e-4 / 12_f64.sqrt()).abs() < 1e-12);
    }
}
