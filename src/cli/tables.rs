//! Tables that commands write for the configuration, into files of their own or in place.

use super::Failure;
use super::differences::differences;
use super::files::{self, Claimed, Inputs, Mark, Overwriting};
use super::machine::{Designer, Machine};
use super::survey::{Field, Surveyed};
use crate::config::{self, Overrides, edit};
use crate::failure::print;
use clap::Args;
use similar::TextDiff;
use std::path::{Path, PathBuf};

/// Claims the files for the tables and the page of `command`, which reads `surveyed`, before minutes are spent on them.
///
/// # Errors
/// A file is an input, must not be overwritten, or cannot be written; tables would go into the
/// configuration of another machine; or tables are wanted of a recording that is damaged.
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
    place.is_of(&surveyed.machine)?;
    if tables.is_some() || place.is_wanted() {
        surveyed.whole()?;
    }
    Ok([tables, page])
}

/// A configuration that tables are put into.
#[derive(Args, Debug)]
pub struct InPlace {
    /// Puts the tables into this configuration, where their keys are; comments and order stay, and
    /// a copy of the previous file is kept beside it
    #[arg(long, value_name = "CONFIG.toml")]
    into: Option<PathBuf>,
    /// Shows what --into would change, and changes nothing
    #[arg(long, requires = "into")]
    dry_run: bool,
}

impl InPlace {
    /// Whether the tables go into a configuration.
    pub const fn is_wanted(&self) -> bool {
        self.into.is_some()
    }

    /// Whether the tables go into the configuration `config` itself.
    pub fn is(&self, config: &Path) -> bool {
        self.into.as_deref().is_some_and(|into| files::is_same(into, config))
    }

    /// Checks that the tables go into a configuration of the machine `learnt`, by which the recording is read.
    ///
    /// # Errors
    /// What differs; or the configuration cannot be read.
    fn is_of(&self, learnt: &Machine) -> Result<(), Failure> {
        let Some(path) = self.into.as_deref() else { return Ok(()) };
        let found = Machine::load_surveying(path, &Overrides::default())?;
        let differs = differences(&found, learnt);
        if differs.is_empty() {
            return Ok(());
        }
        let (name, config) = (path.display(), learnt.loaded.title());
        Err(Failure::Wrong(format!(
            "{name} is not of the machine of {config}, and would get its tables: {}. Nothing was changed; \
             name a configuration of one machine in --config and --into",
            differs.join("; ")
        )))
    }
}

/// Most previous files that are kept beside a configuration.
const KEPT: usize = 99;

impl InPlace {
    /// Puts `tables` into the configuration, if one was named. Keys `anew` of cylinders for which
    /// the tables have none are removed. `design` makes the design by which the result is
    /// validated.
    ///
    /// # Errors
    /// The configuration cannot be read or written, or would be refused with the tables in
    /// it; nothing has changed then.
    pub fn put(&self, tables: &str, anew: &[&str], design: Designer) -> Result<(), Failure> {
        self.put_after(tables, anew, design, |_| Ok(()))
    }

    /// Puts tables as [`Self::put`] does; `ready` gets the new text before anything is written, and
    /// is not called if nothing is.
    ///
    /// # Errors
    /// See [`Self::put`]; also errors of `ready`, after which nothing has changed either.
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

/// Checks that the configuration `after` would be accepted in the place of `path`.
///
/// # Errors
/// The reasons for which it would be refused.
pub fn approve(path: &Path, after: &str, design: Designer) -> Result<(), Failure> {
    let refused = |refusal: Failure| {
        let name = path.display();
        Failure::Failed(format!(
            "with these tables {name} would be refused; nothing was changed.\n{refusal}"
        ))
    };
    Machine::of_text(path, after, design).map(drop).map_err(refused)
}

/// Shows on standard output the lines in which `after` differs from the text `before` of `path`.
///
/// # Errors
/// Standard output cannot be written.
pub fn show(path: &Path, before: &str, after: &str) -> Result<(), Failure> {
    let difference = TextDiff::from_lines(before, after);
    let name = path.display().to_string();
    let shown = difference.unified_diff().header(&name, "with the tables").to_string();
    print(&shown)
}

/// Replaces the text `before` of the file `path` by `after`, and keeps the previous file beside it.
///
/// # Errors
/// The file cannot be written, or has changed meanwhile; it is then left as it is.
pub fn replace(path: &Path, before: &str, after: &str) -> Result<(), Failure> {
    let [written] =
        Inputs::default().claim([(Some(path), Mark::Text(before))], Overwriting::default())?;
    let kept = keep(path, before)?;
    written.map_or(Ok(()), |written| written.write(after))?;
    tell!("{} now has the tables; the previous file is {}", path.display(), kept.display());
    Ok(())
}

/// Keeps `text`, the content of the file `path`, beside it under the next free name.
fn keep(path: &Path, text: &str) -> Result<PathBuf, Failure> {
    let beside = |n: usize| {
        let mut name = path.as_os_str().to_owned();
        name.push(format!(".bak-{n}"));
        PathBuf::from(name)
    };
    let free = (1..=KEPT).map(beside).find(|path| path.symlink_metadata().is_err());
    let Some(free) = free else {
        return Err(Failure::Wrong(format!(
            "{} and {} others are already kept beside it; remove those that are not needed",
            beside(1).display(),
            KEPT - 1
        )));
    };
    let [kept] = Inputs::default().claim([(Some(&free), Mark::None)], Overwriting::default())?;
    kept.map_or(Ok(()), |kept| kept.write(text))?;
    Ok(free)
}

/// Shows `page`, and writes `tables` to `output` if both are present.
///
/// # Errors
/// Neither standard output nor the file can be written.
pub fn publish(page: &str, output: Option<Claimed>, tables: Option<&str>) -> Result<(), Failure> {
    print(page)?;
    output.zip(tables).map_or(Ok(()), |(output, tables)| output.write(tables))
}

/// Parses a rate of false alarms from the command line.
///
/// # Errors
/// What was expected.
pub fn per_year(text: &str) -> Result<f64, String> {
    let sound = text.parse().ok().filter(|rate: &f64| rate.is_finite() && *rate > 0.0);
    sound.ok_or_else(|| {
        "expected a number of false alarms a year, above 0; 8766 is one an hour".to_owned()
    })
}
