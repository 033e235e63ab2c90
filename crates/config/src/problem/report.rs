//! A refusal as a terminal shows it, with the lines of the file.

use super::{ConfigError, Problem};
use crate::visible::{visible, visible_lines};
use std::fmt;
use std::ops::Range;

use miette::{Diagnostic, LabeledSpan, NamedSource};

/// Longest line that is shown beneath a problem, characters; longer lines were not written by a
/// person.
const LONGEST_SHOWN_LINE: usize = 400;

impl ConfigError {
    /// The problems for a terminal, each with its lines of the file.
    pub fn report(&self) -> miette::Report {
        let count = self.problems.len() + self.more;
        let plural = if count == 1 { "" } else { "s" };
        miette::Report::new(Refusal {
            headline: format!("{}: {count} problem{plural}", visible(&self.file)),
            rest: (self.more > 0).then(|| format!("{} more are not shown", self.more)),
            text: NamedSource::new(visible(&self.file), visible_lines(&self.text).into_owned()),
            problems: self.problems.iter().map(|p| Labelled::new(p, self)).collect(),
        })
    }
}

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
        // Escapes are longer than what they stand for.
        let shown = |at: usize| visible_lines(&text[..at]).len();
        let span = problem.place.as_ref().map(|place| place.span.clone()).filter(short);
        let span = span.map(|span| shown(span.start)..shown(span.end));
        // The headline names the file, but what comes from elsewhere has to be said.
        let elsewhere = problem.file != error.file;
        let origin = if elsewhere { format!("{}: ", problem.file) } else { String::new() };
        let message = visible(&(origin + &problem.message)).into_owned();
        Self { message, help: visible(&problem.help).into_owned(), span }
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
