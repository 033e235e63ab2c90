//! Live interfaces: the only module that knows sockets of CAN.
//!
//! A [`Port`] is a live CAN interface: [`socket`] uses SocketCAN, [`embedded`] is a bus inside the
//! program. It sends only the gateway's own frames; a [`ListeningPort`] sends none, and an [`UnrestrictedPort`] is for
//! stand-ins of the machine.

#![forbid(unsafe_code)]

pub mod embedded;
mod listening;
mod port;
pub mod socket;
mod unrestricted;

pub use listening::ListeningPort;
pub use port::{Identifiers, Port, PortCounts, PortError, Received, Sent, Stamps};
pub use unrestricted::{Unrestricted, UnrestrictedPort};
