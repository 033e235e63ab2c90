//! Tertius.
pub mod alarm;
pub mod bus;
pub mod config;
pub mod decode;
pub mod frame;
pub mod observe;
pub mod time;
