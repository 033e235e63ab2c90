//! Why an interface cannot be opened.

use std::io;

/// Why a CAN interface cannot be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpenError {
    #[error("there is no interface {interface}; `ip -br link` lists them")]
    NoInterface {
        /// Name as given by the caller.
        interface: String,
    },
    #[error(
        "the interface {interface} is not a CAN interface; `ip -details link` shows each's kind"
    )]
    NotCan {
        /// Name as given by the caller.
        interface: String,
    },
    #[error("the interface {interface} is down; `ip link set up {interface}` starts it")]
    Down {
        /// Name as given by the caller.
        interface: String,
    },
    #[error("this kernel has no CAN sockets: {error}; try `modprobe can-raw`")]
    NoCan {
        #[source]
        error: io::Error,
    },
    #[error("{count} identifiers to receive; the kernel filters at most {most}")]
    TooManyIdentifiers {
        /// Number of different identifiers requested.
        count: usize,
        /// The kernel's limit.
        most: usize,
    },
    #[error("cannot {step} on {interface}: {error}")]
    Step {
        /// Name as given by the caller.
        interface: String,
        /// Step that failed, such as `set the filters`.
        step: &'static str,
        #[source]
        error: io::Error,
    },
}

impl OpenError {
    /// Whether the error may pass by itself, so that a retry makes sense: the interface is down, or
    /// not there.
    pub fn may_pass(&self) -> bool {
        matches!(self, Self::NoInterface { .. } | Self::Down { .. })
    }
}
