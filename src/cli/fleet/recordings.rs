//! The recordings that FLEET.toml means.

use crate::bus::{Interfaces, Options, Recording, Source};
use crate::failure::Failure;
use crate::time::Timestamp;
use std::fs;
use std::path::{Path, PathBuf};

/// Most recordings of a machine: one a minute for a year.
const MOST: usize = 600_000;

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
        gather(Path::new(pattern), &mut found).map_err(|error| format!("{pattern}: {error}"))?;
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
fn gather(pattern: &Path, found: &mut Vec<PathBuf>) -> Result<(), std::io::Error> {
    let mut paths = vec![PathBuf::new()];
    for part in pattern.components() {
        let name = part.as_os_str().to_string_lossy();
        if !name.contains(['*', '?']) {
            paths.iter_mut().for_each(|path| path.push(part));
            continue;
        }
        let mut next = Vec::new();
        for folder in paths.iter().filter(|path| path.is_dir()) {
            let fitting = |path: &PathBuf| fits(&name_of(path), &name);
            next.extend(entries(folder)?.into_iter().filter(fitting));
        }
        paths = next;
    }
    for path in paths {
        if path.is_dir() {
            found.extend(entries(&path)?.into_iter().filter(|file| file.is_file()));
        } else if path.is_file() {
            found.push(path);
        }
    }
    Ok(())
}

/// What is in a folder and is not hidden.
fn entries(folder: &Path) -> Result<Vec<PathBuf>, std::io::Error> {
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if !name_of(&path).starts_with('.') {
            paths.push(path);
        }
    }
    Ok(paths)
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Whether `name` fits a `pattern`, in which `*` is any text and `?` any character.
fn fits(name: &str, pattern: &str) -> bool {
    let (name, pattern): (Vec<char>, Vec<char>) =
        (name.chars().collect(), pattern.chars().collect());
    // Where the newest star stands, and how much of the name it has taken.
    let (mut at, mut in_pattern, mut star) = (0, 0, None);
    while at < name.len() {
        match pattern.get(in_pattern) {
            Some('*') => {
                star = Some((in_pattern, at));
                in_pattern += 1;
            }
            Some(&c) if c == '?' || c == name[at] => (at, in_pattern) = (at + 1, in_pattern + 1),
            _ => match star {
                Some((place, taken)) => {
                    star = Some((place, taken + 1));
                    (at, in_pattern) = (taken + 1, place + 1);
                }
                None => return false,
            },
        }
    }
    pattern[in_pattern..].iter().all(|c| *c == '*')
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
        for (name, pattern) in [
            ("a.log", "*.log"),
            ("a.log", "a*"),
            ("a.log", "?.l*g"),
            ("aab", "*ab"),
            ("", "*"),
            ("a", "a"),
        ] {
            assert!(fits(name, pattern), "{name} {pattern}");
        }
        for (name, pattern) in
            [("a.log", "*.zst"), ("ab", "?"), ("", "?"), ("abc", "*b"), ("a", "b")]
        {
            assert!(!fits(name, pattern), "{name} {pattern}");
        }
    }
}
