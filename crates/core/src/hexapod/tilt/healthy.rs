//! The tilt that is usual while nothing is wrong, and how far its mean strays.

use super::super::{LEGS, TiltParameters};
use super::comparison::are_finite;
use crate::state::whole;
use nalgebra::Matrix2;

/// What is usual while nothing is wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Healthy {
    pub tilt: [f64; 2],
    /// Of the mean around it, rad²: roll, both, pitch.
    pub covariance: [f64; 3],
    /// Cycles for which it has been followed, up to its time constant.
    pub age: u32,
    /// Cycles since the covariance was measured, and how often it was.
    pub since: u32,
    pub measured: u32,
}

whole! {
    Healthy { tilt, covariance, age, since, measured }
    sound |it| it.since < u32::MAX && it.age < u32::MAX && it.measured < u32::MAX && are_finite(&it.tilt)
        && are_finite(&it.covariance) && it.covariance[0] >= 0.0 && it.covariance[2] >= 0.0
}

impl Healthy {
    /// Takes by how much the mean was off.
    pub fn measure(&mut self, off: [f64; 2], by: &TiltParameters) {
        let [first, second] = [0, 1].map(|axis| {
            let limit = by.odd * libm::sqrt(self.covariance[2 * axis]);
            off[axis].clamp(-limit, limit)
        });
        let [counted, most] = by.remembered;
        self.measured = (self.measured + 1).min(most);
        let share = 1.0 / f64::from(counted + self.measured);
        for (own, square) in
            self.covariance.iter_mut().zip([first * first, first * second, second * second])
        {
            *own += share * (square - *own);
        }
    }

    /// S⁻¹ after so many `seconds` without a lesson, with what the geometry is wrong by; `None` if that is no
    /// covariance. A few means do not tell that the sensor is better than its `accuracy`.
    pub fn inverse(
        &self,
        accuracy: f64,
        tilts: &[Option<[f64; 2]>; LEGS],
        seconds: f64,
        by: &TiltParameters,
    ) -> Option<Matrix2<f64>> {
        let squares = tilts.iter().flatten().map(|[roll, pitch]| roll * roll + pitch * pitch);
        let geometry = by.geometry * by.geometry * squares.sum::<f64>();
        let more = by.walk * by.walk * seconds + geometry;
        let [roll, both, pitch] = self.covariance;
        let [roll, pitch] = [roll, pitch].map(|own| own.max(accuracy * accuracy));
        let covariance = Matrix2::new(roll + more, both, both, pitch + more);
        let sound = covariance[(0, 0)] > 0.0 && covariance.determinant() > 0.0;
        covariance.try_inverse().filter(|_| sound)
    }
}
