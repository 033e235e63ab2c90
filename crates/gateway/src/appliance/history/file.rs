//! The file of a machine's dwells, which is replaced atomically.

use crate::appliance::aside::set_aside;
use crate::appliance::durable;
use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};
use tertius_core::sequential::Archive;
use tertius_core::sequential::archive::{MAX_SIZE, Refusal};
use thiserror::Error;

/// Path of the file in which the dwells of a machine are kept.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HistoryFile(PathBuf);

/// Why a history cannot be restored.
#[derive(Debug, Error)]
pub enum ReadError {
    #[error("it cannot be read: {0}")]
    Io(#[from] io::Error),
    #[error(transparent)]
    Refused(#[from] Refusal),
}

impl HistoryFile {
    pub const fn new(path: PathBuf) -> Self {
        Self(path)
    }

    pub fn path(&self) -> &Path {
        &self.0
    }

    /// The archive of `machine` with this number of cylinders; `None` where there is no file yet.
    ///
    /// # Errors
    /// The file cannot be read, or belongs to another machine.
    pub fn read(&self, machine: &str, cylinders: u8) -> Result<Option<Archive>, ReadError> {
        let file = match File::open(&self.0) {
            Ok(file) => file,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error.into()),
        };
        let mut bytes = Vec::new();
        file.take(MAX_SIZE as u64 + 1).read_to_end(&mut bytes)?;
        Ok(Some(Archive::parse(&bytes, machine, cylinders)?))
    }

    /// Writes `archive` atomically: whenever the power fails, the file is this one or the previous
    /// one.
    ///
    /// # Errors
    /// The file cannot be written; the previous one then remains.
    pub fn write(&self, archive: &Archive) -> io::Result<()> {
        durable::replace(&self.target(), archive.to_text().as_bytes())
    }

    /// Renames the file, so that its contents can be examined, and returns the new name.
    ///
    /// # Errors
    /// The file cannot be renamed, or many have already been set aside; it then stays
    /// where it is.
    pub fn set_aside(&self) -> io::Result<PathBuf> {
        set_aside(&self.target())
    }

    /// Target of the path; a link remains one.
    fn target(&self) -> PathBuf {
        fs::canonicalize(&self.0).unwrap_or_else(|_| self.0.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appliance::aside::ASIDE;
    use tertius_core::sequential::{Dwell, StopReadings};
    use tertius_core::time::Timestamp;

    const NAME: &str = "a machine";

    fn archive(count: i64) -> Archive {
        let mut archive = Archive::new(NAME, 2);
        for k in 0..count {
            let dwell =
                Dwell { at: Timestamp::from_nanos(k), readings: StopReadings::both([0.1, 0.2]) };
            archive.cylinders[0].add(dwell);
        }
        archive
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("it is there");
        let name = |entry: io::Result<fs::DirEntry>| entry.expect("it is there").file_name();
        let mut names: Vec<_> =
            entries.map(|entry| name(entry).into_string().expect("UTF-8")).collect();
        names.sort();
        names
    }

    #[test]
    fn a_crash_while_it_is_written_leaves_the_old_one() {
        let folder = tempfile::tempdir().expect("there is room");
        let file = HistoryFile::new(folder.path().join("dwells"));
        assert!(matches!(file.read(NAME, 2), Ok(None)));
        file.write(&archive(3)).expect("the folder is ours");
        // The power failed in the middle of the next one.
        let half = &archive(9).to_text()[..100];
        fs::write(folder.path().join("dwells.new"), half).expect("the folder is ours");
        assert_eq!(file.read(NAME, 2).expect("it is whole"), Some(archive(3)));
        file.write(&archive(4)).expect("the folder is ours");
        assert_eq!(file.read(NAME, 2).expect("it is whole"), Some(archive(4)));
        assert_eq!(names(folder.path()), ["dwells"]);
    }

    #[test]
    fn what_cannot_be_written_harms_nothing() {
        let folder = tempfile::tempdir().expect("there is room");
        let file = HistoryFile::new(folder.path().join("dwells"));
        file.write(&archive(3)).expect("the folder is ours");
        // Nothing can be put in the place of a folder that is not empty.
        fs::create_dir_all(folder.path().join("dwells.new/kept")).expect("the folder is ours");
        assert!(file.write(&archive(4)).is_err());
        assert_eq!(file.read(NAME, 2).expect("it is whole"), Some(archive(3)));
        assert!(HistoryFile::new(folder.path().join("no/dwells")).write(&archive(1)).is_err());
        assert!(!folder.path().join("no").exists());
    }

    #[test]
    fn a_link_to_it_stays_one() {
        let folder = tempfile::tempdir().expect("there is room");
        let [real, link] = ["real", "link"].map(|name| folder.path().join(name));
        let file = HistoryFile::new(link.clone());
        fs::write(&real, "").expect("the folder is ours");
        std::os::unix::fs::symlink(&real, &link).expect("the folder is ours");
        file.write(&archive(3)).expect("the folder is ours");
        assert!(link.is_symlink() && real.is_file());
        assert_eq!(HistoryFile::new(real).read(NAME, 2).expect("whole"), Some(archive(3)));
    }

    #[test]
    fn what_is_set_aside_is_kept_and_bounded() {
        let folder = tempfile::tempdir().expect("there is room");
        let file = HistoryFile::new(folder.path().join("dwells"));
        for n in 1..=ASIDE {
            fs::write(file.path(), format!("damage {n}")).expect("the folder is ours");
            assert!(matches!(file.read(NAME, 2), Err(ReadError::Refused(_))));
            let aside = file.set_aside().expect("there is room");
            assert_eq!(fs::read_to_string(aside).expect("it is there"), format!("damage {n}"));
        }
        fs::write(file.path(), "damage").expect("the folder is ours");
        let told = file.set_aside().expect_err("there are enough").to_string();
        assert!(told.contains("8 are set aside already"), "{told}");
        assert_eq!(fs::read_to_string(file.path()).expect("it is there"), "damage");
        assert_eq!(names(folder.path()).len(), ASIDE + 1);
    }
}
