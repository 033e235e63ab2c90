//! Problems with a configuration, for a person to correct.

use std::collections::BTreeSet;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use miette::{Diagnostic, LabeledSpan, NamedSource};

/// A report names at most this many problems and counts the rest.
pub const MAX_PROBLEMS: usize = 20;
/// Longest line that is shown beneath a problem, characters; longer lines were not written by a
/// person.
const LONGEST_SHOWN_LINE: usize = 400;

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
/// [`ConfigError::report`] shows the same with the lines of the file.
#[derive(Clone, Debug)]
pub struct ConfigError {
    file: Arc<str>,
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

    /// The problems for a terminal, each with its lines of the file.
    pub fn report(&self) -> miette::Report {
        let count = self.problems.len() + self.more;
        let plural = if count == 1 { "" } else { "s" };
        miette::Report::new(Refusal {
            headline: format!("{}: {count} problem{plural}", self.file),
            rest: (self.more > 0).then(|| format!("{} more are not shown", self.more)),
            text: NamedSource::new(&self.file, self.text.to_string()),
            problems: self.problems.iter().map(|p| Labelled::new(p, self)).collect(),
        })
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

#[derive(Debug, thiserror::Error)]
#[error("{headline}")]
struct Refusal {
    headline: String,
    rest: Option<String>,
    text: NamedSource<String>,
    problems: Vec<Labelled>,
}

impl Diagnostic for Refusal {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.rest.as_ref().map(|rest| Box::new(rest) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn miette::SourceCode> {
        Some(&self.text)
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        Some(Box::new(self.problems.iter().map(|problem| problem as &dyn Diagnostic)))
    }
}

#[derive(Debug, thiserror::Error)]
#[error("{message}")]
struct Labelled {
    message: String,
    help: String,
    span: Option<Range<usize>>,
}

impl Labelled {
    fn new(problem: &Problem, error: &ConfigError) -> Self {
        let text = &*error.text;
        let short = |span: &Range<usize>| {
            let start = text[..span.start].rfind('\n').map_or(0, |at| at + 1);
            let end = text[span.end..].find('\n').map_or(text.len(), |at| span.end + at);
            end - start <= LONGEST_SHOWN_LINE
        };
        let span = problem.place.as_ref().map(|place| place.span.clone()).filter(short);
        // The headline names the file, but what comes from elsewhere has to be said.
        let elsewhere = problem.file != error.file;
        let origin = if elsewhere { format!("{}: ", problem.file) } else { String::new() };
        Self { message: origin + &problem.message, help: problem.help.clone(), span }
    }
}

impl Diagnostic for Labelled {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        (!self.help.is_empty()).then(|| Box::new(&self.help) as Box<dyn fmt::Display>)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let span = self.span.clone()?;
        Some(Box::new(std::iter::once(LabeledSpan::underline(span))))
    }
}
