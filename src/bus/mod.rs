//! Sources and destinations of frames: recordings, and live interfaces.
//!
//! A [`Source`] gives frames one after the other; [`Recording`] reads them from files of any format, and [`written`] has
//! those that are written, too.
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
pub use tertius_recordings::*;
pub use unrestricted::{Unrestricted, UnrestrictedPort};
