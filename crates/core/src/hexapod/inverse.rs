//! Lengths and velocities of the cylinders from poses (section A-1).

use super::{Hexapod, KinematicsError, LEGS, Pose, PoseRate};
use nalgebra::{SMatrix, Vector3};

/// The legs between a base and a deck, in the frame in which both poses are given.
#[derive(Clone, Debug, PartialEq)]
pub struct Legs {
    /// zᵢ of: unit vectors from base to deck.
    pub directions: [Vector3<f64>; LEGS],
    /// ℓᵢ of, m.
    pub lengths: [f64; LEGS],
    /// R̄ b, R̄ t of and: from each frame's origin to its gimbals, m.
    pub base_arms: [Vector3<f64>; LEGS],
    pub top_arms: [Vector3<f64>; LEGS],
}

impl Hexapod {
    /// the strokes that hold the deck at `top` over a base at `base`, both poses in the
    /// same frame, m.
    ///
    /// # Errors
    /// A cylinder does not reach that far.
    pub fn inverse(&self, base: &Pose, top: &Pose) -> Result<[f64; LEGS], KinematicsError> {
        let strokes = Legs::new(self, base, top).strokes(self);
        self.check(&strokes)?;
        Ok(strokes)
    }
}

impl Legs {
    /// Legs between `base` and `top`, (A-4) to. Nothing is checked: see [`Hexapod::inverse`].
    pub fn new(hexapod: &Hexapod, base: &Pose, top: &Pose) -> Self {
        let (base_turn, top_turn) = (base.rotation(), top.rotation());
        let apart = top.translation - base.translation;
        let base_arms = hexapod.base.map(|gimbal| base_turn * gimbal);
        let top_arms = hexapod.top.map(|gimbal| top_turn * gimbal);
        let spans: [Vector3<f64>; LEGS] =
            core::array::from_fn(|leg| apart + top_arms[leg] - base_arms[leg]);
        let lengths = spans.map(|span| span.norm());
        let directions = core::array::from_fn(|leg| spans[leg] / lengths[leg]);
        Self { directions, lengths, base_arms, top_arms }
    }

    /// Strokes, m.
    pub fn strokes(&self, hexapod: &Hexapod) -> [f64; LEGS] {
        self.lengths.map(|length| length - hexapod.neutral_length())
    }

    /// Velocities ℓ̇ᵢ of the cylinders while base and deck move, m/s, (A-13). Each motion
    /// turns its own arms, so this equals (A-14)'s J(ẋ − ẋₛ) only where both frames have the same
    /// origin.
    pub fn velocities(&self, base: FrameMotion<'_>, top: FrameMotion<'_>) -> [f64; LEGS] {
        let apart = top.rate.translation - base.rate.translation;
        let (base_spin, top_spin) = (base.spin(), top.spin());
        core::array::from_fn(|leg| {
            let turned =
                top_spin.cross(&self.top_arms[leg]) - base_spin.cross(&self.base_arms[leg]);
            self.directions[leg].dot(&(apart + turned))
        })
    }

    /// The Jacobian, 6×6: from the deck's velocity and angular velocity (m/s, rad/s) to the
    /// cylinders' velocities, with the base at rest.
    pub fn jacobian(&self) -> SMatrix<f64, LEGS, LEGS> {
        let mut jacobian = SMatrix::<f64, LEGS, LEGS>::zeros();
        for leg in 0..LEGS {
            let direction = &self.directions[leg];
            let moment = self.top_arms[leg].cross(direction);
            jacobian.fixed_view_mut::<1, 3>(leg, 0).copy_from(&direction.transpose());
            jacobian.fixed_view_mut::<1, 3>(leg, 3).copy_from(&moment.transpose());
        }
        jacobian
    }
}

/// A moving frame.
#[derive(Clone, Copy, Debug)]
pub struct FrameMotion<'a> {
    pub pose: &'a Pose,
    pub rate: &'a PoseRate,
}

impl FrameMotion<'_> {
    fn spin(&self) -> Vector3<f64> {
        self.pose.angular_velocity(self.rate)
    }
}
