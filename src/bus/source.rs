//! What gives frames.

use std::io;

use crate::frame::Frame;

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
}
