//! Every key, as data for documents: what the declaration of a key says of it.

use super::schema::{Key, Kind, Scalar, Table};
use super::settings::ROOT;

/// A key of the configuration, or a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyEntry {
    /// Full name, for example `fde.low`; tables of a list are written `[[cylinder]]`.
    pub path: String,
    /// Name of its table, for example `fde`; empty for the tables of the top level.
    pub table: String,
    pub name: &'static str,
    pub is_table: bool,
    /// What values are valid, in words.
    pub values: String,
    /// The default in TOML; `None` for a required key, and where absence has a meaning of its own.
    pub default: Option<String>,
    pub is_required: bool,
    /// A valid value in TOML; empty for tables.
    pub example: &'static str,
    /// Purpose, with its unit.
    pub what: &'static str,
}

/// All keys, each table before its keys and its keys before its tables.
pub fn entries() -> Vec<KeyEntry> {
    let mut entries = Vec::new();
    gather("", &ROOT, &mut entries);
    entries
}

fn gather(table: &str, schema: &Table, entries: &mut Vec<KeyEntry>) {
    let inner = |key: &&Key| matches!(key.kind, Kind::Table(_) | Kind::Tables(_));
    let path = |key: &Key| {
        if table.is_empty() { key.name.to_owned() } else { format!("{table}.{}", key.name) }
    };
    for key in schema.keys.iter().filter(|key| !inner(key)) {
        entries.push(entry(table, path(key), key));
    }
    for key in schema.keys.iter().filter(inner) {
        entries.push(entry(table, path(key), key));
        if let Kind::Table(schema) | Kind::Tables(schema) = key.kind {
            gather(&path(key), schema, entries);
        }
    }
}

fn entry(table: &str, path: String, key: &Key) -> KeyEntry {
    KeyEntry {
        path,
        table: table.to_owned(),
        name: key.name,
        is_table: key.example.is_empty(),
        values: values(&key.kind),
        default: key.default.and_then(toml_default),
        is_required: key.is_required(),
        example: key.example,
        what: key.what,
    }
}

/// A default as TOML, unless it is one that only Rust can say.
pub(super) fn toml_default(rust: &str) -> Option<String> {
    let text = rust.trim_end_matches(".to_owned()");
    let written = format!("value = {text}");
    written.parse::<toml::Table>().is_ok().then(|| text.to_owned())
}

fn values(kind: &Kind) -> String {
    match kind {
        Kind::Table(_) => "table".to_owned(),
        Kind::Tables(_) => "tables".to_owned(),
        Kind::One(scalar) => one(scalar),
        Kind::List { least, most, of } if least == most => format!("{least} of: {}", one(of)),
        Kind::List { least, most, of } => format!("{least} to {most} of: {}", one(of)),
    }
}

fn one(scalar: &Scalar) -> String {
    match scalar {
        Scalar::Text(_) => "text".to_owned(),
        Scalar::Number(limits) => limits.to_string(),
        Scalar::Whole(limits) => format!("whole number, {limits}"),
        Scalar::Switch => "true or false".to_owned(),
        Scalar::Choice(words) => words.join(", "),
    }
}
