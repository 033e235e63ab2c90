//! Tests whether a fault is a gain error: an error in proportion to the length.
//!
//! Two explanations of the residuals since the alarm compete, both by least squares: c + g·l, and a
//! function of time, c + s·t + q·t², which may be a step, a ramp or a bent one. While the rod moves
//! up and down, l is no such function of time, and one of them fails.

use super::parameters::{ScaleParameters, SequentialCycles};
use crate::state::{state, whole};
use nalgebra::{SMatrix, SVector};

/// Regressors 1, t, t² and l, and the residual.
const COLUMNS: usize = 5;

const RESIDUAL: usize = 4;

/// What is a function of time.
const OF_TIME: [usize; 3] = [0, 1, 2];

/// What goes with the length.
const OF_LENGTH: [usize; 2] = [0, 3];

/// A gain error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// How much more C1 grows with the length than C2, m per m.
    pub gain: f64,
    /// Log-likelihood of c + g·l less that of the function of time, nats.
    pub nats: f64,
}

whole! { Scale { gain, nats } }

/// Sums of products since an alarm. Memory does not grow.
#[derive(Clone, Debug)]
pub struct Proportion {
    /// Standard deviation of a healthy residual, m.
    deviation: f64,
    /// Least effect of the gain over the stroke that was travelled, m.
    dead_band: f64,
    parameters: &'static ScaleParameters,
    /// Cycles after the alarm that are looked at; t is 1 at their end.
    longest: u32,
    /// So many samples are one.
    alike: f64,
    sums: [[f64; COLUMNS]; COLUMNS],
}

state! {
    Proportion { sums }
    but { deviation, dead_band, parameters, longest, alike }
}

impl Proportion {
    pub const fn new(
        deviation: f64,
        dead_band: f64,
        parameters: &'static ScaleParameters,
        cycles: &SequentialCycles,
    ) -> Self {
        let (longest, alike) = (cycles.scale_longest, cycles.scale_alike);
        let sums = [[0.0; COLUMNS]; COLUMNS];
        Self { deviation, dead_band, parameters, longest, alike, sums }
    }

    /// Restarts for another alarm.
    pub fn begin(&mut self) {
        self.sums = [[0.0; COLUMNS]; COLUMNS];
    }

    /// Takes the residual, m, at a length, m, at `age` cycles after the alarm.
    pub fn push(&mut self, age: u32, length: f64, residual: f64) {
        if age > self.longest {
            return;
        }
        let t = f64::from(age) / f64::from(self.longest);
        let row = [1.0, t, t * t, length, residual / self.deviation];
        for (sums, a) in self.sums.iter_mut().zip(row) {
            for (sum, b) in sums.iter_mut().zip(row) {
                *sum += a * b;
            }
        }
    }

    /// The gain error, where it explains clearly more than time does and enough of the stroke was
    /// travelled; `is_reported`: it was reported before, and only evidence against it takes it back.
    pub fn scale(&self, is_reported: bool) -> Option<Scale> {
        let count = self.sums[0][0];
        let ([_, slope], by_length) = self.fit(OF_LENGTH)?;
        let (_, by_time) = self.fit(OF_TIME)?;
        // Nothing explains more than a healthy residual leaves.
        let ratio = by_time.max(count) / by_length.max(count);
        let nats = 0.5 * count / self.alike * libm::log(ratio);
        let gain = slope * self.deviation;
        let mean = self.sums[0][3] / count;
        let travelled = libm::sqrt((self.sums[3][3] / count - mean * mean).max(0.0));
        let ScaleParameters { evident, clearly, largest, .. } = *self.parameters;
        let is_scale = gain.abs() < largest
            && gain.abs() * travelled > self.dead_band
            && if is_reported { nats > 0.0 } else { nats > evident && ratio > clearly };
        is_scale.then_some(Scale { gain, nats })
    }

    /// Least squares on some of the columns: the coefficients, and the remaining sum of squares, of
    /// residuals in healthy deviations. `None` where the columns are collinear.
    fn fit<const N: usize>(&self, columns: [usize; N]) -> Option<([f64; N], f64)> {
        let matrix = SMatrix::<f64, N, N>::from_fn(|i, j| self.sums[columns[i]][columns[j]]);
        let right = SVector::<f64, N>::from_fn(|i, _| self.sums[columns[i]][RESIDUAL]);
        let solution = matrix.cholesky()?.solve(&right);
        let left = self.sums[RESIDUAL][RESIDUAL] - right.dot(&solution);
        Some((solution.into(), left))
    }
}

#[cfg(test)]
mod tests {
    use super::super::parameters::SequentialParameters;
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const SIGMA: f64 = 1e-4;

    fn of_50_hz() -> Proportion {
        let parameters = &SequentialParameters::DEFAULT;
        Proportion::new(SIGMA, 1e-4, &parameters.scale, &parameters.cycles(0.02))
    }

    /// A rod that moves up and down in 8 s, and a little more slowly, too, for `seconds`.
    fn after(seconds: f64, residual: impl Fn(f64, f64, f64) -> f64) -> Option<Scale> {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut proportion = of_50_hz();
        for age in 0..(seconds / 0.02) as u32 {
            let t = 0.02 * f64::from(age);
            let length = 0.2 + 0.3 * (0.785 * t).sin() + 0.05 * (0.2 * t).cos();
            let wild: f64 = StandardNormal.sample(&mut rng);
            let healthy: f64 = StandardNormal.sample(&mut rng);
            proportion.push(age, length, SIGMA * healthy + residual(t, length, wild));
        }
        proportion.scale(false)
    }

    #[test]
    fn a_gain_is_found_with_its_size_wherever_its_zero_is() {
        for (gain, zero) in [(2e-3, 0.0), (-5e-3, 0.0), (1e-2, -1.5)] {
            let scale = after(10.0, |_, length, _| gain * (length - zero)).expect("it is a gain");
            assert!((scale.gain / gain - 1.0).abs() < 0.05, "{scale:?} for {gain}");
        }
    }

    #[test]
    fn what_time_noise_or_another_fault_explains_is_no_gain() {
        /// Residual as a function of time, s, length, m, and a normal random number.
        type Residual = fn(f64, f64, f64) -> f64;
        let faults: [(&str, Residual); 7] = [
            ("step", |_, _, _| 3e-3),
            ("drift", |t, _, _| 1e-3 * t),
            ("incipient", |t, _, _| 0.07 * (1.0 - 2_f64.powf(-t))),
            ("noise", |_, _, wild| 2e-3 * wild),
            ("a step that goes", |t, _, _| if t < 3.0 { 2e-3 } else { 0.0 }),
            ("frozen", |_, length, _| 0.3 - length),
            ("what the calibration has left", |_, length, _| 2e-4 * length + 3e-3),
        ];
        for (what, fault) in faults {
            for seconds in [0.2, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 60.0] {
                assert_eq!(after(seconds, fault), None, "{what}, {seconds} s");
            }
        }
    }

    /// What the gain does counts over the stroke that was travelled, wherever on the stroke that was.
    #[test]
    fn a_gain_that_does_next_to_nothing_where_the_rod_moves_is_not_told() {
        let around = |middle: f64, amplitude: f64| {
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            let parameters = &SequentialParameters::DEFAULT;
            let (fine, gain) = (2e-5, 1.8e-2);
            let mut proportion =
                Proportion::new(fine, 1e-4, &parameters.scale, &parameters.cycles(0.02));
            for age in 0..1000 {
                let travelled = amplitude * (0.785 * 0.02 * f64::from(age)).sin();
                let healthy: f64 = StandardNormal.sample(&mut rng);
                proportion.push(age, middle + travelled, fine * healthy + gain * travelled);
            }
            proportion.scale(false)
        };
        for middle in [-1.2, 0.0, 1.2] {
            assert_eq!(around(middle, 7e-3), None, "0.09 mm, at {middle} m");
            assert!(around(middle, 12e-3).is_some(), "0.15 mm, at {middle} m");
        }
    }

    #[test]
    fn before_the_rod_has_turned_nothing_is_said() {
        assert_eq!(after(1.5, |_, length, _| 5e-3 * length), None);
    }
}
