//! The hexapod: six cylinders between base frame and transfer deck (Appendix A).
//!
//! [`Hexapod::inverse`] gives lengths and velocities from poses to,
//! [`Hexapod::forward`] the pose from lengths by Newton–Raphson to. [`Tilt`] compares the deck's
//! attitude by the lengths with that by a sensor on it, and so tells whose reading has moved.
//!
//! Frames: x forward, y to port, z up, origins in the middle of the gimbals' circles. A vessel is
//! turned first about z (yaw), then about its new y (pitch), then about its new x (roll). The
//! matrices of as printed turn the frame and not the body; here [`Pose::rotation`] takes the
//! body's coordinates to those of the outer frame, which needs.

mod forward;
mod geometry;
mod inverse;
mod parameters;
mod pose;
mod tilt;

pub use forward::{MAX_ITERATIONS, PoseSolution};
pub use geometry::{Geometry, Hexapod};
pub use inverse::{FrameMotion, Legs};
pub use parameters::TiltParameters;
pub use pose::{Pose, PoseRate};
pub use tilt::{Inclination, Tilt, TiltChange, TiltDesign, TiltError, TiltJudgement, TiltLeg};

/// Legs of a hexapod.
pub const LEGS: usize = 6;

/// Why there are no lengths, or no pose.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum KinematicsError {
    /// A cylinder would have to be shorter or longer than it can be.
    #[error(
        "cylinder {cylinder} would have a stroke of {stroke:.4} m; it reaches from {} to {} m",
        .reach[0], .reach[1]
    )]
    Unreachable {
        /// Cylinder number, counted from 1.
        cylinder: usize,
        stroke: f64,
        reach: [f64; 2],
    },
    /// At this pose the lengths do not determine the motion: the deck can move although all
    /// cylinders stand still, or the cylinders cannot hold it.
    #[error("the pose is singular: the cylinders' lengths do not determine it")]
    Singular,
    /// Newton–Raphson found no pose with these lengths.
    #[error("no pose has these lengths; {MAX_ITERATIONS} iterations left {worst:.3e} m")]
    NoPose { worst: f64 },
    #[error("a length or pose is not a finite number")]
    NotFinite,
}
