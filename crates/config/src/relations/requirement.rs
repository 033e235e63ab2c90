//! What a relation requires, and the problem where it does not hold.

use crate::document::Document;
use crate::problem::{Problems, table_of};
use std::collections::BTreeSet;

pub(super) struct Relations<'a> {
    pub(super) document: &'a Document,
    /// Tables that already had a problem.
    doubtful: BTreeSet<String>,
    problems: &'a mut Problems,
}

impl<'a> Relations<'a> {
    pub(super) fn new(document: &'a Document, problems: &'a mut Problems) -> Self {
        Self { document, doubtful: problems.tables(), problems }
    }

    /// Reports a problem unless `holds`, at the first of `keys` that is overridden, or else that the file has: a
    /// default is not at fault, and a file that was sound before an override is not either.
    pub(super) fn require(&mut self, holds: bool, keys: &[&str], message: String, help: &str) {
        if holds || keys.iter().any(|key| self.doubtful.contains(table_of(key))) {
            return;
        }
        let document = self.document;
        let overridden = keys.iter().find(|key| document.is_overridden(key));
        let own = || keys.iter().find(|key| document.has(key)).or(keys.first());
        let key = overridden.or_else(own).copied();
        self.problems.push_with(|| document.problem(key.unwrap_or(""), message, help));
    }

    pub(super) fn default_note(&self, key: &str) -> &'static str {
        if self.document.has(key) { "" } else { " (the default)" }
    }
}
