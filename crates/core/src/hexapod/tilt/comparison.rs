//! One comparison of the deck by the lengths with the deck by its sensor.

use super::super::{Hexapod, LEGS, Legs, Pose};
use nalgebra::{RowVector3, Vector3};

/// A comparison.
pub struct Comparison {
    /// By the sensor less by the lengths: roll and pitch, rad.
    pub tilt: [f64; 2],
    pub deck: Pose,
    /// The vertical in the deck's frame, by the lengths.
    pub up: RowVector3<f64>,
    pub vessel: [f64; 2],
}

impl Comparison {
    /// By how much roll and pitch of the deck grow with the length of each cylinder, rad/m; `None` where the pose is
    /// singular.
    pub fn slopes(&self, hexapod: &Hexapod) -> Option<[[f64; 2]; LEGS]> {
        let legs = Legs::new(hexapod, &Pose::default(), &self.deck);
        let inverse = legs.jacobian().try_inverse()?;
        let (rotation, vertical) = (self.deck.rotation(), up(self.vessel));
        let [x, y, z] = [self.up[0], self.up[1], self.up[2]];
        let slopes: [[f64; 2]; LEGS] = core::array::from_fn(|leg| {
            let turn: Vector3<f64> = inverse.fixed_view::<3, 1>(3, leg).into_owned();
            let change = vertical * turn.cross_matrix() * rotation;
            let roll = (z * change[1] - y * change[2]) / (y * y + z * z);
            let pitch = -change[0] / libm::sqrt(1.0 - x * x);
            [roll, pitch]
        });
        slopes.iter().all(are_finite).then_some(slopes)
    }
}

/// The vertical in the frame of a body with this roll and pitch; yaw does not change it.
pub fn up([roll, pitch]: [f64; 2]) -> RowVector3<f64> {
    let ((sr, cr), (sp, cp)) = (libm::sincos(roll), libm::sincos(pitch));
    RowVector3::new(-sp, cp * sr, cp * cr)
}

/// Roll and pitch of a body that has the vertical at `up`.
pub fn inclination(up: &RowVector3<f64>) -> [f64; 2] {
    [libm::atan2(up[1], up[2]), -libm::asin(up[0].clamp(-1.0, 1.0))]
}

pub fn are_finite<const N: usize>(numbers: &[f64; N]) -> bool {
    numbers.iter().all(|number| number.is_finite())
}
