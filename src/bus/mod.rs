//! Where frames come from and go to: the only room that knows files of frames and sockets.
//!
//! A [`Source`] gives frames one after the other; [`Recording`] is the one over candump
//! recordings: files, `.gz`, `.zst`, standard input. [`LogWriter`] writes what `candump -l` would.
//!
//! A [`Port`] is a CAN interface, live: [`socket`] the one over SocketCAN, [`embedded`] a bus inside
//! the program. It sends the gateway's own frames and no other; an [`UnrestrictedPort`] is for those
//! who stand in for the machine.

#![forbid(unsafe_code)]

mod barren;
mod buffer;
mod candump;
pub mod embedded;
mod input;
mod order;
mod port;
mod recording;
mod selection;
pub mod socket;
mod source;
mod statistics;
mod unrestricted;
mod writer;

pub use barren::{Barren, Seems};
pub use candump::{Found, MAX_LINE, Reason, TimeStamps};
pub use order::sorted as in_order;
pub use port::{Identifiers, Port, PortCounts, PortError, Received, Sent, Stamps};
pub use recording::{Options, Progress, Recording};
pub use selection::{Ambiguous, Interfaces, Selected, Selection};
pub use source::{Source, SourceError};
pub use statistics::{
    BadLine, Damage, INTERFACES_KEPT, Interface, KEPT_BAD_LINES, KEPT_BARREN, KEPT_DAMAGE,
    Statistics,
};
pub use unrestricted::{Unrestricted, UnrestrictedPort};
pub use writer::{LogWriter, append_log_line};
