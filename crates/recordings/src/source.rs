//! Sources of frames.

use std::io;

use tertius_core::frame::Frame;
use tertius_core::time::Timestamp;

/// A source of frames: a recording, a bus, a simulator.
pub trait Source {
    /// Returns the next frame, valid until the next call; `Ok(None)` is the end.
    ///
    /// # Errors
    /// Whatever prevents the source from continuing. A damaged recording and a line that
    /// is not a frame do not: they are counted and the source continues.
    fn next_frame(&mut self) -> Result<Option<&Frame>, SourceError>;
}

/// Why a source cannot give frames.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SourceError {
    #[error("cannot open the recording {file}: {error}")]
    Open {
        /// Path as given.
        file: String,
        #[source]
        error: io::Error,
    },
    #[error("the recording {file} is a directory; name the files in it one by one")]
    Directory {
        /// Path as given.
        file: String,
    },
    #[error(
        "the recordings are not in the order of time: {later} begins at {before}, before {ahead}, \
         which is named ahead of it and begins at {at}; {advice}. Where the clock was set back in \
         between, read them one by one, or as one: cat FILES | tertius … -"
    )]
    Order {
        /// Recording that is named first of two.
        ahead: String,
        /// Beginning of that recording.
        at: Timestamp,
        /// Recording that is named second.
        later: String,
        /// Beginning of the second recording.
        before: Timestamp,
        /// Advice on what to do.
        advice: String,
    },
    #[error(
        "{place}: the recording has several interfaces, {found} up to here, and it is not clear \
         from the configuration ({configured}) which is meant; choose one with --interface"
    )]
    Interfaces {
        /// File and line up to which was read.
        place: String,
        /// Interfaces with their numbers of frames.
        found: String,
        /// Interface of the configuration.
        configured: String,
    },
}
