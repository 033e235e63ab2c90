//! Where frames come from and go to: the only room that knows files of frames (and, later,
//! sockets).
//!
//! A [`Source`] gives frames one after the other; [`Recording`] is the one over candump
//! recordings: files, `.gz`, `.zst`, standard input. [`LogWriter`] writes what `candump -l` would.

#![forbid(unsafe_code)]

mod buffer;
mod candump;
mod input;
mod port;
mod recording;
mod source;
mod statistics;
mod writer;

pub use candump::{Found, MAX_LINE, Reason, TimeStamps};
pub use port::{Port, PortCounts, PortError, Received, Sent, Stamps, UnrestrictedPort};
pub use recording::{Options, Progress, Recording};
pub use source::{Source, SourceError};
pub use statistics::{
    BadLine, Damage, INTERFACES_KEPT, Interface, KEPT_BAD_LINES, KEPT_DAMAGE, Statistics,
};
pub use writer::{LogWriter, append_log_line};
