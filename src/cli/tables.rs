//! Tables that commands write for the configuration, into files of their own or in place.

use super::Failure;
use super::files::{self, Claimed, Inputs, Mark, Overwriting};
use super::machine::{Designer, Machine};
use super::survey::{Field, Surveyed};
use crate::config::{self, edit};
use clap::Args;
use similar::TextDiff;
use std::io::Write;
use std::path::{Path, PathBuf};

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
    place: &InPlace,
) -> Result<[Option<Claimed>; 2], Failure> {
    let logs = field.logs.iter().map(PathBuf::as_path);
    let into = place.into.as_deref();
    let other = |file: &&Path| into.is_none_or(|into| !files::is_same(file, into));
    // The configuration is read and may be written to, in place.
    let [config, rest @ ..] = &surveyed.machine.files(&field.config).collect::<Vec<_>>()[..] else {
        return Err(Failure::Failed("a machine has no configuration".to_owned()));
    };
    let inputs = Inputs::new(logs.chain(Some(*config).filter(other)).chain(rest.iter().copied()));
    let wanted = [
        (tables.as_deref(), Mark::Tables(command)),
        (page.as_deref(), Mark::Page(command)),
        (into, Mark::Judged),
    ];
    let [tables, page, _] = inputs.claim(wanted, overwriting)?;
    Ok([tables, page])
}

/// A configuration that tables are put into.
#[derive(Args, Debug)]
pub struct InPlace {
    /// Puts the tables into this configuration, where their keys are; comments and order stay, and
    /// the file as it was is kept beside it
    #[arg(long, value_name = "CONFIG.toml")]
    into: Option<PathBuf>,
    /// Shows what --into would change, and changes nothing
    #[arg(long, requires = "into")]
    dry_run: bool,
}

impl InPlace {
    /// The tables are put into the configuration `config` itself.
    pub fn is(&self, config: &Path) -> bool {
        self.into.as_deref().is_some_and(|into| files::is_same(into, config))
    }
}

/// Files as they were that are kept beside a configuration.
const KEPT: usize = 99;

impl InPlace {
    /// Puts `tables` into the configuration, if one was named. Keys `anew` of cylinders to which the
    /// tables give none are removed. `design` says what the whole is good for.
    ///
    /// # Errors
    /// It cannot be read or written, or would be refused with the tables in it; then nothing has changed.
    pub fn put(&self, tables: &str, anew: &[&str], design: Designer) -> Result<(), Failure> {
        self.put_after(tables, anew, design, |_| Ok(()))
    }

    /// As [`Self::put`]; `ready` gets the whole before anything is written, and is not asked where nothing
    /// is.
    ///
    /// # Errors
    /// As [`Self::put`], and what `ready` says; then nothing has changed, too.
    pub fn put_after(
        &self,
        tables: &str,
        anew: &[&str],
        design: Designer,
        ready: impl FnOnce(&str) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let Some(path) = self.into.as_deref() else { return Ok(()) };
        let name = path.display();
        let loaded = config::load(path)?;
        let before = loaded.document.text();
        let after = edit::put(before, tables, anew).map_err(|error| {
            Failure::Failed(format!("{name} cannot be edited; nothing was changed: {error}"))
        })?;
        approve(path, &after, design)?;
        if self.dry_run {
            return show(path, before, &after);
        }
        ready(&after)?;
        replace(path, before, &after)
    }
}

/// Whether the configuration `after` would be taken in the place of `path`.
///
/// # Errors
/// It would be refused, and why.
pub fn approve(path: &Path, after: &str, design: Designer) -> Result<(), Failure> {
    let refused = |refusal: Failure| {
        let name = path.display();
        Failure::Failed(format!(
            "with these tables {name} would be refused; nothing was changed.\n{refusal}"
        ))
    };
    Machine::of_text(path, after, design).map(drop).map_err(refused)
}

/// Shows on standard output what `after` has of other lines than the text `before` of `path`.
///
/// # Errors
/// It cannot be written.
pub fn show(path: &Path, before: &str, after: &str) -> Result<(), Failure> {
    let difference = TextDiff::from_lines(before, after);
    let name = path.display().to_string();
    let shown = difference.unified_diff().header(&name, "with the tables").to_string();
    std::io::stdout()
        .write_all(shown.as_bytes())
        .map_err(|error| Failure::writing("standard output", &error))
}

/// Writes `after` in the place of the text `before` of the file `path`, which is kept beside it.
///
/// # Errors
/// It cannot be written, or holds something else by now; then nothing has changed.
pub fn replace(path: &Path, before: &str, after: &str) -> Result<(), Failure> {
    let [written] =
        Inputs::default().claim([(Some(path), Mark::Text(before))], Overwriting::default())?;
    let kept = keep(path, before)?;
    written.map_or(Ok(()), |written| written.write(after))?;
    tell!("{} has the tables; as it was it is {}", path.display(), kept.display());
    Ok(())
}

/// Keeps `text`, which is that of the file `path`, beside it under the next free name.
fn keep(path: &Path, text: &str) -> Result<PathBuf, Failure> {
    let beside = |n: usize| {
        let mut name = path.as_os_str().to_owned();
        name.push(format!(".bak-{n}"));
        PathBuf::from(name)
    };
    let free = (1..=KEPT).map(beside).find(|path| path.symlink_metadata().is_err());
    let Some(free) = free else {
        return Err(Failure::Wrong(format!(
            "{} and {} others are kept beside it already; remove what is not needed",
            beside(1).display(),
            KEPT - 1
        )));
    };
    let [kept] = Inputs::default().claim([(Some(&free), Mark::None)], Overwriting::default())?;
    kept.map_or(Ok(()), |kept| kept.write(text))?;
    Ok(free)
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
