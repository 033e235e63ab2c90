//! The model of a cylinder and its observers.

pub mod commands;
pub mod model;
pub mod observer;
pub mod riccati;
