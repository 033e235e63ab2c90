//! Why a state cannot be resumed.

use thiserror::Error;

/// Why bytes are not the state of a monitor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum StateError {
    #[error("it ends too early")]
    Short,
    #[error("it goes on after its end")]
    Long,
    #[error("it has a {what} that no monitor can have")]
    Unsound { what: &'static str },
    #[error("it is of a monitor with another number of {what}")]
    Parts { what: &'static str },
}
