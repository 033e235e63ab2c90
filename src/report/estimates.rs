//! The table of estimates, as comma-separated values.

use crate::estimate::Estimate;
use crate::time::Timestamp;
use std::io::{self, Write};

/// Columns, which the first line names.
pub const HEADER: &str = "t,cylinder,estimate,sigma,valid,source";

/// Writes one row for each cylinder and cycle, in full double precision, m. Unknown values are
/// empty; values that are not valid are for inspection only.
#[derive(Debug)]
pub struct EstimateTable<W: Write> {
    out: W,
}

impl<W: Write> EstimateTable<W> {
    /// A table on `out`, which should be buffered.
    ///
    /// # Errors
    /// Errors of `out`.
    pub fn new(mut out: W) -> io::Result<Self> {
        writeln!(out, "{HEADER}")?;
        Ok(Self { out })
    }

    /// Writes the row of a cycle that opened at `at`; `first` is the time stamp of the recording's first
    /// frame.
    ///
    /// # Errors
    /// Errors of the output.
    pub fn write(
        &mut self,
        first: Timestamp,
        at: Timestamp,
        cylinder: u8,
        estimate: Option<&Estimate>,
    ) -> io::Result<()> {
        let t = at.since(first).as_seconds();
        let Some(Estimate { position, sigma, source, valid }) = estimate else {
            return writeln!(self.out, "{t},{cylinder},,,0,");
        };
        write!(self.out, "{t},{cylinder},{position},")?;
        if sigma.is_finite() {
            write!(self.out, "{sigma}")?;
        }
        writeln!(self.out, ",{},{}", u8::from(*valid), source.name())
    }

    /// The underlying writer, which may still buffer rows.
    pub fn into_inner(self) -> W {
        self.out
    }
}
