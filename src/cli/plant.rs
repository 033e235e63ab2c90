//! The simulated machine of a command line.

use super::Failure;
use crate::config::Settings;
use crate::plant;
use crate::simulator::Tables;
use clap::Args;
use std::fmt;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Largest table of a plant that is read, bytes.
const LARGEST_TABLE: u64 = 1 << 20;

/// Files that describe the simulated machine.
#[derive(Args, Debug)]
pub struct PlantOptions {
    /// The simulated machine [default: built in, as config/e-type-plant.toml]; and a file that `identify --nonlinear`
    /// wrote, whose valves and friction then replace the machine's
    #[arg(long = "plant", value_name = "FILE")]
    files: Vec<PathBuf>,
}

impl PlantOptions {
    /// The files, which are inputs.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().map(PathBuf::as_path)
    }

    /// Says where the simulated machine and the one of `settings` cannot be the same.
    pub fn compare(tables: &Tables, settings: &Settings) {
        let ([low, high], [least, most]) = (tables.hexapod.reach, settings.machine.stroke);
        if (low, high) != (least, most) {
            tell!(
                "the simulated machine's cylinders go from {low} to {high} m, and machine.stroke is from {least} to \
                 {most} m; --plant FILE simulates another machine"
            );
        }
    }

    /// The tables in the files, or the built-in ones.
    ///
    /// # Errors
    /// An error in a file, or more than one of a kind.
    pub fn tables(&self) -> Result<Tables, Failure> {
        let (mut machine, mut identified) = (None, None);
        for path in &self.files {
            let text = read(path)?;
            let (kind, place) = if plant::is_identified(&text) {
                ("whose valves and friction were identified", &mut identified)
            } else {
                ("that describes a simulated machine", &mut machine)
            };
            if let Some((first, _)) = place.replace((path, text)) {
                let (first, path) = (first.display(), path.display());
                return Err(Failure::Wrong(format!(
                    "--plant {path}: {first} is a file already {kind}, give one of them"
                )));
            }
        }
        let tables = machine.map_or_else(
            || Ok(Tables::default()),
            |(path, text)| Tables::parse(&text).map_err(|error| wrong(path, &error)),
        )?;
        match identified {
            Some((path, text)) => tables.identified_by(&text).map_err(|error| wrong(path, &error)),
            None => Ok(tables),
        }
    }
}

fn wrong(path: &Path, error: &dyn fmt::Display) -> Failure {
    Failure::Wrong(format!("{}: {error}", path.display()))
}

fn read(path: &Path) -> Result<String, Failure> {
    let mut text = String::new();
    File::open(path)
        .and_then(|file| file.take(LARGEST_TABLE + 1).read_to_string(&mut text))
        .map_err(|error| wrong(path, &format!("cannot be read: {error}")))?;
    Ok(text)
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
