//! Problems with a configuration, for a person to correct.

use std::collections::BTreeSet;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

#[cfg(feature = "report")]
mod report;

/// A report names at most this many problems and counts the rest.
pub const MAX_PROBLEMS: usize = 20;

/// Position of a problem in the text. Line and column count from 1, the column in characters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    pub line: usize,
    pub column: usize,
    /// Position in bytes.
    pub span: Range<usize>,
}

/// One problem, where it is, and what to do about it.
///
/// Its `Display` is one line, `file:line:column: message (help)`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    pub(super) file: Arc<str>,
    /// Full name of the key; empty where no key is at fault.
    pub(super) key: String,
    pub(super) place: Option<Place>,
    pub(super) message: String,
    pub(super) help: String,
}

impl Problem {
    /// A problem of the whole file, which may not even have been readable.
    pub(super) fn of_file(file: &str, message: String, help: &str) -> Self {
        Self { file: file.into(), key: String::new(), place: None, message, help: help.into() }
    }

    /// Name of the file that it is in.
    pub fn file(&self) -> &str {
        &self.file
    }

    pub fn message(&self) -> &str {
        &self.message
    }

    pub fn help(&self) -> &str {
        &self.help
    }

    /// Position of the problem; `None` where the file as a whole is at fault.
    pub fn place(&self) -> Option<&Place> {
        self.place.as_ref()
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.file)?;
        if let Some(place) = &self.place {
            write!(f, "{}:{}:", place.line, place.column)?;
        }
        write!(f, " {}", self.message)?;
        if self.help.is_empty() { Ok(()) } else { write!(f, " ({})", self.help) }
    }
}

/// Problems as they are found: the first [`MAX_PROBLEMS`] and the number of the others.
#[derive(Default)]
pub(super) struct Problems {
    list: Vec<Problem>,
    more: usize,
}

impl Problems {
    /// Adds a problem, which is not constructed once there are enough.
    pub fn push_with(&mut self, make: impl FnOnce() -> Problem) {
        if self.list.len() < MAX_PROBLEMS {
            self.list.push(make());
        } else {
            self.more += 1;
        }
    }

    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The tables that have a problem.
    pub fn tables(&self) -> BTreeSet<String> {
        self.list.iter().map(|problem| table_of(&problem.key).to_owned()).collect()
    }

    pub fn into_error(mut self, text: Arc<str>, file: Arc<str>) -> ConfigError {
        self.list.sort_by_key(|problem| problem.place.as_ref().map(|place| place.span.start));
        ConfigError { file, text, problems: self.list, more: self.more }
    }
}

/// The full name of the table that holds a key; empty for the top level.
pub(super) fn table_of(key: &str) -> &str {
    key.rsplit_once('.').map_or("", |(table, _)| table)
}

/// Refusal of a configuration, with everything that was found wrong.
///
/// Its `Display` is one line for each problem, as compilers write them, in the order of the file;
/// `report`, of the feature of that name, shows the same with the lines of the file.
#[derive(Clone, Debug)]
pub struct ConfigError {
    file: Arc<str>,
    #[cfg_attr(not(feature = "report"), expect(dead_code, reason = "what a report shows"))]
    text: Arc<str>,
    problems: Vec<Problem>,
    more: usize,
}

impl ConfigError {
    /// A refusal for a problem outside the text.
    pub(super) fn of_file(file: &str, message: String, help: &str) -> Self {
        let mut problems = Problems::default();
        problems.push_with(|| Problem::of_file(file, message, help));
        problems.into_error("".into(), file.into())
    }

    /// What was found, at most [`MAX_PROBLEMS`], in the order of the file; never empty.
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }

    /// Number of problems found beyond [`ConfigError::problems`].
    pub fn more(&self) -> usize {
        self.more
    }
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, problem) in self.problems.iter().enumerate() {
            let separator = if index == 0 { "" } else { "\n" };
            write!(f, "{separator}{problem}")?;
        }
        if self.more > 0 {
            write!(f, "\n{}: and {} more problems", self.file, self.more)?;
        }
        Ok(())
    }
}

impl std::error::Error for ConfigError {}
