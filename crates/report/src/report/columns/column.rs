//! Columns of a table, and their encoding in a Parquet file.

use parquet::basic::{
    Compression, LogicalType, Repetition, TimeUnit, Type as PhysicalType, ZstdLevel,
};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{Type, TypePtr};
use std::borrow::Cow;
use std::sync::Arc;
use tertius_core::time::{Span, Timestamp};

/// How a column is had from a row; `None` is null in the file.
pub enum Cells<R> {
    /// Nanoseconds since 1970, UTC.
    Time(fn(&R) -> Option<Timestamp>),
    Count(fn(&R) -> Option<i64>),
    Number(fn(&R) -> Option<f64>),
    Text(fn(&R) -> Option<Cow<'static, str>>),
    Truth(fn(&R) -> Option<bool>),
}

/// A column of a table whose rows are made from `R`.
pub struct TableColumn<R> {
    pub name: &'static str,
    /// Unit of its numbers; empty where they have none.
    pub unit: &'static str,
    pub meaning: &'static str,
    pub cells: Cells<R>,
}

/// A column for the documentation: its table, its name, its unit and its meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ColumnDescription {
    pub table: &'static str,
    pub name: &'static str,
    pub unit: &'static str,
    pub meaning: &'static str,
}

/// A row of a table of which each Parquet file has one row group.
pub trait TableRow: Sized + 'static {
    /// Name of the table.
    const TABLE: &'static str;
    const COLUMNS: &'static [TableColumn<Self>];

    /// The time that says of which day the row is.
    fn at(&self) -> Timestamp;
}

/// The key of a file's metadata that has the unit of a column.
pub fn unit_key(column: &str) -> String {
    format!("tertius.unit.{column}")
}

/// The key of a file's metadata that has the meaning of a column.
pub fn meaning_key(column: &str) -> String {
    format!("tertius.meaning.{column}")
}

/// The columns of `R` for the documentation.
pub fn told<R: TableRow>() -> impl Iterator<Item = ColumnDescription> {
    R::COLUMNS.iter().map(|column| ColumnDescription {
        table: R::TABLE,
        name: column.name,
        unit: column.unit,
        meaning: column.meaning,
    })
}

/// A Parquet file with `rows`. Its metadata say the `machine`, the table, and the unit and the meaning of each column.
///
/// # Errors
/// The encoder's.
pub fn encode<R: TableRow>(rows: &[R], machine: &str) -> Result<Vec<u8>> {
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_created_by(format!("tertius {} replay", env!("CARGO_PKG_VERSION")))
        .set_key_value_metadata(Some(metadata::<R>(machine)))
        // There is one page of each column: an index of pages would be larger than it.
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_offset_index_disabled(true)
        .build();
    let mut file = SerializedFileWriter::new(Vec::new(), schema::<R>()?, Arc::new(properties))?;
    if !rows.is_empty() {
        let mut group = file.next_row_group()?;
        for column in R::COLUMNS {
            let mut writer = group
                .next_column()?
                .ok_or_else(|| ParquetError::General(format!("no place for {}", column.name)))?;
            write(writer.untyped(), column, rows)?;
            writer.close()?;
        }
        group.close()?;
    }
    file.into_inner()
}

fn metadata<R: TableRow>(machine: &str) -> Vec<KeyValue> {
    let pair = |key: String, value: &str| KeyValue::new(key, value.to_owned());
    let mut pairs = vec![
        pair("tertius.table".to_owned(), R::TABLE),
        pair("tertius.machine".to_owned(), machine),
        pair("tertius.version".to_owned(), env!("CARGO_PKG_VERSION")),
    ];
    for column in R::COLUMNS {
        if !column.unit.is_empty() {
            pairs.push(pair(unit_key(column.name), column.unit));
        }
        pairs.push(pair(meaning_key(column.name), column.meaning));
    }
    pairs
}

fn schema<R: TableRow>() -> Result<TypePtr> {
    let field = |column: &TableColumn<R>| {
        let (physical, logical) = match column.cells {
            Cells::Time(_) => {
                (PhysicalType::INT64, Some(LogicalType::timestamp(true, TimeUnit::NANOS)))
            }
            Cells::Count(_) => (PhysicalType::INT64, None),
            Cells::Number(_) => (PhysicalType::DOUBLE, None),
            Cells::Text(_) => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
            Cells::Truth(_) => (PhysicalType::BOOLEAN, None),
        };
        let builder = Type::primitive_type_builder(column.name, physical);
        let builder = builder.with_repetition(Repetition::OPTIONAL).with_logical_type(logical);
        builder.build().map(Arc::new)
    };
    let fields = R::COLUMNS.iter().map(field).collect::<Result<Vec<_>>>()?;
    Ok(Arc::new(Type::group_type_builder(R::TABLE).with_fields(fields).build()?))
}

/// Writes a column of all `rows`: the values that are known, and at which rows they are.
fn write<R>(writer: &mut ColumnWriter<'_>, column: &TableColumn<R>, rows: &[R]) -> Result<usize> {
    match (writer, &column.cells) {
        (ColumnWriter::Int64ColumnWriter(to), Cells::Time(get)) => {
            let (known, values) = split(rows, |row| get(row).map(Timestamp::as_nanos));
            to.write_batch(&values, Some(&known), None)
        }
        (ColumnWriter::Int64ColumnWriter(to), Cells::Count(get)) => {
            let (known, values) = split(rows, get);
            to.write_batch(&values, Some(&known), None)
        }
        (ColumnWriter::DoubleColumnWriter(to), Cells::Number(get)) => {
            let (known, values) = split(rows, get);
            to.write_batch(&values, Some(&known), None)
        }
        (ColumnWriter::ByteArrayColumnWriter(to), Cells::Text(get)) => {
            let (known, values) = split(rows, |row| {
                get(row).map(|text| ByteArray::from(text.into_owned().into_bytes()))
            });
            to.write_batch(&values, Some(&known), None)
        }
        (ColumnWriter::BoolColumnWriter(to), Cells::Truth(get)) => {
            let (known, values) = split(rows, get);
            to.write_batch(&values, Some(&known), None)
        }
        _ => Err(ParquetError::General(format!("{} is of another type", column.name))),
    }
}

/// Definition levels of all rows, 1 where there is a value, and the values.
fn split<R, V>(rows: &[R], get: impl Fn(&R) -> Option<V>) -> (Vec<i16>, Vec<V>) {
    let cells: Vec<Option<V>> = rows.iter().map(get).collect();
    let known = cells.iter().map(|cell| i16::from(cell.is_some())).collect();
    (known, cells.into_iter().flatten().collect())
}

/// The cells of `row` that are not null, as JSON has them; times as whole nanoseconds.
/// The number that the lines of JSON have for `span`, s: the double that is nearest to its digits.
pub(super) fn seconds(span: Span) -> Option<f64> {
    span.to_string().parse().ok()
}

pub(super) fn count(number: u64) -> Option<i64> {
    i64::try_from(number).ok()
}

#[cfg(test)]
pub fn cells<R: TableRow>(row: &R) -> serde_json::Map<String, serde_json::Value> {
    let cell = |column: &TableColumn<R>| {
        let value = match column.cells {
            Cells::Time(get) => get(row)?.as_nanos().into(),
            Cells::Count(get) => get(row)?.into(),
            Cells::Number(get) => get(row)?.into(),
            Cells::Text(get) => get(row)?.as_ref().into(),
            Cells::Truth(get) => get(row)?.into(),
        };
        Some((column.name.to_owned(), value))
    };
    R::COLUMNS.iter().filter_map(cell).collect()
}
