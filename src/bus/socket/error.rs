//! Why an interface cannot be opened.

use std::io;

/// Why a CAN interface cannot be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpenError {
    #[error("there is no interface {interface}; `ip -br link` lists those that there are")]
    NoInterface {
        /// As the caller named it.
        interface: String,
    },
    #[error(
        "the interface {interface} is not a CAN interface; `ip -details link` shows each's kind"
    )]
    NotCan {
        /// As the caller named it.
        interface: String,
    },
    #[error("the interface {interface} is down; `ip link set up {interface}` starts it")]
    Down {
        /// As the caller named it.
        interface: String,
    },
    #[error("this kernel has no CAN sockets: {error}; `modprobe can-raw` loads them where it can")]
    NoCan {
        #[source]
        error: io::Error,
    },
    #[error("{count} identifiers to receive; the kernel filters at most {most}")]
    TooManyIdentifiers {
        /// Identifiers asked for, each counted once.
        count: usize,
        /// The kernel's limit.
        most: usize,
    },
    #[error("cannot {step} on {interface}: {error}")]
    Step {
        /// As the caller named it.
        interface: String,
        /// What was being done, such as `set the filters`.
        step: &'static str,
        #[source]
        error: io::Error,
    },
}

impl OpenError {
    /// Whether it may pass by itself, so that trying again makes sense: an interface that is down,
    /// or not there.
    pub fn may_pass(&self) -> bool {
        matches!(self, Self::NoInterface { .. } | Self::Down { .. })
    }
}
