//! The folder of the recordings on disk. A recording is there whole or not at all, whenever the power fails.

use super::plan::MANIFEST;
use super::recording::RecordedFile;
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Begins the name of what is being written or removed.
const UNFINISHED: &str = ".unfinished-";

/// Most recordings with the same name: incidents of one second of several runs.
const SAME_NAME: usize = 100;

/// A folder of recordings, and the bytes that they may take.
#[derive(Debug)]
pub(super) struct RecordingFolder {
    path: PathBuf,
    quota: u64,
}

/// Whether `path` is the folder of a recording.
pub fn is_recording(path: &Path) -> bool {
    path.is_dir() && path.join(MANIFEST).is_file()
}

impl RecordingFolder {
    pub const fn new(path: PathBuf, quota: u64) -> Self {
        Self { path, quota }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Makes the folder if there is none, and removes what an earlier gateway has left unfinished; returns how
    /// many recordings that were.
    ///
    /// # Errors
    /// The folder cannot be made, read or changed.
    pub fn tidy(&self) -> io::Result<usize> {
        fs::create_dir_all(&self.path)?;
        let mut removed = 0;
        for entry in fs::read_dir(&self.path)? {
            let entry = entry?;
            let name = entry.file_name();
            let is_ours = name.to_string_lossy().starts_with(UNFINISHED);
            if is_ours && entry.file_type()?.is_dir() {
                fs::remove_dir_all(entry.path())?;
                removed += 1;
            }
        }
        Ok(removed)
    }

    /// Writes a recording under `name`, or with a number after it if there is one already, and returns its folder.
    /// The oldest recordings give way to it.
    ///
    /// # Errors
    /// It cannot be written, or is larger than all recordings may be. Nothing of it is left then.
    pub fn write(&self, name: &str, files: &[RecordedFile<'_>]) -> io::Result<PathBuf> {
        fs::create_dir_all(&self.path)?;
        self.make_room(files.iter().map(RecordedFile::size).sum())?;
        let unfinished = self.path.join(format!("{UNFINISHED}{name}"));
        let written = put(&unfinished, files).and_then(|()| self.show(&unfinished, name));
        if written.is_err() {
            // It may not even be there.
            _ = fs::remove_dir_all(&unfinished);
        }
        written
    }

    /// Renames what was written to `name`, or the next name that is free.
    fn show(&self, unfinished: &Path, name: &str) -> io::Result<PathBuf> {
        let others = (2..SAME_NAME).map(|n| format!("{name}-{n}"));
        for name in std::iter::once(name.to_owned()).chain(others) {
            let path = self.path.join(name);
            // A folder that is not empty is never replaced, so that looking first is no more than a shortcut.
            if fs::symlink_metadata(&path).is_ok() {
                continue;
            }
            fs::rename(unfinished, &path)?;
            File::open(&self.path)?.sync_all()?;
            return Ok(path);
        }
        let told = format!("there are {SAME_NAME} recordings named {name}");
        Err(io::Error::new(ErrorKind::AlreadyExists, told))
    }

    /// Removes the oldest recordings until there is room for `bytes`.
    fn make_room(&self, bytes: u64) -> io::Result<()> {
        if bytes > self.quota {
            let told = format!(
                "it has {bytes} bytes, and all recordings together may have {} (`recorder.size`)",
                self.quota
            );
            return Err(io::Error::new(ErrorKind::QuotaExceeded, told));
        }
        let mut recordings = self.recordings()?;
        recordings.sort();
        let mut taken: u64 = recordings.iter().map(|(_, size)| size).sum();
        for (name, size) in recordings {
            if taken + bytes <= self.quota {
                break;
            }
            // First its name, so that no half of it is ever seen.
            let going = self.path.join(format!("{UNFINISHED}{name}"));
            fs::rename(self.path.join(&name), &going)?;
            fs::remove_dir_all(&going)?;
            taken -= size;
        }
        Ok(())
    }

    /// Names and sizes of the recordings. Anything else that is in the folder is nobody's business here.
    fn recordings(&self) -> io::Result<Vec<(String, u64)>> {
        let mut found = Vec::new();
        for entry in fs::read_dir(&self.path)? {
            let entry = entry?;
            let Ok(name) = entry.file_name().into_string() else { continue };
            let is_one = is_name(&name) && entry.file_type()?.is_dir();
            if is_one && is_recording(&entry.path()) {
                found.push((name, size(&entry.path())?));
            }
        }
        Ok(found)
    }
}

/// Whether a recording may be called so: a time stamp, and what it is of.
fn is_name(name: &str) -> bool {
    let is_digits =
        |text: &str, count| text.len() == count && text.bytes().all(|b| b.is_ascii_digit());
    let Some((stamp, what)) = name.split_once('-') else { return false };
    let stamp = stamp.strip_suffix('Z').and_then(|stamp| stamp.split_once('T'));
    let is_stamp = stamp.is_some_and(|(day, time)| is_digits(day, 8) && is_digits(time, 6));
    let kinds = ["cylinder-", "machine-incident-", "on-demand"];
    is_stamp && kinds.iter().any(|kind| what.starts_with(kind))
}

/// Bytes of the files of a folder.
fn size(folder: &Path) -> io::Result<u64> {
    let sizes = fs::read_dir(folder)?.map(|entry| Ok(entry?.metadata()?.len()));
    sizes.sum()
}

/// Writes files into a new folder, down to the disk.
fn put(folder: &Path, files: &[RecordedFile<'_>]) -> io::Result<()> {
    match fs::remove_dir_all(folder) {
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
        _ => fs::create_dir(folder)?,
    }
    for RecordedFile { name, parts } in files {
        let mut file = OpenOptions::new().write(true).create_new(true).open(folder.join(name))?;
        parts.iter().try_for_each(|part| file.write_all(part))?;
        file.sync_all()?;
    }
    File::open(folder)?.sync_all()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(folder: &RecordingFolder, name: &str, bytes: usize) -> io::Result<PathBuf> {
        let (content, manifest) = (vec![b'x'; bytes], [b'{'; 10]);
        let file = |name, content| RecordedFile { name, parts: vec![content] };
        let files = [file("frames.log.zst", content.as_slice()), file(MANIFEST, &manifest)];
        folder.write(name, &files)
    }

    fn names(folder: &RecordingFolder) -> Vec<String> {
        let entries = fs::read_dir(&folder.path).expect("it is there");
        let name = |entry: io::Result<fs::DirEntry>| entry.expect("it is there").file_name();
        let mut names: Vec<_> = entries.map(|it| name(it).into_string().expect("UTF-8")).collect();
        names.sort();
        names
    }

    #[test]
    fn the_oldest_give_way_and_strangers_stay() {
        let top = tempfile::tempdir().expect("there is room");
        let folder = RecordingFolder::new(top.path().join("new/recordings"), 3500);
        assert_eq!(folder.tidy().expect("the folder is ours"), 0);
        let stranger = folder.path.join("20200101T000000Z-cylinder-notes");
        fs::create_dir(&stranger).expect("the folder is ours");
        fs::write(stranger.join("notes.txt"), vec![0; 5000]).expect("the folder is ours");
        let name = |n: u32| format!("2026010{n}T000000Z-cylinder-1-incident-{n}");
        for n in [3, 1, 2, 4, 5] {
            write(&folder, &name(n), 1000).expect("there is room");
        }
        let stranger = "20200101T000000Z-cylinder-notes".to_owned();
        assert_eq!(names(&folder), [stranger.clone(), name(3), name(4), name(5)]);
        // One that is too large takes no other with it.
        let told = write(&folder, &name(6), 4000).expect_err("it is too large").to_string();
        assert!(told.contains("recorder.size"), "{told}");
        assert_eq!(names(&folder), [stranger, name(3), name(4), name(5)]);
    }

    #[test]
    fn a_name_that_is_taken_gets_a_number() {
        let top = tempfile::tempdir().expect("there is room");
        let folder = RecordingFolder::new(top.path().to_owned(), 1 << 20);
        let name = "20260101T000000Z-cylinder-1-incident-1";
        (0..3).for_each(|_| drop(write(&folder, name, 10).expect("there is room")));
        assert_eq!(names(&folder), [name.to_owned(), format!("{name}-2"), format!("{name}-3")]);
    }

    #[test]
    fn what_was_left_unfinished_goes_at_the_next_start() {
        let top = tempfile::tempdir().expect("there is room");
        let folder = RecordingFolder::new(top.path().to_owned(), 1 << 20);
        let name = "20260101T000000Z-on-demand";
        write(&folder, name, 10).expect("there is room");
        let half = top.path().join(format!("{UNFINISHED}{name}"));
        fs::create_dir(&half).expect("the folder is ours");
        fs::write(half.join(MANIFEST), "{").expect("the folder is ours");
        assert_eq!(folder.tidy().expect("the folder is ours"), 1);
        assert_eq!(names(&folder), [name]);
    }

    #[test]
    fn what_cannot_be_written_leaves_nothing() {
        let top = tempfile::tempdir().expect("there is room");
        let folder = RecordingFolder::new(top.path().to_owned(), 1 << 20);
        let files = [RecordedFile { name: "no/such/place", parts: vec![b"x"] }];
        assert!(folder.write("20260101T000000Z-on-demand", &files).is_err());
        assert!(names(&folder).is_empty());
        fs::write(top.path().join("file"), "").expect("the folder is ours");
        assert!(write(&RecordingFolder::new(top.path().join("file"), 1 << 20), "x", 1).is_err());
    }
}
