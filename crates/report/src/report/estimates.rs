//! The table of estimates, as comma-separated values.

use super::csv::NameColumn;
use super::number;
use std::io::{self, Write};
use tertius_config::MachineNames;
use tertius_core::estimate::Estimate;
use tertius_core::time::Timestamp;

/// Columns, which the first line names, beside that of the cylinder's name.
pub const HEADER: &str = "t,cylinder,estimate,sigma,valid,source,without";

/// A row of the table: a cylinder and cycle.
#[derive(Clone, Copy, Debug)]
pub struct EstimateRow {
    /// s.
    t: f64,
    cylinder: u8,
    estimate: Option<Estimate>,
}

impl EstimateRow {
    /// The row of a cycle that opened at `at`; `first` is the time stamp of the recording's first frame.
    pub fn new(first: Timestamp, at: Timestamp, cylinder: u8, estimate: Option<&Estimate>) -> Self {
        Self { t: at.since(first).as_seconds(), cylinder, estimate: estimate.copied() }
    }
}

/// Writes one row for each cylinder and cycle, in full double precision, m. Unknown values are
/// empty; values that are not valid are for inspection only.
#[derive(Debug)]
pub struct EstimateTable<W: Write> {
    out: W,
    names: NameColumn,
    line: Vec<u8>,
}

impl<W: Write> EstimateTable<W> {
    /// A table on `out`, which should be buffered, of a machine whose cylinders have these `names`.
    ///
    /// # Errors
    /// Errors of `out`.
    pub fn new(mut out: W, names: &MachineNames) -> io::Result<Self> {
        let names = NameColumn::new(names);
        writeln!(out, "{}", names.among(HEADER.split(',')))?;
        Ok(Self { out, names, line: Vec::new() })
    }

    /// Writes a row.
    ///
    /// # Errors
    /// Errors of the output.
    pub fn write(&mut self, row: &EstimateRow) -> io::Result<()> {
        let line = &mut self.line;
        line.clear();
        number::append(line, row.t);
        write!(line, ",{}{},", row.cylinder, self.names.after(Some(row.cylinder)))?;
        match &row.estimate {
            None => line.extend_from_slice(b",,0,,\n"),
            Some(Estimate { position, sigma, source, valid, without }) => {
                number::append(line, *position);
                line.push(b',');
                if sigma.is_finite() {
                    number::append(line, *sigma);
                }
                write!(line, ",{},{},", u8::from(*valid), source.name())?;
                number::append(line, *without);
                line.push(b'\n');
            }
        }
        self.out.write_all(line)
    }

    /// The underlying writer, which may still buffer rows.
    pub fn into_inner(self) -> W {
        self.out
    }
}
