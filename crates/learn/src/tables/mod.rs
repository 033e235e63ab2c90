//! What was learnt, as tables that the configuration reads, each with where, when and from what it was made.

pub mod calibration;
pub mod model;
pub mod provenance;
pub mod tuning;
