//! How frames become the bytes of a recording.

use tertius_core::frame::Frame;

/// Turns frames into the bytes of one recording, in the order in which they are given. It holds a bounded number of
/// bytes back, however long the recording is.
pub trait FrameEncoder: Send {
    /// Appends a frame of the interface to `bytes`; `interface` is of printable ASCII, without blanks.
    ///
    /// # Errors
    /// Why the format cannot have this frame. It is left out then, and others may follow.
    fn add(&mut self, interface: &str, frame: &Frame, bytes: &mut Vec<u8>)
    -> Result<(), Unsayable>;

    /// Appends what stands at the end. Returns the first bytes of the recording as they should be, where they tell
    /// what is known at the end only; a reader does without them if they cannot be replaced.
    fn finish(&mut self, bytes: &mut Vec<u8>) -> Option<Vec<u8>> {
        _ = bytes;
        None
    }

    /// The numbers of the interfaces, in a format that has no names for them.
    fn channels(&self) -> &[(String, u16)] {
        &[]
    }
}

/// Why a frame cannot be in a recording of a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, thiserror::Error)]
pub enum Unsayable {
    #[error("earlier than the recording's start, from which the format counts")]
    BeforeStart,
    #[error("earlier than 1970, from which the format counts")]
    Before1970,
    #[error("of further interfaces, of which the format can tell 255 apart")]
    Channel,
}

/// A format in which recordings are written.
pub struct Written {
    /// Word for it on the command line, and the ending of a file's name that asks for it.
    pub word: &'static str,
    /// An encoder for one recording.
    pub encoder: fn() -> Box<dyn FrameEncoder>,
    /// Whether error frames keep what they say of the error.
    pub explains_errors: bool,
    /// Whether it is compressed by itself, and its beginning is replaced at its end.
    pub is_packed: bool,
}
