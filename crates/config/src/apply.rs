//! Puts overrides into a configuration: into its values, which are then judged as those of the file are, and into its
//! text, by which it is known elsewhere.

use super::document::Document;
use super::overrides::{Override, Overrides};
use super::problem::Problems;
use super::schema::{Key, Kind, Scalar, Table};
use super::settings::ROOT;
use super::walk::{SIMILAR, join, most_similar};
use std::borrow::Cow;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use toml_edit::{DocumentMut, Item, TableLike, Value};

/// Puts each override into `root`, the values of a file. Those whose key cannot be overridden are problems.
pub(super) fn apply<'i>(
    root: &mut DeTable<'i>,
    overrides: &'i Overrides,
    document: &Document,
    problems: &mut Problems,
) {
    for one in overrides.all() {
        match key_of(one) {
            Ok(key) => put(root, one.key(), value(one, key)),
            Err((message, help)) => {
                problems.push_with(|| document.problem_with(one, message, help))
            }
        }
    }
}

/// The text of a file with each override in it; comments and order stay. `None` if it is no TOML.
pub(super) fn effective(text: &str, overrides: &Overrides) -> Option<String> {
    let mut document: DocumentMut = text.parse().ok()?;
    for one in overrides.all() {
        let Ok(key) = key_of(one) else { continue };
        // A text is written as TOML writes it, everything else as it was given.
        let value = match value(one, key) {
            DeValue::String(text) => Value::from(text.into_owned()),
            _ => one.value().parse().ok()?,
        };
        let (path, name) = split(one.key());
        if let Some(table) = table_at(document.as_table_mut(), path, true) {
            set(table, name, value);
        }
    }
    Some(document.to_string())
}

impl Document {
    /// The text `after`, which was made from [`Document::effective`], without the overrides: keys have again what they
    /// have in the file, unless their value was replaced meanwhile.
    pub fn without_overrides(&self, after: &str) -> String {
        let restored = match self.overrides() {
            overrides if overrides.is_empty() => None,
            overrides => restored(after, self.text(), overrides),
        };
        restored.unwrap_or_else(|| after.to_owned())
    }
}

/// [`Document::without_overrides`] of the text `file`; `None` if a text is no TOML.
fn restored(after: &str, file: &str, overrides: &Overrides) -> Option<String> {
    let mut document: DocumentMut = after.parse().ok()?;
    let mut own: DocumentMut = file.parse().ok()?;
    let mut with: DocumentMut = effective(file, overrides)?.parse().ok()?;
    for one in overrides.all() {
        let (path, name) = split(one.key());
        let value_in = |document: &mut DocumentMut| {
            let table = table_at(document.as_table_mut(), path, false)?;
            table.get(name).and_then(Item::as_value).cloned()
        };
        let plain = |value: Option<Value>| value.map(|value| value.decorated("", "").to_string());
        let [before, given, now] =
            [value_in(&mut own), value_in(&mut with), value_in(&mut document)];
        let replaced = plain(given) != plain(now);
        let Some(table) = table_at(document.as_table_mut(), path, false).filter(|_| !replaced)
        else {
            continue;
        };
        match before {
            Some(before) => set(table, name, before),
            None => _ = table.remove(name),
        }
    }
    Some(document.to_string())
}

/// The key of an override.
///
/// # Errors
/// Message and help, if there is none, or none that one value is of.
fn key_of(one: &Override) -> Result<&'static Key, (String, String)> {
    let mut table = &ROOT;
    let mut path = String::new();
    for name in one.key().split('.') {
        // `cylinder[0].theta` is a key of a list, too.
        let Some(key) = table.key(name.split('[').next().unwrap_or(name)) else { break };
        path = join(&path, key.name);
        match &key.kind {
            Kind::Tables(_) => {
                let message =
                    format!("[[{path}]] is a list of tables, of which no key can be overridden");
                return Err((
                    message,
                    "change the file; each of its tables says whose it is".to_owned(),
                ));
            }
            Kind::Table(inner) => table = inner,
            Kind::One(_) | Kind::List { .. } if path == one.key() => return Ok(key),
            Kind::One(_) | Kind::List { .. } => break,
        }
    }
    let own = one.name_of(one.key());
    if path == one.key() {
        let keys: Vec<String> = leaves(&path, table).iter().map(|key| one.name_of(key)).collect();
        let message = format!("`{own}` is a table, of which single keys can be overridden");
        return Err((message, format!("they are {}", keys.join(", "))));
    }
    Err((format!("there is no key `{own}`"), nearest(one)))
}

/// Advice on an override whose key is not known.
fn nearest(one: &Override) -> String {
    let known = leaves("", &ROOT);
    let near = most_similar(one.key(), known.iter().map(String::as_str));
    let near = near.filter(|(_, score)| *score >= SIMILAR).map(|(key, _)| key);
    let namesake = || known.iter().find(|key| split(key).1 == split(one.key()).1);
    match near.or_else(|| namesake().map(String::as_str)) {
        Some(near) => format!("the nearest known key is `{}`", one.name_of(near)),
        None => format!(
            "a key has the name of its table before it, such as {}; `tertius config --defaults` lists all",
            one.name_of("fde.high")
        ),
    }
}

/// Full names of all keys of `table` and of the tables in it that can be overridden.
fn leaves(path: &str, table: &Table) -> Vec<String> {
    let mut found = Vec::new();
    for key in table.keys {
        let full =
            if path.is_empty() { key.name.to_owned() } else { format!("{path}.{}", key.name) };
        match &key.kind {
            Kind::Table(inner) => found.extend(leaves(&full, inner)),
            Kind::Tables(_) => {}
            Kind::One(_) | Kind::List { .. } => found.push(full),
        }
    }
    found
}

/// The value of an override for `key`. Where a text is expected quotes may be left out, as a shell removes them.
fn value<'i>(one: &'i Override, key: &Key) -> DeValue<'i> {
    let is_text = matches!(key.kind, Kind::One(Scalar::Text(_) | Scalar::Choice(_)));
    let text = || DeValue::String(Cow::Borrowed(one.value()));
    match DeValue::parse(one.value()).map(Spanned::into_inner) {
        Ok(quoted @ DeValue::String(_)) => quoted,
        Ok(other) if !is_text => other,
        _ => text(),
    }
}

fn put<'i>(root: &mut DeTable<'i>, path: &str, value: DeValue<'i>) {
    let (tables, name) = split(path);
    let mut table = root;
    for part in tables.split('.').filter(|part| !part.is_empty()) {
        if !table.contains_key(part) {
            let fresh = DeValue::Table(DeTable::new());
            table
                .insert(Spanned::new(0..0, Cow::Owned(part.to_owned())), Spanned::new(0..0, fresh));
        }
        let Some(DeValue::Table(inner)) = table.get_mut(part).map(Spanned::get_mut) else {
            // What is there instead is a problem of the file.
            return;
        };
        table = inner;
    }
    table.remove(name);
    table.insert(Spanned::new(0..0, Cow::Owned(name.to_owned())), Spanned::new(0..0, value));
}

/// Names of the tables, and that of the key in the last one.
fn split(key: &str) -> (&str, &str) {
    key.rsplit_once('.').unwrap_or(("", key))
}

/// The table with the full name `path`, which is made if it is wanted and not there.
fn table_at<'a>(
    root: &'a mut dyn TableLike,
    path: &str,
    make: bool,
) -> Option<&'a mut dyn TableLike> {
    let mut table = root;
    for part in path.split('.').filter(|part| !part.is_empty()) {
        if make && table.get(part).is_none() {
            table.insert(part, Item::Table(toml_edit::Table::new()));
        }
        table = table.get_mut(part)?.as_table_like_mut()?;
    }
    Some(table)
}

/// Sets a key; its comment stays.
fn set(table: &mut dyn TableLike, name: &str, mut value: Value) {
    match table.get_mut(name).and_then(Item::as_value_mut) {
        Some(old) => {
            *value.decor_mut() = old.decor().clone();
            *old = value;
        }
        None => _ = table.insert(name, Item::Value(value)),
    }
}
