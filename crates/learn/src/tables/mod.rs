//! What was learnt, as tables that the configuration reads, each with the place, time and data it
//! was made from.

pub mod calibration;
pub mod cylinders;
mod digits;
pub mod model;
pub mod nonlinear;
mod process;
pub mod provenance;
pub mod tuning;
