//! The model of a cylinder and its observers.

pub mod model;
pub mod observer;
pub mod riccati;
pub mod steepness;
