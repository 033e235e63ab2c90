//! From residuals to verdicts: healthy, faulty or unknown, of what kind, and by which transducer.

pub mod bank;
pub mod fault;
pub mod history;
pub mod parameters;
pub mod suspect;
pub mod trigger;

pub use bank::{Bank, BankDesign, Residuals};
pub use fault::Fault;
pub use parameters::Parameters;
pub use suspect::Suspect;
pub use trigger::{Thresholds, Trigger};

/// What a detector says of its residual. Unknown is a verdict of its own: without evidence nothing
/// is healthy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Verdict {
    #[default]
    Unknown,
    Healthy,
    Faulty,
}
