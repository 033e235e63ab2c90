//! The table of residuals, as comma-separated values.

use crate::monitor::Record;
use crate::time::Timestamp;
use std::io::{self, Write};

/// Columns, which the first line names.
pub const HEADER: &str = "t,cylinder,c1,c2,c2_corrected,u,estimate1,estimate2,r1,r2,r3,gated";

/// Writes one row for each cylinder and cycle, in full double precision. Missing values are empty;
/// `gated` is 1 where neither FDE1 nor FDE2 judged.
#[derive(Debug)]
pub struct ResidualTable<W: Write> {
    out: W,
}

impl<W: Write> ResidualTable<W> {
    /// A table on `out`, which should be buffered.
    ///
    /// # Errors
    /// Errors of `out`.
    pub fn new(mut out: W) -> io::Result<Self> {
        writeln!(out, "{HEADER}")?;
        Ok(Self { out })
    }

    /// Writes the row of `record`; `first` is the time stamp of the recording's first frame.
    ///
    /// # Errors
    /// Errors of the output.
    pub fn write(&mut self, first: Timestamp, record: &Record) -> io::Result<()> {
        let t = record.timestamp.since(first).as_seconds();
        write!(self.out, "{t},{}", record.cylinder)?;
        let readings = [record.c1, record.c2, record.c2_corrected, record.command];
        for value in readings.into_iter().chain(record.estimates).chain(record.residuals) {
            match value {
                // `Display` of a double is the shortest form that reads back the same.
                Some(value) => write!(self.out, ",{value}")?,
                None => write!(self.out, ",")?,
            }
        }
        writeln!(self.out, ",{}", u8::from(record.gated))
    }

    /// The underlying writer, which may still buffer rows.
    pub fn into_inner(self) -> W {
        self.out
    }
}
