//! What gives frames.

use std::io;

use crate::frame::Frame;
use crate::time::Timestamp;

/// Gives frames one after the other: a recording, a bus, a simulator.
pub trait Source {
    /// The next frame, valid until the next call; `Ok(None)` is the end.
    ///
    /// # Errors
    /// What keeps the source from going on. A damaged recording or a line that is no frame is not
    /// among them: those are counted and the source goes on.
    fn next_frame(&mut self) -> Result<Option<&Frame>, SourceError>;
}

/// Why a source cannot give frames.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SourceError {
    #[error("cannot open the recording {file}: {error}")]
    Open {
        /// The path as it was given.
        file: String,
        #[source]
        error: io::Error,
    },
    #[error("the recording {file} is a directory; name the files in it one by one")]
    Directory {
        /// The path as it was given.
        file: String,
    },
    #[error(
        "the recordings are not in the order of time: {later} begins at {before}, before {ahead}, \
         which is named ahead of it and begins at {at}; {advice}. Where the clock was set back in \
         between, read them one by one, or as one: cat FILES | tertius … -"
    )]
    Order {
        /// Named first of two.
        ahead: String,
        /// When it begins.
        at: Timestamp,
        /// Named behind it.
        later: String,
        /// When that begins.
        before: Timestamp,
        /// What to do.
        advice: String,
    },
    #[error(
        "{place}: the recording has several interfaces, {found} up to here, and the configuration \
         ({configured}) does not say which is meant; choose one with --interface"
    )]
    Interfaces {
        /// The file and the line up to which was read.
        place: String,
        /// The interfaces with their frames.
        found: String,
        /// The configuration's.
        configured: String,
    },
}
