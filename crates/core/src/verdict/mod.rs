//! From residuals to verdicts: healthy, faulty or unknown, and the kind of fault.

pub mod bank;
pub mod fault;
pub mod history;
pub mod jump;
pub mod parameters;
mod persistence;
pub mod suspect;
pub mod trigger;
mod unaligned;

use crate::state::choice;
pub use bank::{Bank, BankDesign, FDE3, FDES, Raised, Residuals};
pub use fault::Fault;
pub use jump::Jump;
pub use parameters::{LONGEST_WAIT, VerdictParameters};
pub use suspect::{Suspect, Testimony};
pub use trigger::{FdeState, Raise, Thresholds, Trigger};

/// Verdict of a detector on its residual. Unknown is a verdict of its own: without evidence nothing
/// is healthy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Verdict {
    #[default]
    Unknown,
    Healthy,
    Faulty,
}

choice! { Verdict { Unknown, Healthy, Faulty } }
