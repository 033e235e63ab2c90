//! The folder of `replay --parquet` in a program that was built without Parquet: there is none.

use super::Failure;
use super::files::{Inputs, Overwriting};
use crate::alarm::Warning;
use crate::config::MachineNames;
use crate::incident::Incident;
use crate::monitor::{Notice, Record};
use crate::report::Summary;
use crate::sequential::Dwell;
use crate::time::Timestamp;
use std::path::Path;

pub use NoColumnFolder as ColumnFolder;

/// What is never made.
#[derive(Debug)]
pub enum NoColumnFolder {}

impl NoColumnFolder {
    /// Refuses.
    ///
    /// # Errors
    /// Always.
    pub fn create(
        _: &Path,
        _: (&str, MachineNames),
        _: Inputs,
        _: Overwriting,
    ) -> Result<Self, Failure> {
        Err(Failure::Wrong(
            "--parquet: this program was built without it; build it with the feature: cargo install --locked \
             --path . --features parquet"
                .to_owned(),
        ))
    }

    pub const fn begin(&mut self, _: Timestamp, _: Timestamp) {
        match *self {}
    }

    pub const fn record(&mut self, _: &Record) -> Result<(), Failure> {
        match *self {}
    }

    pub const fn warning(&mut self, _: &Warning) -> Result<(), Failure> {
        match *self {}
    }

    pub const fn incident(&mut self, _: &Incident) -> Result<(), Failure> {
        match *self {}
    }

    pub const fn notice(&mut self, _: &Notice) -> Result<(), Failure> {
        match *self {}
    }

    pub const fn dwell(&mut self, _: u8, _: &Dwell) -> Result<(), Failure> {
        match *self {}
    }

    pub fn finish(self, _: &Summary<'_>, _: &str, _: f64) -> Result<(), Failure> {
        match self {}
    }
}
