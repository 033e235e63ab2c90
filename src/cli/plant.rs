//! The simulated machine of a command line.

use super::Failure;
use crate::simulator::Tables;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Largest table of a plant that is read, bytes.
const LARGEST_TABLE: u64 = 1 << 20;

/// The tables in the file `path`, or the built-in ones.
///
/// # Errors
/// An error in the file.
pub fn tables(path: Option<&Path>) -> Result<Tables, Failure> {
    let Some(path) = path else { return Ok(Tables::default()) };
    let wrong = |what: String| Failure::Wrong(format!("{}: {what}", path.display()));
    let mut text = String::new();
    File::open(path)
        .and_then(|file| file.take(LARGEST_TABLE + 1).read_to_string(&mut text))
        .map_err(|error| wrong(format!("cannot be read: {error}")))?;
    Tables::parse(&text).map_err(|error| wrong(error.to_string()))
}

/// Parses `HS,TP`.
///
/// # Errors
/// What was expected.
pub fn sea(text: &str) -> Result<[f64; 2], Failure> {
    let numbers: Vec<f64> = text.split(',').map_while(|part| part.trim().parse().ok()).collect();
    match numbers[..] {
        [height, period] if text.split(',').count() == 2 => Ok([height, period]),
        _ => Err(Failure::Wrong(format!(
            "--sea is {text:?}, expected wave height, m, and peak period, s, such as 2.5,9"
        ))),
    }
}
