//! The model of a cylinder and its observers.

pub mod commands;
pub mod model;
pub mod observer;
mod parameters;
pub mod riccati;

pub use parameters::ObserverParameters;
