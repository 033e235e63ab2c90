//! The configuration's keys as a JSON Schema (draft 7), for editors that complete and check while one types.
//!
//! It follows from the declarations of [`super::settings`], as messages and documentation do. What one key asks of
//! another, and what the DBC has, is for `tertius check` alone.

use super::reference::toml_default;
use super::schema::{Key, Kind, Limits, Scalar, Table, WholeLimits};
use super::settings::ROOT;
use super::text::{LONGEST_NAME, LONGEST_PATH, LONGEST_TAG, LONGEST_TEXT, TextRule};
use serde_json::{Map, Value, json};
use std::ops::Bound;
use tertius_core::frame::BusNumber;

/// The schema as text that ends with a newline.
pub fn json_schema() -> String {
    let mut schema = table(&ROOT);
    schema.insert("$schema".to_owned(), "http://json-schema.org/draft-07/schema#".into());
    schema.insert("title".to_owned(), "Configuration of Tertius".into());
    format!("{:#}\n", Value::Object(schema))
}

fn table(table: &Table) -> Map<String, Value> {
    let properties: Map<String, Value> =
        table.keys.iter().map(|key| (key.name.to_owned(), Value::Object(property(key)))).collect();
    let required: Vec<&str> =
        table.keys.iter().filter(|key| key.is_required()).map(|key| key.name).collect();
    let mut schema = Map::new();
    schema.insert("type".to_owned(), "object".into());
    schema.insert("properties".to_owned(), properties.into());
    schema.insert("additionalProperties".to_owned(), false.into());
    if !required.is_empty() {
        schema.insert("required".to_owned(), required.into());
    }
    schema
}

fn property(key: &Key) -> Map<String, Value> {
    let mut schema = match &key.kind {
        Kind::Table(inner) => table(inner),
        Kind::Tables(inner) => list(Value::Object(table(inner)), None),
        Kind::One(scalar) => of_scalar(scalar),
        Kind::List { least, most, of } => list(Value::Object(of_scalar(of)), Some((*least, *most))),
    };
    schema.insert("description".to_owned(), key.what.into());
    if let Some(default) = default(key) {
        schema.insert("default".to_owned(), default);
    }
    schema
}

fn default(key: &Key) -> Option<Value> {
    let text = toml_default(key.default?)?;
    let table: toml::Table = format!("value = {text}").parse().ok()?;
    serde_json::to_value(table.get("value")?).ok()
}

fn list(items: Value, counts: Option<(usize, usize)>) -> Map<String, Value> {
    let mut schema = Map::new();
    schema.insert("type".to_owned(), "array".into());
    schema.insert("items".to_owned(), items);
    if let Some((least, most)) = counts {
        schema.insert("minItems".to_owned(), least.into());
        schema.insert("maxItems".to_owned(), most.into());
    }
    schema
}

fn of_scalar(scalar: &Scalar) -> Map<String, Value> {
    let schema = match scalar {
        Scalar::Switch => json!({"type": "boolean"}),
        Scalar::Choice(words) => json!({"type": "string", "enum": words}),
        Scalar::Number(limits) => number(limits),
        Scalar::Whole(limits) => whole(limits),
        Scalar::Text(rule) => text(*rule),
    };
    match schema {
        Value::Object(schema) => schema,
        _ => Map::new(),
    }
}

fn number(limits: &Limits) -> Value {
    let mut schema = json!({"type": "number"});
    for (bound, [included, excluded]) in [
        (limits.low, ["minimum", "exclusiveMinimum"]),
        (limits.high, ["maximum", "exclusiveMaximum"]),
    ] {
        match bound {
            Bound::Included(limit) => schema[included] = limit.into(),
            Bound::Excluded(limit) => schema[excluded] = limit.into(),
            Bound::Unbounded => {}
        }
    }
    schema
}

fn whole(limits: &WholeLimits) -> Value {
    // Beyond 64 bits there is no number in the file.
    let number = |limit: i128| {
        i64::try_from(limit)
            .map(Value::from)
            .or_else(|_| u64::try_from(limit).map(Value::from))
            .ok()
    };
    let mut schema = json!({"type": "integer"});
    for (key, limit) in [("minimum", limits.low), ("maximum", limits.high)] {
        if let Some(limit) = number(limit) {
            schema[key] = limit;
        }
    }
    schema
}

/// What a regular expression and a length can say of a text; [`TextRule::check`] says the rest, and counts bytes where
/// the schema counts characters.
fn text(rule: TextRule) -> Value {
    const NAME: &str = "[A-Za-z_][A-Za-z0-9_]*";
    // Not blank, and without control characters.
    const LINE: &str = r"^[^\x00-\x1f\x7f-\x9f]*[^\s\x00-\x1f\x7f-\x9f][^\x00-\x1f\x7f-\x9f]*$";
    let bus = format!("(({}):)?", BusNumber::NAMES.join("|"));
    let pattern = match rule {
        TextRule::Name | TextRule::Tag | TextRule::Path | TextRule::Authority => LINE.to_owned(),
        TextRule::Interface => r"^[^\s/\x00-\x1f\x7f-\x9f]{1,15}$".to_owned(),
        TextRule::Message => format!("^{bus}{NAME}$"),
        TextRule::Signal => format!(r"^{bus}{NAME}\.{NAME}$"),
        TextRule::CylinderSignal => {
            const LISTED: &str = "[A-Za-z0-9_{},. ]*";
            let object = "object +0[xX][0-9A-Fa-f]+(:[0-9A-Fa-f]+)? *";
            format!(r"^({object}|{bus}{LISTED}\.{LISTED})$")
        }
        TextRule::Listen => r"^(off|[0-9.]+:[0-9]{1,5}|\[[0-9A-Fa-f:.%]+\]:[0-9]{1,5})$".to_owned(),
        TextRule::Digest => "^[0-9A-Fa-f]{64}$".to_owned(),
        TextRule::Broker => {
            r"^(off|[A-Za-z0-9._-]+:[0-9]{1,5}|\[[0-9A-Fa-f:.]+\]:[0-9]{1,5})$".to_owned()
        }
        TextRule::Topic => r"^[^+#$/\x00-\x1f\x7f-\x9f]+(/[^+#$/\x00-\x1f\x7f-\x9f]+)*$".to_owned(),
        TextRule::EdgeNode => r"^[^+#$/\x00-\x1f\x7f-\x9f]+/[^+#$/\x00-\x1f\x7f-\x9f]+$".to_owned(),
        TextRule::Day => "^[0-9]{4}-(0[1-9]|1[0-2])-(0[1-9]|[12][0-9]|3[01])$".to_owned(),
    };
    let mut schema = json!({"type": "string", "pattern": pattern});
    let longest = match rule {
        TextRule::Name => Some(LONGEST_TEXT),
        TextRule::Tag => Some(LONGEST_TAG),
        TextRule::Path | TextRule::Authority => Some(LONGEST_PATH),
        TextRule::Message | TextRule::Topic | TextRule::EdgeNode => Some(LONGEST_NAME),
        _ => None,
    };
    if let Some(longest) = longest {
        schema["maxLength"] = longest.into();
    }
    schema
}
