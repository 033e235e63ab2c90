//! The file of frames kept of healthy recordings, beside the configuration.

use super::Failure;
use super::files::folder;
use crate::learnt::archive::{MAX_SIZE, Refusal};
use crate::learnt::{Learnt, Seals};
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

/// Path of the file.
#[derive(Clone, Debug)]
pub struct LearntFile(PathBuf);

/// A file written beside, which takes its place when the configuration has its tables.
#[derive(Debug)]
#[must_use]
pub struct Prepared(LearntFile);

impl LearntFile {
    /// The file of a configuration: `e-type.learnt` of `e-type.toml`.
    pub fn beside(config: &Path) -> Self {
        Self(config.with_extension("learnt"))
    }

    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Reads what is kept of the machine with these `seals`, all of them or only those of a
    /// calibration; `None` where there is no file yet.
    ///
    /// # Errors
    /// The file belongs to other tables, or is something else; it stays untouched.
    pub fn read(&self, seals: &Seals, all: bool) -> Result<Option<Learnt>, Failure> {
        let agrees = |learnt: &Learnt| learnt.seals.agree(seals, all);
        let there = read(&self.0).map_err(|error| self.unreadable(&error))?;
        if let Some(Ok(learnt)) = &there
            && agrees(learnt).is_ok()
        {
            return there.transpose().map_err(|refusal| self.wrong(&refusal));
        }
        // A run ended after the configuration was written, and before this was.
        let interrupted = read(&self.new_path()).ok().flatten().and_then(Result::ok);
        if let Some(learnt) = interrupted.filter(|learnt| agrees(learnt).is_ok()) {
            tell!(
                "the last run was interrupted after {} had its tables; its data are used",
                self.0.with_extension("toml").display()
            );
            return Ok(Some(learnt));
        }
        match there {
            None => Ok(None),
            Some(Err(refusal)) => Err(self.wrong(&refusal)),
            Some(Ok(learnt)) => agrees(&learnt).map(|()| None).map_err(|broken| {
                Failure::Wrong(format!(
                    "{} does not belong to this configuration: {broken}. What was learnt under other \
                     tables is not mixed with these. Restore the previous configuration (a copy is \
                     kept beside it) and give the same values by --set and TERTIUS_ variables, or start \
                     again with this recording (--update --fresh)",
                    self.0.display()
                ))
            }),
        }
    }

    /// Checks that the file may be started again.
    ///
    /// # Errors
    /// The file is something else, which must not be overwritten.
    pub fn is_ours(&self) -> Result<(), Failure> {
        match read(&self.0).map_err(|error| self.unreadable(&error))? {
            Some(Err(refusal @ Refusal::Foreign)) => Err(self.wrong(&refusal)),
            _ => Ok(()),
        }
    }

    /// Writes the file beside the present one.
    ///
    /// # Errors
    /// The file cannot be written; nothing has changed then.
    pub fn prepare(self, learnt: &Learnt) -> Result<Prepared, Failure> {
        let path = self.new_path();
        put(&path, &learnt.to_bytes())
            .map_err(|error| Failure::writing_file(&path.display().to_string(), &error))?;
        Ok(Prepared(self))
    }

    fn new_path(&self) -> PathBuf {
        self.0.with_extension("learnt.new")
    }

    fn unreadable(&self, error: &io::Error) -> Failure {
        Failure::Wrong(format!("{} cannot be read: {error}", self.0.display()))
    }

    fn wrong(&self, refusal: &Refusal) -> Failure {
        let path = self.0.display();
        Failure::Wrong(format!(
            "{path}: {refusal}. Nothing was changed; move it away, or, if it was damaged, start \
             again with this recording (--update --fresh)"
        ))
    }
}

impl Prepared {
    /// Puts the file in its place.
    ///
    /// # Errors
    /// The file cannot be renamed; the next run finds it beside.
    pub fn settle(self) -> Result<(), Failure> {
        let Self(file) = self;
        let settled = fs::rename(file.new_path(), &file.0)
            .and_then(|()| File::open(folder(&file.0))?.sync_all());
        settled.map_err(|error| Failure::writing_file(&file.0.display().to_string(), &error))
    }
}

/// The content of `path`; `None` where there is no file.
fn read(path: &Path) -> io::Result<Option<Result<Learnt, Refusal>>> {
    let file = match File::open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error),
    };
    let mut bytes = Vec::new();
    file.take(MAX_SIZE as u64 + 1).read_to_end(&mut bytes)?;
    Ok(Some(Learnt::parse(&bytes)))
}

fn put(path: &Path, bytes: &[u8]) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let mut file = OpenOptions::new().write(true).create_new(true).open(path)?;
    file.write_all(bytes)?;
    file.sync_all()
}
