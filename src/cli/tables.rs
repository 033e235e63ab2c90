//! Files of tables that commands write for the configuration.

use super::Failure;
use super::survey::{Field, Surveyed};
use std::fs;
use std::io::Write;
use std::path::Path;

/// Refuses `outputs` of which one is an input, or another one.
///
/// # Errors
/// It is.
pub fn refuse_overwriting(
    outputs: &[Option<&Path>],
    field: &Field,
    surveyed: &Surveyed,
) -> Result<(), Failure> {
    let machine = [&field.config, &surveyed.machine.loaded.dbc_path];
    let outputs: Vec<&Path> = outputs.iter().copied().flatten().collect();
    for (place, output) in outputs.iter().enumerate() {
        let mut inputs = field.logs.iter().chain(machine);
        if let Some(input) = inputs.find(|input| is_same(input, output)) {
            return Err(Failure::Wrong(format!(
                "{} would be written over the input {}; name another file",
                output.display(),
                input.display()
            )));
        }
        if outputs[..place].iter().any(|other| is_same(other, output)) {
            return Err(Failure::Wrong(format!(
                "{} is to hold two outputs; name a file for each",
                output.display()
            )));
        }
    }
    Ok(())
}

fn is_same(one: &Path, other: &Path) -> bool {
    let canonical = |path: &Path| fs::canonicalize(path).ok();
    one == other || canonical(one).is_some_and(|it| canonical(other) == Some(it))
}

/// Shows `page` and writes `tables`, where both are there, to `output`.
///
/// # Errors
/// Neither standard output nor the file can be written.
pub fn publish(page: &str, output: Option<&Path>, tables: Option<&str>) -> Result<(), Failure> {
    std::io::stdout()
        .write_all(page.as_bytes())
        .map_err(|error| Failure::writing("standard output", &error))?;
    match output.zip(tables) {
        Some((path, tables)) => {
            fs::write(path, tables).map_err(|error| Failure::creating(path, &error))
        }
        None => Ok(()),
    }
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
