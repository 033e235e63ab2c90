//! How far a recording has been read.

/// Progress in a recording, in bytes of its files as stored: compressed if they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Bytes taken from the files so far; up to some hundred kilobytes ahead of the frames.
    pub consumed: u64,
    /// Size of all files; `None` if one of them is a pipe.
    pub total: Option<u64>,
}

impl Progress {
    /// Progress in files of which there are none.
    pub(super) const NONE: Self = Self { consumed: 0, total: Some(0) };

    /// That in the files of both.
    pub(super) fn and(self, other: Self) -> Self {
        Self {
            consumed: self.consumed + other.consumed,
            total: self.total.zip(other.total).map(|(own, other)| own + other),
        }
    }
}
