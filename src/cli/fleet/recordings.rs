//! The recordings that FLEET.toml means.

use crate::bus::{Interfaces, Options, Recording, Source};
use crate::failure::Failure;
use crate::time::Timestamp;
use glob::MatchOptions;
use std::fs;
use std::path::PathBuf;

/// Most recordings of a machine: one a minute for a year.
const MOST: usize = 600_000;

/// A star stands for no folder and for no hidden file.
const AS_IN_A_SHELL: MatchOptions = MatchOptions {
    case_sensitive: true,
    require_literal_separator: true,
    require_literal_leading_dot: true,
};

/// A recording with its times.
#[derive(Clone, Debug)]
pub struct TimedRecording {
    pub path: PathBuf,
    /// Size as stored, bytes.
    pub bytes: u64,
    pub begin: Timestamp,
    /// Time stamp of the last frame; `None` where only the first one was read.
    pub end: Option<Timestamp>,
}

/// The files that `patterns` mean, each once, in the order of their names.
///
/// # Errors
/// A pattern means none, or a folder cannot be read.
pub fn files(patterns: &[String]) -> Result<Vec<PathBuf>, String> {
    let mut all = Vec::new();
    for pattern in patterns {
        let mut found = Vec::new();
        gather(pattern, &mut found).map_err(|error| format!("{pattern}: {error}"))?;
        if found.is_empty() {
            return Err(format!(
                "{pattern}: there is no such recording; expected a file, a folder with files, or a pattern with * or ?"
            ));
        }
        all.extend(found);
        if all.len() > MOST {
            return Err(format!("more than {MOST} recordings"));
        }
    }
    all.sort();
    all.dedup();
    Ok(all)
}

/// Adds the files that `pattern` means.
fn gather(pattern: &str, found: &mut Vec<PathBuf>) -> Result<(), std::io::Error> {
    // What is there by that very name is meant, whatever a pattern of the same letters would mean.
    if fs::exists(pattern)? {
        return add(PathBuf::from(pattern), found);
    }
    let paths = glob::glob_with(pattern, AS_IN_A_SHELL).map_err(std::io::Error::other)?;
    for path in paths {
        add(path?, found)?;
    }
    Ok(())
}

/// Adds the file `path`, or the files of that folder that are not hidden.
fn add(path: PathBuf, found: &mut Vec<PathBuf>) -> Result<(), std::io::Error> {
    if path.is_file() {
        found.push(path);
        return Ok(());
    }
    for entry in fs::read_dir(path)? {
        let entry = entry?;
        let is_hidden = entry.file_name().as_encoded_bytes().starts_with(b".");
        if !is_hidden && entry.path().is_file() {
            found.push(entry.path());
        }
    }
    Ok(())
}

/// The recording in `path`; to its end, or only its first frame if it has to be `quick`.
///
/// # Errors
/// It cannot be read, or has no frame.
pub fn timed(
    path: PathBuf,
    interfaces: &Interfaces,
    quick: bool,
) -> Result<TimedRecording, Failure> {
    let options = Options { interfaces: interfaces.clone(), ..Options::default() };
    let mut recording = Recording::open(&[&path], options)?;
    let begin = match recording.next_frame()? {
        Some(frame) => frame.timestamp,
        None => {
            return Err(Failure::Wrong(format!(
                "{}: it has no frame of the machine's interface; leave it out, or see what `tertius replay` says of it",
                path.display()
            )));
        }
    };
    let mut end = begin;
    while !quick && let Some(frame) = recording.next_frame()? {
        end = end.max(frame.timestamp);
    }
    let bytes = fs::metadata(&path).map_or(0, |it| it.len());
    Ok(TimedRecording { path, bytes, begin, end: (!quick).then_some(end) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_mean_what_they_do_in_a_shell() {
        let folder = tempfile::tempdir().expect("it can be made");
        for name in ["1/a.log", "1/ab.zst", "1/.b.log", "2/a.log", "2/c/d.log", "[x]/e.log"] {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().expect("it has one")).expect("it can be made");
            fs::write(path, "").expect("it can be written");
        }
        let found = |patterns: &[&str]| {
            let whole = |it: &&str| folder.path().join(it).to_str().expect("it is text").to_owned();
            let patterns: Vec<String> = patterns.iter().map(whole).collect();
            let files = files(&patterns)?;
            let name = |it: &PathBuf| it.strip_prefix(&folder).expect("it is there").to_owned();
            Ok::<_, String>(
                files.iter().map(|it| name(it).display().to_string()).collect::<Vec<_>>(),
            )
        };
        assert_eq!(found(&["1"]).unwrap(), ["1/a.log", "1/ab.zst"]);
        assert_eq!(found(&["*/a.log"]).unwrap(), ["1/a.log", "2/a.log"]);
        assert_eq!(found(&["?/*.log"]).unwrap(), ["1/a.log", "2/a.log"]);
        assert_eq!(found(&["2/*"]).unwrap(), ["2/a.log", "2/c/d.log"]);
        assert_eq!(found(&["1/a*", "1/*.zst", "1"]).unwrap(), ["1/a.log", "1/ab.zst"]);
        // By its own name, though `[x]` is a pattern that means `x`.
        assert_eq!(found(&["[x]"]).unwrap(), ["[x]/e.log"]);
        for none in ["3", "*.log", "1/*.b.log", "1/***"] {
            assert!(found(&[none]).is_err(), "{none}");
        }
    }
}
