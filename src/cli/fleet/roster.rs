//! FLEET.toml: the machines of a fleet.

use crate::failure::Failure;
use serde::Deserialize;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Most machines of a fleet.
const MOST: usize = 100_000;

/// Longest name of a machine, in bytes: it is the name of a folder.
const LONGEST: usize = 64;

/// The machines of a fleet.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Roster {
    #[serde(rename = "machine")]
    pub machines: Vec<RosterEntry>,
}

/// A machine, its paths as they lead from the working directory.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RosterEntry {
    pub name: String,
    pub config: PathBuf,
    /// Files, patterns of files and folders; or URLs, which nobody looks at here.
    pub recordings: Vec<String>,
    /// The interface of recordings with several.
    pub interface: Option<String>,
    /// The history of the stops to begin with.
    pub history: Option<PathBuf>,
}

impl Roster {
    /// The fleet in the file `path`.
    ///
    /// # Errors
    /// The file cannot be read, is something else, or has two machines of one name.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let wrong = |why: String| Failure::Wrong(format!("{}: {why}", path.display()));
        let text =
            fs::read_to_string(path).map_err(|it| wrong(format!("it cannot be read: {it}")))?;
        let mut roster: Self = toml::from_str(&text).map_err(|error| {
            wrong(format!(
                "it is no list of machines, each with [[machine]], name, config and recordings: {error}"
            ))
        })?;
        if roster.machines.is_empty() || roster.machines.len() > MOST {
            return Err(wrong(format!(
                "it has {} machines; expected 1 to {MOST}, each with [[machine]]",
                roster.machines.len()
            )));
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut names = BTreeSet::new();
        for machine in &mut roster.machines {
            check_name(&machine.name).map_err(wrong)?;
            // Names are folders, and some file systems do not tell a from A.
            if !names.insert(machine.name.to_lowercase()) {
                return Err(wrong(format!(
                    "two machines are called {:?}; each needs a name of its own, which its results are kept under",
                    machine.name
                )));
            }
            machine.resolve(folder);
        }
        Ok(roster)
    }
}

fn check_name(name: &str) -> Result<(), String> {
    let is_wrong = |c: char| c.is_control() || matches!(c, '/' | '\\');
    if name.is_empty() || name.len() > LONGEST || name.starts_with('.') || name.contains(is_wrong) {
        return Err(format!(
            "a machine is called {name:?}; a name is a folder, too: 1 to {LONGEST} bytes, no slash, no point ahead"
        ));
    }
    Ok(())
}

impl RosterEntry {
    /// Makes the paths relative to `folder`, where they are not absolute.
    fn resolve(&mut self, folder: &Path) {
        let whole = |path: &Path| {
            let path = folder.join(path);
            std::path::absolute(&path).unwrap_or(path)
        };
        self.config = whole(&self.config);
        self.history = self.history.as_deref().map(whole);
        for recording in &mut self.recordings {
            if !is_url(recording) {
                *recording = whole(Path::new(recording)).to_string_lossy().into_owned();
            }
        }
    }
}

/// Whether a recording is somewhere else: `https://…`, `s3://…`.
pub fn is_url(recording: &str) -> bool {
    let scheme = recording.split_once("://").map(|(scheme, _)| scheme);
    scheme.is_some_and(|it| !it.is_empty() && it.bytes().all(|byte| byte.is_ascii_alphanumeric()))
}
