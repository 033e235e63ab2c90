//! Checks the file against the schema and reports unknown or missing keys and values of the wrong
//! type or out of range, all in one pass.

use std::borrow::Cow;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeInteger, DeTable, DeValue};

use super::document::Document;
use super::problem::Problems;
use super::schema::{Key, Kind, Scalar, Table};
use super::settings::ROOT;
use super::visible::visible;

/// Most characters of a user's key or value that a message repeats.
const SHOWN: usize = 60;
/// Similarity to a known word (1: equal) above which a word is taken for a typing error. Below it
/// the meaning is unclear: "amber" has two letters of "red".
pub(super) const SIMILAR: f64 = 0.6;

/// Compares the file with the schema, notes where every known key is, and removes unknown keys, so
/// that the rest can still be checked.
pub(super) fn walk(root: &mut DeTable<'_>, document: &mut Document, problems: &mut Problems) {
    Walk { document, problems }.table("", root, &ROOT);
}

struct Walk<'a> {
    document: &'a mut Document,
    problems: &'a mut Problems,
}

/// What is wrong with a single value.
enum Fault {
    Type,
    Value { must: String, help: String },
}

impl Walk<'_> {
    fn table(&mut self, path: &str, table: &mut DeTable<'_>, schema: &Table) {
        let mut meant = Vec::new();
        let names: Vec<_> = table.keys().cloned().collect();
        for name in names.iter().filter(|name| schema.key(name.get_ref()).is_none()) {
            self.unknown(path, name, schema);
            let near = nearest(name.get_ref(), schema);
            meant.extend(near.filter(|(_, score)| *score >= SIMILAR).map(|(key, _)| key));
            table.remove(name);
        }
        for (name, value) in table.iter_mut() {
            if let Some(key) = schema.key(name.get_ref()) {
                self.value(&join(path, key.name), key, name.span(), value);
            }
        }
        let absent = |key: &&Key| key.is_required() && !table.contains_key(key.name);
        for key in schema.keys.iter().filter(absent) {
            // One mistake, one problem: a misspelt key is not missing as well.
            if !meant.contains(&key.name) {
                self.missing(path, key);
            }
        }
    }

    fn value(
        &mut self,
        path: &str,
        key: &Key,
        name: Range<usize>,
        value: &mut Spanned<DeValue<'_>>,
    ) {
        let span = value.span();
        match (&key.kind, value.get_mut()) {
            (Kind::Table(schema), DeValue::Table(table)) => {
                self.document.record(path, name);
                self.table(path, table, schema);
            }
            (Kind::Tables(schema), DeValue::Array(elements)) => {
                self.document.record(path, name);
                for (index, element) in elements.iter_mut().enumerate() {
                    let path = format!("{path}[{index}]");
                    let span = element.span();
                    match element.get_mut() {
                        DeValue::Table(table) => {
                            self.document.record(&path, span);
                            self.table(&path, table, schema);
                        }
                        other => self.wrong_type(&path, span, other, key, "a table"),
                    }
                }
            }
            (Kind::One(scalar), value) => {
                self.document.record(path, span.clone());
                self.scalar(path, span, key, scalar, value);
            }
            (Kind::List { least, most, of }, DeValue::Array(elements)) => {
                self.document.record(path, span.clone());
                if !(*least..=*most).contains(&elements.len()) {
                    self.wrong_count(path, span, key, elements.len(), (*least, *most));
                    return;
                }
                for (index, element) in elements.iter().enumerate() {
                    let path = format!("{path}[{index}]");
                    self.document.record(&path, element.span());
                    self.scalar(&path, element.span(), key, of, element.get_ref());
                }
            }
            (_, other) => self.wrong_type(path, span, other, key, &key.expected()),
        }
    }

    fn scalar(
        &mut self,
        path: &str,
        span: Range<usize>,
        key: &Key,
        scalar: &Scalar,
        value: &DeValue<'_>,
    ) {
        let (must, help) = match judge(scalar, value) {
            Ok(()) => return,
            Err(Fault::Type) => {
                return self.wrong_type(path, span, value, key, scalar.expected());
            }
            Err(Fault::Value { must, help }) => (must, help),
        };
        let document = &*self.document;
        self.problems.push_with(|| {
            let found = shown(document.written(path, span.clone()));
            let message = format!("`{path}` is {found}, but must be {must}");
            let help = if help.is_empty() { key.meaning() } else { help };
            document.problem_at(span, path, message, help)
        });
    }

    fn unknown(&mut self, path: &str, name: &Spanned<Cow<'_, str>>, schema: &Table) {
        let document = &*self.document;
        self.problems.push_with(|| {
            let (key, table) = (shown(name.get_ref()), table_name(path));
            let known = schema.names().collect::<Vec<_>>().join(", ");
            let near = match nearest(name.get_ref(), schema) {
                Some((near, _)) => format!("the nearest known key is `{near}`; "),
                None => String::new(),
            };
            let elsewhere = match home_of(name.get_ref(), "", &ROOT) {
                Some(home) => format!("`{key}` is a key of {}; ", table_name(&home)),
                None => String::new(),
            };
            let help = format!("{elsewhere}{near}{table} knows {known}");
            let message = format!("{table} has an unknown key, `{key}`");
            document.problem_at(name.span(), &join(path, &key), message, help)
        });
    }

    fn missing(&mut self, path: &str, key: &Key) {
        let document = &*self.document;
        self.problems.push_with(|| {
            let full = join(path, key.name);
            let lacks = match key.kind {
                Kind::Table(_) | Kind::Tables(_) => format!("[{full}]"),
                Kind::One(_) | Kind::List { .. } => format!("`{}`", key.name),
            };
            let help = match key.kind {
                Kind::Table(schema) => format!("{}; write {}", key.what, sketch(&full, schema)),
                _ => key.meaning(),
            };
            document.problem(&full, format!("{} lacks {lacks}", table_name(path)), help)
        });
    }

    fn wrong_type(
        &mut self,
        path: &str,
        span: Range<usize>,
        found: &DeValue<'_>,
        key: &Key,
        expected: &str,
    ) {
        let document = &*self.document;
        self.problems.push_with(|| {
            let message = format!("`{path}` is {}, but must be {expected}", type_name(found));
            let help = key.meaning();
            document.problem_at(span, path, message, help)
        });
    }

    fn wrong_count(
        &mut self,
        path: &str,
        span: Range<usize>,
        key: &Key,
        found: usize,
        (least, most): (usize, usize),
    ) {
        let document = &*self.document;
        self.problems.push_with(|| {
            let must = if least == most { least.to_string() } else { format!("{least} to {most}") };
            let message = format!("`{path}` is a list of {found}, but must be one of {must}");
            let help = key.meaning();
            document.problem_at(span, path, message, help)
        });
    }
}

fn judge(scalar: &Scalar, value: &DeValue<'_>) -> Result<(), Fault> {
    let out_of = |must: String, help: &str| Err(Fault::Value { must, help: help.into() });
    match (scalar, value) {
        (Scalar::Text(rule), DeValue::String(text)) => match rule.check(text) {
            Ok(()) => Ok(()),
            Err(fault) => out_of(fault.must, fault.help),
        },
        (Scalar::Choice(choices), DeValue::String(text)) => {
            if choices.contains(&text.as_ref()) {
                return Ok(());
            }
            let near = most_similar(text, choices.iter().copied())
                .filter(|(_, score)| *score >= SIMILAR)
                .map_or(String::new(), |(near, _)| format!("the nearest is {near}"));
            out_of(format!("one of {}", choices.join(", ")), &near)
        }
        (Scalar::Number(limits), DeValue::Float(_) | DeValue::Integer(_)) => match number(value) {
            Some(value) if limits.hold(value) => Ok(()),
            _ => out_of(limits.to_string(), limits.why),
        },
        (Scalar::Whole(limits), DeValue::Integer(integer)) => match whole(integer) {
            Some(value) if (limits.low..=limits.high).contains(&value) => Ok(()),
            _ => out_of(limits.to_string(), limits.why),
        },
        (Scalar::Switch, DeValue::Boolean(_)) => Ok(()),
        _ => Err(Fault::Type),
    }
}

/// A number as `f64`; whole ones within 64 bits, as the deserializer takes them.
fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) => {
            whole(integer).and_then(|value| i64::try_from(value).ok()).map(|value| value as f64)
        }
        _ => None,
    }
}

fn whole(integer: &DeInteger<'_>) -> Option<i128> {
    i128::from_str_radix(integer.as_str(), integer.radix()).ok()
}

fn type_name(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a string",
        DeValue::Integer(_) => "a whole number",
        DeValue::Float(_) => "a number with a fraction",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date or time",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    }
}

fn nearest(name: &str, schema: &Table) -> Option<(&'static str, f64)> {
    most_similar(name, schema.names())
}

/// The candidate most similar to `name` and how similar it is, from 0 to 1 (equal).
pub(super) fn most_similar<'a>(
    name: &str,
    candidates: impl Iterator<Item = &'a str>,
) -> Option<(&'a str, f64)> {
    // Beyond this no known key is near, and the comparison takes time with the length squared.
    let name: String = name.chars().take(SHOWN).collect();
    let name = name.to_lowercase().replace('-', "_");
    candidates
        .map(|candidate| (candidate, strsim::normalized_damerau_levenshtein(&name, candidate)))
        .max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The table that does know this key, if another one does.
fn home_of(name: &str, path: &str, table: &Table) -> Option<String> {
    table.keys.iter().find_map(|key| match key.kind {
        Kind::Table(inner) | Kind::Tables(inner) => {
            let path = join(path, key.name);
            if inner.key(name).is_some() { Some(path) } else { home_of(name, &path, inner) }
        }
        Kind::One(_) | Kind::List { .. } => None,
    })
}

/// The least that a table must hold, in words.
fn sketch(path: &str, schema: &Table) -> String {
    let required = || schema.keys.iter().filter(|key| key.is_required());
    let keys = required().filter(|key| !key.example.is_empty()).map(Key::written);
    let keys: Vec<_> = keys.collect();
    let own = (!keys.is_empty()).then(|| format!("[{path}] with {}", keys.join(", ")));
    let inner = required().filter_map(|key| match key.kind {
        Kind::Table(schema) => Some(sketch(&join(path, key.name), schema)),
        Kind::Tables(_) | Kind::One(_) | Kind::List { .. } => None,
    });
    own.into_iter().chain(inner).collect::<Vec<_>>().join("; ")
}

pub(super) fn join(path: &str, name: &str) -> String {
    if path.is_empty() { name.into() } else { format!("{path}.{name}") }
}

/// A table as a person would look for it; tables of a list by their number.
fn table_name(path: &str) -> String {
    match path.strip_suffix(']').and_then(|path| path.rsplit_once('[')) {
        Some((name, index)) => {
            let number = index.parse::<usize>().map_or(1, |index| index + 1);
            format!("[[{name}]] number {number}")
        }
        None if path.is_empty() => "the top level".into(),
        None => format!("[{path}]"),
    }
}

/// The user's own text on one line, shortened if long.
fn shown(text: &str) -> String {
    let short: String = text.chars().take(SHOWN).collect();
    let dots = if short.len() < text.len() { "…" } else { "" };
    format!("{}{dots}", visible(&short))
}
