//! Recordings of frames: files, `.gz`, `.zst` and standard input, in any of the formats of [`format_names`].
//!
//! A [`Source`] gives frames one after the other; [`Recording`] reads them from recordings. [`LogWriter`] writes the
//! format of `candump -l`, and a [`FrameEncoder`] any of those that are [`written`]. Without the feature `zstd` no
//! `.zst` is read.

mod ahead;
mod bad_line;
mod barren;
mod buffer;
mod encoder;
mod format;
mod formats;
mod input;
mod limits;
mod options;
mod order;
mod progress;
mod reason;
mod recording;
mod selection;
mod sorter;
mod source;
mod statistics;

pub use ahead::{FrameTaker, read_ahead};
pub use bad_line::{BadLine, BadPlace};
pub use barren::{Barren, Seems};
pub use encoder::{FrameEncoder, Unsayable, Written};
pub use format::TimeStamps;
pub use formats::candump::writer::{LogWriter, append_log_line};
pub use formats::{names as format_names, written};
pub use limits::MAX_LINE;
pub use options::Options;
pub use order::{later as later_beginnings, sorted as in_order};
pub use progress::Progress;
pub use reason::{Found, Reason};
pub use recording::Recording;
pub use selection::{Ambiguous, Interfaces, Selected, Selection, SeveralInterfaces};
pub use sorter::Sorter;
pub use source::{Source, SourceError};
pub use statistics::{
    Damage, INTERFACES_KEPT, Interface, KEPT_BAD_LINES, KEPT_BARREN, KEPT_DAMAGE, Statistics,
};
