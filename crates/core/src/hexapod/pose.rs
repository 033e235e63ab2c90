//! Position and attitude of a frame, and how they change.

use nalgebra::{Matrix3, Vector3};

/// A frame within another, (A-6).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Surge, sway, heave, m.
    pub translation: Vector3<f64>,
    /// Roll φ, pitch θ, yaw ψ, rad.
    pub attitude: Vector3<f64>,
}

/// How a [`Pose`] changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseRate {
    /// PoseRate of the translation, m/s.
    pub translation: Vector3<f64>,
    /// Rates of the angles φ̇, θ̇, ψ̇, rad/s; not an angular velocity, see
    /// [`Pose::angular_velocity`].
    pub attitude: Vector3<f64>,
}

impl Default for Pose {
    fn default() -> Self {
        Self { translation: Vector3::zeros(), attitude: Vector3::zeros() }
    }
}

impl Default for PoseRate {
    fn default() -> Self {
        Self { translation: Vector3::zeros(), attitude: Vector3::zeros() }
    }
}

impl Pose {
    /// A pose from surge, sway, heave, m, and roll, pitch, yaw, rad.
    pub fn new(translation: [f64; 3], attitude: [f64; 3]) -> Self {
        Self { translation: translation.into(), attitude: attitude.into() }
    }

    pub fn is_finite(&self) -> bool {
        self.translation.iter().chain(&self.attitude).all(|number| number.is_finite())
    }

    /// Rotation matrix from coordinates of the body to those of the outer frame: first yaw,
    /// then pitch, then roll, each about the axis left by the earlier turns.
    pub fn rotation(&self) -> Matrix3<f64> {
        let [roll, pitch, yaw] = self.attitude.into();
        let ((sr, cr), (sp, cp), (sy, cy)) =
            (libm::sincos(roll), libm::sincos(pitch), libm::sincos(yaw));
        Matrix3::new(
            cy * cp,
            cy * sp * sr - sy * cr,
            cy * sp * cr + sy * sr,
            sy * cp,
            sy * sp * sr + cy * cr,
            sy * sp * cr - cy * sr,
            -sp,
            cp * sr,
            cp * cr,
        )
    }

    /// Axes, as columns in the outer frame, about which roll, pitch and yaw turn at this pose.
    /// Singular where pitch is ±90°.
    pub fn axes(&self) -> Matrix3<f64> {
        let (sp, cp) = libm::sincos(self.attitude[1]);
        let (sy, cy) = libm::sincos(self.attitude[2]);
        Matrix3::new(cy * cp, -sy, 0.0, sy * cp, cy, 0.0, -sp, 0.0, 1.0)
    }

    /// The angular velocity in the outer frame, rad/s, of a body that turns at `rate`.
    pub fn angular_velocity(&self, rate: &PoseRate) -> Vector3<f64> {
        self.axes() * rate.attitude
    }
}
