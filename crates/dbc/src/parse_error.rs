//! Why a text is not a usable DBC.

use super::{MAX_NAME, MAX_TEXT};

/// The whole text is refused. Lines count from 1.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ParseError {
    #[error("the DBC has {bytes} bytes; at most {MAX_TEXT} are read")]
    TooLong { bytes: usize },
    #[error("line {line}: a zero byte; this is not a DBC as text (UTF-16? save it as UTF-8)")]
    NotText { line: usize },
    #[error("line {line}: a string is opened and never closed; add the missing \"")]
    OpenString { line: usize },
    #[error("line {line}: found {found:?} where a statement such as BO_ or VAL_ should begin")]
    Stray { line: usize, found: String },
    #[error("line {line}: SG_ outside of a message; signals follow their BO_ line")]
    OrphanSignal { line: usize },
    #[error("line {line}: cannot read {found:?}: {reason}; it should look like {form}")]
    Syntax { line: usize, found: String, reason: String, form: &'static str },
    #[error("line {line}: a name of {bytes} bytes; at most {MAX_NAME} are accepted")]
    LongName { line: usize, bytes: usize },
    #[error("line {line}: more than {limit} {what}; split the DBC")]
    TooMany { line: usize, what: &'static str, limit: usize },
    #[error("line {line}: message {message} is too entangled to check for overlapping signals")]
    TooComplex { line: usize, message: String },
    #[error("there is no message (BO_ line) in it; is it a DBC?")]
    NoMessages,
}

impl ParseError {
    /// Line of the error, where there is one.
    pub fn line(&self) -> Option<usize> {
        match self {
            Self::TooLong { .. } | Self::NoMessages => None,
            Self::NotText { line }
            | Self::OpenString { line }
            | Self::Stray { line, .. }
            | Self::OrphanSignal { line }
            | Self::Syntax { line, .. }
            | Self::LongName { line, .. }
            | Self::TooMany { line, .. }
            | Self::TooComplex { line, .. } => Some(*line),
        }
    }
}

/// The beginning of `text`, short enough for an error message.
pub(super) fn excerpt(text: &str) -> String {
    const LONGEST: usize = 80;
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}
