//! Positions of the gimbals.

use super::{KinematicsError, LEGS, Pose};
use core::f64::consts::TAU;
use nalgebra::Vector3;

/// Dimensions of a hexapod with three pairs of gimbals on a circle at each end. Every leg leads
/// from a base pair to the deck's pair beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// Radius of the circle of the base gimbals, m.
    pub base_radius: f64,
    /// Half of the angle between the two gimbals of a pair, rad.
    pub base_half_angle: f64,
    /// Radius of the circle of the deck gimbals, m.
    pub top_radius: f64,
    pub top_half_angle: f64,
    /// Height of the deck above the base at half of its greatest heave, where all strokes are 0, m.
    pub neutral_height: f64,
    /// Strokes within the cylinders' reach, \[retracted, extended\], m.
    pub reach: [f64; 2],
}

/// A hexapod's gimbals. Legs count round from the base pair that points forward.
#[derive(Clone, Debug, PartialEq)]
pub struct Hexapod {
    pub(super) base: [Vector3<f64>; LEGS],
    pub(super) top: [Vector3<f64>; LEGS],
    neutral_height: f64,
    neutral_length: f64,
    pub(super) top_radius: f64,
    pub(super) reach: [f64; 2],
}

impl Hexapod {
    /// The hexapod with these dimensions, which are not checked.
    pub fn new(geometry: &Geometry) -> Self {
        let third = TAU / 3.0;
        // Even legs stand on the right of their base pair and lean to the deck's pair there.
        let side = |leg: usize| if leg.is_multiple_of(2) { -1.0 } else { 1.0 };
        let on_circle = |radius: f64, angle: f64| {
            let (sine, cosine) = libm::sincos(angle);
            Vector3::new(radius * cosine, radius * sine, 0.0)
        };
        let base = core::array::from_fn(|leg| {
            let angle = (leg / 2) as f64 * third + side(leg) * geometry.base_half_angle;
            on_circle(geometry.base_radius, angle)
        });
        let top = core::array::from_fn(|leg| {
            let pair = (leg / 2) as f64 * third + side(leg) * third / 2.0;
            on_circle(geometry.top_radius, pair - side(leg) * geometry.top_half_angle)
        });
        let neutral_height = geometry.neutral_height;
        let up = Vector3::new(0.0, 0.0, neutral_height);
        Self {
            neutral_length: (top[0] + up - base[0]).norm(),
            base,
            top,
            neutral_height,
            top_radius: geometry.top_radius,
            reach: geometry.reach,
        }
    }

    /// The deck's pose over the base in the neutral state.
    pub fn neutral(&self) -> Pose {
        Pose::new([0.0, 0.0, self.neutral_height], [0.0; 3])
    }

    /// ℓ₀ of, m.
    pub fn neutral_length(&self) -> f64 {
        self.neutral_length
    }

    /// The gimbals of the base in its own frame, m.
    pub fn base(&self) -> &[Vector3<f64>; LEGS] {
        &self.base
    }

    /// The gimbals of the deck in its own frame, m.
    pub fn top(&self) -> &[Vector3<f64>; LEGS] {
        &self.top
    }

    /// Whether all strokes are within the reach.
    ///
    /// # Errors
    /// The first cylinder whose stroke is outside.
    pub fn check(&self, strokes: &[f64; LEGS]) -> Result<(), KinematicsError> {
        let [low, high] = self.reach;
        match strokes.iter().position(|stroke| !(low..=high).contains(stroke)) {
            None => Ok(()),
            Some(leg) if !strokes[leg].is_finite() => Err(KinematicsError::NotFinite),
            Some(leg) => Err(KinematicsError::Unreachable {
                cylinder: leg + 1,
                stroke: strokes[leg],
                reach: self.reach,
            }),
        }
    }
}
