//! Reference lengths and velocities: the reference generator of Figure 2-3.

use super::limit::soft;
use crate::hexapod::{FrameMotion, Hexapod, LEGS, Legs, Pose, PoseRate};

/// Reference motion of the cylinders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference {
    /// Reference lengths, m.
    pub lengths: [f64; LEGS],
    /// Reference velocities, m/s.
    pub speeds: [f64; LEGS],
}

impl Reference {
    /// All cylinders at rest at `length`, m.
    pub fn still(length: f64) -> Self {
        Self { lengths: [length; LEGS], speeds: [0.0; LEGS] }
    }

    /// The reference with which the deck stands still above a vessel in this motion; kept within
    /// ±`limit`, m.
    pub fn engaged(hexapod: &Hexapod, pose: &Pose, rate: &PoseRate, limit: f64) -> Self {
        let deck = hexapod.neutral();
        let legs = Legs::new(hexapod, pose, &deck);
        let mut lengths = legs.strokes(hexapod);
        let still = PoseRate::default();
        let mut speeds =
            legs.velocities(FrameMotion { pose, rate }, FrameMotion { pose: &deck, rate: &still });
        for (length, speed) in lengths.iter_mut().zip(&mut speeds) {
            (*length, *speed) = soft(*length, *speed, limit);
        }
        Self { lengths, speeds }
    }

    /// The reference at `progress` (0 to 1) of the way from one to another; `progress` changes by
    /// `rate`, 1/s.
    pub fn between(from: &Self, to: &Self, progress: f64, rate: f64) -> Self {
        let mix = |from: f64, to: f64| from + progress * (to - from);
        Self {
            lengths: std::array::from_fn(|leg| mix(from.lengths[leg], to.lengths[leg])),
            speeds: std::array::from_fn(|leg| {
                mix(from.speeds[leg], to.speeds[leg]) + rate * (to.lengths[leg] - from.lengths[leg])
            }),
        }
    }
}
