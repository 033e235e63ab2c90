//! A line or record that is not a frame.

use super::reason::Reason;

/// A line, or a record of a format without lines, that is not a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BadLine {
    /// Name of the file as given, or "standard input".
    pub file: String,
    pub place: BadPlace,
    /// Beginning of the line: at most 80 bytes, `…` if there were more, control characters escaped. Of a
    /// record its first 16 bytes, in hexadecimal.
    pub text: String,
    /// What was found and what was expected.
    pub reason: Reason,
}

impl std::fmt::Display for BadLine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { file, place, text, reason } = self;
        match place {
            BadPlace::Line(line) => write!(f, "{file}:{line}: {reason}: {text}"),
            BadPlace::Byte(byte) if text.is_empty() => write!(f, "{file}, byte {byte}: {reason}"),
            BadPlace::Byte(byte) => write!(f, "{file}, byte {byte}: {reason}: {text}"),
        }
    }
}

/// A place within a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BadPlace {
    /// Line number, counted from 1.
    Line(u64),
    /// Number of bytes before it, after decompression.
    Byte(u64),
}
