//! Text of the configuration file, and the position of each key.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use super::problem::{ConfigError, Place, Problem, Problems};

/// A configuration file as it was read, so that whoever later finds a value to be wrong (a signal
/// that the DBC does not have) can say on which line.
#[derive(Clone, Debug)]
pub struct Document {
    name: Arc<str>,
    text: Arc<str>,
    /// Start of each line, bytes.
    lines: Arc<[usize]>,
    places: BTreeMap<String, Range<usize>>,
}

impl Document {
    pub(super) fn new(name: &str, text: &str) -> Self {
        let starts = text.match_indices('\n').map(|(at, _)| at + 1);
        Self {
            name: name.into(),
            text: text.into(),
            lines: std::iter::once(0).chain(starts).collect(),
            places: BTreeMap::new(),
        }
    }

    /// The file's name as the user gave it.
    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn text(&self) -> &str {
        &self.text
    }

    /// Whether the file itself has this key, for example `fde.low` or `cylinder[0].theta`;
    /// otherwise the value in the settings is a default.
    pub fn has(&self, key: &str) -> bool {
        self.places.contains_key(key)
    }

    /// A problem with a key of the file, for example `signals.cylinder.c1` or `cylinder[0].theta`.
    ///
    /// A key that is not in the file is reported at the table it would be in, or at the start.
    pub fn problem(
        &self,
        key: &str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Problem {
        let mut known = key;
        let span = loop {
            if let Some(span) = self.places.get(known) {
                break span.clone();
            }
            match known.rfind(['.', '[']) {
                Some(at) => known = &known[..at],
                None => break 0..0,
            }
        };
        self.problem_at(span, key, message.into(), help.into())
    }

    /// A refusal of this file for problems found with [`Document::problem`]; `None` without any.
    pub fn refuse(&self, problems: impl IntoIterator<Item = Problem>) -> Option<ConfigError> {
        let mut found = Problems::default();
        problems.into_iter().for_each(|problem| found.push_with(|| problem));
        if found.is_empty() { None } else { Some(self.error(found)) }
    }

    pub(super) fn error(&self, problems: Problems) -> ConfigError {
        problems.into_error(self.text.clone(), self.name.clone())
    }

    pub(super) fn record(&mut self, key: &str, span: Range<usize>) {
        self.places.insert(key.into(), span);
    }

    pub(super) fn problem_at(
        &self,
        span: Range<usize>,
        key: &str,
        message: String,
        help: String,
    ) -> Problem {
        let place = Some(self.place(span));
        Problem { file: self.name.clone(), key: key.into(), place, message, help }
    }

    /// The text at a span; empty if it is none of this text.
    pub(super) fn written(&self, span: Range<usize>) -> &str {
        self.text.get(span).unwrap_or("")
    }

    fn place(&self, span: Range<usize>) -> Place {
        let start = floor(&self.text, span.start);
        let end = floor(&self.text, span.end).max(start);
        // The first line starts at 0, so at least one line starts at or before any place.
        let line = self.lines.partition_point(|&line| line <= start);
        let column = self.text[self.lines[line - 1]..start].chars().count() + 1;
        Place { line, column, span: start..end }
    }
}

/// The nearest place at or before `at` where a character begins.
fn floor(text: &str, at: usize) -> usize {
    text.floor_char_boundary(at)
}
