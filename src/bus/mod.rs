//! Sources and destinations of frames: the only module that knows files of frames and sockets.
//!
//! A [`Source`] gives frames one after the other; [`Recording`] reads them from recordings: files, `.gz`,
//! `.zst`, standard input, in any of the formats of [`format_names`]. [`LogWriter`] writes the format of `candump -l`, and
//! a [`FrameEncoder`] any of those that are [`written`].
//!
//! A [`Port`] is a live CAN interface: [`socket`] uses SocketCAN, [`embedded`] is a bus inside the
//! program. It sends only the gateway's own frames; a [`ListeningPort`] sends none, and an [`UnrestrictedPort`] is for
//! stand-ins of the machine.

#![forbid(unsafe_code)]

mod ahead;
mod bad_line;
mod barren;
mod buffer;
pub mod embedded;
mod encoder;
mod format;
mod formats;
mod input;
mod limits;
mod listening;
mod merge;
mod options;
mod order;
mod port;
mod progress;
mod reason;
mod recording;
mod selection;
pub mod socket;
mod source;
mod statistics;
mod unrestricted;

pub use ahead::{FrameTaker, read_ahead};
pub use bad_line::{BadLine, BadPlace};
pub use barren::{Barren, Seems};
pub use encoder::{FrameEncoder, Unsayable, Written};
pub use format::TimeStamps;
pub use formats::candump::writer::{LogWriter, append_log_line};
pub use formats::{names as format_names, written};
pub use limits::MAX_LINE;
pub use listening::ListeningPort;
pub(crate) use merge::Sorter;
pub use options::Options;
pub use order::{later as later_beginnings, sorted as in_order};
pub use port::{Identifiers, Port, PortCounts, PortError, Received, Sent, Stamps};
pub use progress::Progress;
pub use reason::{Found, Reason};
pub use recording::Recording;
pub use selection::{Ambiguous, Interfaces, Selected, Selection, SeveralInterfaces};
pub use source::{Source, SourceError};
pub use statistics::{
    Damage, INTERFACES_KEPT, Interface, KEPT_BAD_LINES, KEPT_BARREN, KEPT_DAMAGE, Statistics,
};
pub use unrestricted::{Unrestricted, UnrestrictedPort};
