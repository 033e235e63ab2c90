//! The hexapod of the monitor's own kinematics ([`tertius_core::hexapod`]), and the tip of a gangway on it.

mod tip;

pub use tertius_core::hexapod::{
    FrameMotion, Geometry, Hexapod, KinematicsError, LEGS, Legs, MAX_ITERATIONS, Pose, PoseRate,
    PoseSolution,
};
pub use tip::Tip;
