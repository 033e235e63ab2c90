//! The error of the prediction by the command alone as a function of time, as measured.
//!
//! While there are readings, copies of the estimate are predicted by the command alone for 1, 2, 4,
//! … cycles and then compared with the readings. The error thus includes everything that the model
//! leaves out: load, supply pressure, friction, wrong parameters.

use super::mean::Mean;
use crate::state::whole;
use nalgebra::{Matrix3, Vector3};

/// Shadows, the longest of 512 cycles. Beyond them the variance is reckoned.
const SHADOWS: usize = 10;

#[derive(Clone, Copy, Debug, Default)]
struct Shadow {
    x: Vector3<f64>,
    /// Cycles since the copy was taken; `None`: there is none at present.
    age: Option<u32>,
    /// Mean of the squared errors, m².
    squares: Mean,
}

whole! {
    Shadow { x, age, squares }
    sound |it| it.age.is_none_or(|age| age < u32::MAX / 2)
}

/// The measured error of the prediction.
#[derive(Clone, Debug, Default)]
pub struct Growth {
    shadows: [Shadow; SHADOWS],
}

whole! { Growth { shadows } }

impl Growth {
    /// Drops the copies, because what follows cannot be compared with them.
    pub fn recall(&mut self) {
        self.shadows.iter_mut().for_each(|shadow| shadow.age = None);
    }

    /// Compares the copies that are due with `x`, the state by the readings, and takes new ones; the
    /// newest `memory` cycles count.
    pub fn compare(&mut self, x: &Vector3<f64>, memory: u32) {
        for (octave, shadow) in self.shadows.iter_mut().enumerate() {
            let length = 1 << octave;
            match shadow.age {
                Some(age) if age < length => continue,
                Some(age) if age == length => {
                    let error = shadow.x[0] - x[0];
                    shadow.squares.add(error * error, memory >> octave);
                }
                // Not sent, or there was nothing to compare with when it came back.
                _ => {}
            }
            (shadow.x, shadow.age) = (*x, Some(0));
        }
    }

    /// Predicts the next cycle with the command's `part`.
    pub fn predict(&mut self, a: &Matrix3<f64>, part: &Vector3<f64>) {
        for shadow in &mut self.shadows {
            if let Some(age) = &mut shadow.age {
                shadow.x = a * shadow.x + part;
                *age += 1;
            }
        }
    }

    /// Variance that `cycles` of prediction add, m², with the `doubt` of [`super::EstimateParameters`]; `None`
    /// if nothing was measured.
    ///
    /// It is interpolated linearly between two copies. Beyond the longest one that was compared it
    /// grows with the square of time, like the effect of a wrong velocity.
    pub fn variance(&self, cycles: u32, doubt: f64) -> Option<f64> {
        let (mut before, mut least) = (0.0, 0.0_f64);
        for (octave, shadow) in self.shadows.iter().enumerate() {
            let (count, length) = (f64::from(shadow.squares.count()), f64::from(1_u32 << octave));
            if count == 0.0 {
                break;
            }
            let variance = least.max(shadow.squares.value() * (1.0 + doubt / count));
            let time = f64::from(cycles);
            if time <= length {
                return Some(least + (variance - least) * (time - before) / (length - before));
            }
            (before, least) = (length, variance);
        }
        let ratio = f64::from(cycles) / before;
        (before > 0.0).then_some(least * ratio * ratio)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MEMORY: u32 = 15_000;
    const DOUBT: f64 = 4.0;

    /// A length whose prediction lags by 1 mm a cycle.
    fn measured(cycles: u32) -> Growth {
        let mut growth = Growth::default();
        for k in 0..cycles {
            growth.compare(&Vector3::new(1e-3 * f64::from(k), 0.0, 0.0), MEMORY);
            growth.predict(&Matrix3::identity(), &Vector3::zeros());
        }
        growth
    }

    #[test]
    fn a_velocity_that_is_off_is_measured_and_carried_on() {
        let growth = measured(20_000);
        for cycles in [1_u32, 2, 4, 64, 512] {
            let sigma = growth.variance(cycles, DOUBT).expect("it was measured").sqrt();
            let expected = 1e-3 * f64::from(cycles);
            assert!(sigma >= expected && sigma < 1.07 * expected, "{cycles}: {sigma}");
        }
        let three = growth.variance(3, DOUBT).expect("it was measured");
        assert!((three / 1e-6 - 10.0).abs() < 0.1, "half way from 4 to 16: {three}");
        let far = growth.variance(5120, DOUBT).expect("it was measured").sqrt();
        assert!(far > 5.12 && far < 5.6, "{far}");
    }

    #[test]
    fn what_was_never_measured_is_not_known() {
        assert_eq!(Growth::default().variance(1, DOUBT), None);
        assert_eq!(measured(1).variance(1, DOUBT), None);
        assert!(measured(2).variance(1, DOUBT).is_some_and(|v| (v / 5e-6 - 1.0).abs() < 1e-9));
    }

    #[test]
    fn a_recalled_shadow_is_compared_with_nothing() {
        let mut growth = measured(20_000);
        let before = growth.variance(64, DOUBT);
        growth.recall();
        growth.compare(&Vector3::new(-700.0, 0.0, 0.0), MEMORY);
        assert_eq!(growth.variance(64, DOUBT), before);
    }
}
