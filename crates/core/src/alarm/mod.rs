//! Turns verdicts into warnings, and warnings into the gateway's own frames.

pub mod approach;
pub mod detector;
pub mod e2e;
pub mod frames;
pub mod level;
pub mod own;
pub mod register;
pub mod services;
pub mod status;
pub mod warning;

pub use approach::{Approach, Deadlines, Urgency};
pub use detector::Detector;
pub use frames::Encoder;
pub use level::{Level, Levels};
pub use own::{OwnContent, OwnFrame, OwnMessage, Service};
pub use register::Register;
pub use services::ServiceEncoder;
pub use warning::{Evidence, Finding, State, Warning};
