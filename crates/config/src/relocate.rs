//! A configuration for another folder: its relative paths lead from where it was.

use super::schema::{Kind, Scalar, Table};
use super::settings::ROOT;
use super::text::{SYSTEM, TextRule};
use toml_edit::{DocumentMut, Item, TableLike, TomlError, Value};

/// The configuration `text` of a file in `folder` as it has to be in any other one: each relative path in it begins with
/// `folder`. Everything else stays.
///
/// # Errors
/// `text` is not TOML.
pub fn relocate(text: &str, folder: &str) -> Result<String, TomlError> {
    let mut document: DocumentMut = text.parse()?;
    relocate_table(document.as_table_mut(), &ROOT, folder);
    Ok(document.to_string())
}

fn relocate_table(table: &mut dyn TableLike, schema: &Table, folder: &str) {
    for key in schema.keys {
        let Some(item) = table.get_mut(key.name) else { continue };
        match key.kind {
            Kind::Table(schema) => {
                if let Some(table) = item.as_table_like_mut() {
                    relocate_table(table, schema, folder);
                }
            }
            Kind::Tables(schema) => tables(item).for_each(|it| relocate_table(it, schema, folder)),
            Kind::One(Scalar::Text(TextRule::Path)) => relocate_path(item, folder),
            Kind::One(Scalar::Text(TextRule::Authority)) if item.as_str() != Some(SYSTEM) => {
                relocate_path(item, folder);
            }
            Kind::One(_) | Kind::List { .. } => {}
        }
    }
}

/// The tables of `[[name]]`, or of `name = [{ … }]`.
fn tables(item: &mut Item) -> Box<dyn Iterator<Item = &mut dyn TableLike> + '_> {
    match item {
        Item::ArrayOfTables(tables) => Box::new(tables.iter_mut().map(|it| it as _)),
        Item::Value(Value::Array(values)) => {
            let inline = values.iter_mut().filter_map(Value::as_inline_table_mut);
            Box::new(inline.map(|it| it as _))
        }
        _ => Box::new(std::iter::empty()),
    }
}

fn relocate_path(item: &mut Item, folder: &str) {
    let Some(Value::String(named)) = item.as_value_mut() else { return };
    if named.value().starts_with('/') {
        return;
    }
    let whole = format!("{}/{}", folder.trim_end_matches('/'), named.value());
    let decor = named.decor().clone();
    *named = toml_edit::Formatted::new(whole);
    *named.decor_mut() = decor;
}
