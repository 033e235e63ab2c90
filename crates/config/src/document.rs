//! Text of the configuration file, and the position of each key.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use super::overrides::{Override, Overrides};
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
    overrides: Overrides,
    /// The text with the overrides in it.
    effective: Arc<str>,
}

impl Document {
    pub(super) fn new(name: &str, text: &str) -> Self {
        let starts = text.match_indices('\n').map(|(at, _)| at + 1);
        Self {
            name: name.into(),
            text: text.into(),
            lines: std::iter::once(0).chain(starts).collect(),
            places: BTreeMap::new(),
            overrides: Overrides::default(),
            effective: text.into(),
        }
    }

    /// This document with overrides in force, by which its text becomes `effective`.
    pub(super) fn with(self, overrides: Overrides, effective: &str) -> Self {
        Self { overrides, effective: effective.into(), ..self }
    }

    /// The file's name as the user gave it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The text of the file, without overrides.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The text of the configuration that is in force: that of the file with the overrides in it.
    pub fn effective(&self) -> &str {
        &self.effective
    }

    /// The overrides in force.
    pub fn overrides(&self) -> &Overrides {
        &self.overrides
    }

    /// Whether an override replaces the value of this key.
    pub(super) fn is_overridden(&self, key: &str) -> bool {
        self.overrides.of(key).is_some()
    }

    /// Whether the file or an override has this key, for example `fde.low` or `cylinder[0].theta`;
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
        if let Some(one) = self.overrides.of(key) {
            return Problem { key: key.into(), ..self.problem_with(one, message, help) };
        }
        let place = Some(self.place(span));
        Problem { file: self.name.clone(), key: key.into(), place, message, help }
    }

    /// A problem with an override, which has no place in the file.
    pub(super) fn problem_with(&self, one: &Override, message: String, help: String) -> Problem {
        Problem::of_file(&one.to_string(), message, &help)
    }

    /// The value of `key` as it is written at a span; empty if there is none.
    pub(super) fn written(&self, key: &str, span: Range<usize>) -> &str {
        match self.overrides.of(key) {
            Some(one) if span.is_empty() => one.value(),
            Some(one) => one.value().get(span).unwrap_or(one.value()),
            None => self.text.get(span).unwrap_or(""),
        }
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
