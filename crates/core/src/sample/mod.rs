//! From decoded values to the sample of a cycle: groups readings by cycle and judges their quality.

pub mod arrival;
mod awaited;
pub mod counter;
pub mod cycle;
pub mod device;
pub mod dispute;
pub mod emergency;
pub mod fate;
pub mod motion;
pub mod parameters;
pub mod phase;
pub mod plausibility;
pub mod quality;
pub mod reading;
pub mod sync_watch;
mod when;

pub use awaited::Awaited;
pub use device::{DeviceReason, DeviceReport, DeviceRole};
pub use quality::Quality;
pub use reading::{Field, Inputs, Pressure, Reading, Transducer};
