//! The table of residuals, as comma-separated values.

use super::csv::NameColumn;
use super::number;
use std::io::{self, Write};
use tertius_config::MachineNames;
use tertius_core::monitor::Record;
use tertius_core::time::Timestamp;

/// Columns, which the first line names, beside that of the cylinder's name.
pub const HEADER: &str = "t,cylinder,c1,c2,c2_corrected,u,estimate1,estimate2,r1,r2,r3,gated";

/// Columns that may be empty.
const VALUES: usize = 9;

/// A row of the table: a cylinder and cycle.
#[derive(Clone, Copy, Debug)]
pub struct ResidualRow {
    /// s.
    t: f64,
    cylinder: u8,
    /// In the unit of [`Record`].
    values: [Option<f64>; VALUES],
    gated: bool,
}

impl ResidualRow {
    /// The row of `record`; `first` is the time stamp of the recording's first frame.
    pub fn new(first: Timestamp, record: &Record) -> Self {
        let Record { c1, c2, c2_corrected, command, estimates, residuals, .. } = *record;
        let ([e1, e2], [r1, r2, r3]) = (estimates, residuals);
        Self {
            t: record.timestamp.since(first).as_seconds(),
            cylinder: record.cylinder,
            values: [c1, c2, c2_corrected, command, e1, e2, r1, r2, r3],
            gated: record.gated,
        }
    }
}

/// Writes one row for each cylinder and cycle, in full double precision. Missing values are empty;
/// `gated` is 1 where neither FDE1 nor FDE2 judged.
#[derive(Debug)]
pub struct ResidualTable<W: Write> {
    out: W,
    names: NameColumn,
    line: Vec<u8>,
}

impl<W: Write> ResidualTable<W> {
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
    pub fn write(&mut self, row: &ResidualRow) -> io::Result<()> {
        let line = &mut self.line;
        line.clear();
        number::append(line, row.t);
        write!(line, ",{}{}", row.cylinder, self.names.after(Some(row.cylinder)))?;
        for value in row.values {
            line.push(b',');
            if let Some(value) = value {
                number::append(line, value);
            }
        }
        line.extend_from_slice(if row.gated { b",1\n" } else { b",0\n" });
        self.out.write_all(line)
    }

    /// The underlying writer, which may still buffer rows.
    pub fn into_inner(self) -> W {
        self.out
    }
}
