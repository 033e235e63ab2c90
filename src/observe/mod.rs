//! The model and its observer.
pub mod model;
pub mod riccati;
