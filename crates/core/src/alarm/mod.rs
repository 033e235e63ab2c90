//! Turns verdicts into warnings, and warnings into the gateway's own frames.

pub mod e2e;
pub mod frames;
pub mod level;
pub mod register;
pub mod status;
pub mod warning;

pub use frames::{Encoder, OwnFrame, Service, ServiceEncoder};
pub use level::{Level, Levels};
pub use register::Register;
pub use warning::{Detector, Evidence, Finding, State, Warning};
