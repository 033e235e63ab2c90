//! Why a text is not a usable EDS.

use super::{MAX_LINE, MAX_TEXT};

/// The whole text is refused. Lines count from 1.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ParseError {
    #[error("the EDS has {bytes} bytes; at most {MAX_TEXT} are read")]
    TooLong { bytes: usize },
    #[error("line {line}: a zero byte; this is not an EDS as text (UTF-16? save it as UTF-8)")]
    NotText { line: usize },
    #[error("line {line}: a line of {bytes} bytes; at most {MAX_LINE} are read")]
    LongLine { line: usize, bytes: usize },
    #[error("line {line}: more than {limit} {what}; a device has fewer")]
    TooMany { line: usize, what: &'static str, limit: usize },
    #[error("line 1: XML; this is an XDD (CiA 311) and not an EDS: ask the maker for the EDS")]
    Xml,
    #[error("there is no object (a section such as [1000]) in it; is it an EDS or a DCF?")]
    NoObjects,
}

impl ParseError {
    /// Line of the error, where there is one.
    pub fn line(&self) -> Option<usize> {
        match self {
            Self::TooLong { .. } | Self::NoObjects => None,
            Self::Xml => Some(1),
            Self::NotText { line } | Self::LongLine { line, .. } | Self::TooMany { line, .. } => {
                Some(*line)
            }
        }
    }
}

/// The beginning of `text`, short enough for an error message.
pub(super) fn excerpt(text: &str) -> String {
    const LONGEST: usize = 60;
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}
