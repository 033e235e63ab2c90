//! Files of tables that commands write for the configuration.

use super::Failure;
use super::files::{Claimed, Inputs, Mark, Overwriting};
use super::survey::{Field, Surveyed};
use std::io::Write;
use std::path::PathBuf;

/// Takes the files for the tables and the page of `command`, which reads `surveyed`.
///
/// # Errors
/// One of them is an input, is not to be written over, or cannot be written.
pub fn claim(
    command: &str,
    [tables, page]: [&Option<PathBuf>; 2],
    overwriting: Overwriting,
    field: &Field,
    surveyed: &Surveyed,
) -> Result<[Option<Claimed>; 2], Failure> {
    let logs = field.logs.iter().map(PathBuf::as_path);
    let inputs = Inputs::new(logs.chain(surveyed.machine.files(&field.config)));
    let wanted =
        [(tables.as_deref(), Mark::Tables(command)), (page.as_deref(), Mark::Page(command))];
    inputs.claim(wanted, overwriting)
}

/// Shows `page` and writes `tables`, where both are there, to `output`.
///
/// # Errors
/// Neither standard output nor the file can be written.
pub fn publish(page: &str, output: Option<Claimed>, tables: Option<&str>) -> Result<(), Failure> {
    std::io::stdout()
        .write_all(page.as_bytes())
        .map_err(|error| Failure::writing("standard output", &error))?;
    output.zip(tables).map_or(Ok(()), |(output, tables)| output.write(tables))
}

/// A rate of false alarms, as the command line has it.
///
/// # Errors
/// What was expected.
pub fn per_year(text: &str) -> Result<f64, String> {
    let sound = text.parse().ok().filter(|rate: &f64| rate.is_finite() && *rate > 0.0);
    sound.ok_or_else(|| {
        "expected how many false alarms a year may bring, above 0; 8766 is one an hour".to_owned()
    })
}
