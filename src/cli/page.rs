//! Pages of HTML on disk: whole, or as they were before.

use super::Failure;
use std::fs::{self, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use tempfile::{Builder, NamedTempFile};

/// Where a page goes once everything has been read.
#[derive(Debug)]
pub struct PageFile {
    /// As it was named.
    named: PathBuf,
    /// What it leads to; a link stays one.
    path: PathBuf,
    /// A pipe or a device: nothing can be put beside it, and nothing of it can be lost.
    direct: bool,
}

impl PageFile {
    /// Makes sure that a page can be written to `path` before the work is done, without touching
    /// what is there.
    ///
    /// # Errors
    /// It cannot.
    pub fn prepare(path: &Path) -> Result<Self, Failure> {
        let fail = |error| Failure::creating(path, &error);
        let kind = fs::metadata(path).ok();
        if kind.as_ref().is_some_and(fs::Metadata::is_dir) {
            return Err(fail(io::Error::from(io::ErrorKind::IsADirectory)));
        }
        let direct = kind.is_some_and(|kind| !kind.is_file());
        let page = Self {
            named: path.to_owned(),
            path: fs::canonicalize(path).unwrap_or_else(|_| path.to_owned()),
            direct,
        };
        if !direct {
            page.beside().map_err(fail)?;
        }
        Ok(page)
    }

    /// Puts `html` there at once.
    ///
    /// # Errors
    /// It cannot be written; then what was there still is.
    pub fn write(&self, html: &str) -> Result<(), Failure> {
        let fail = |error| Failure::writing(&self.named.display().to_string(), &error);
        if self.direct {
            return fs::write(&self.path, html).map_err(fail);
        }
        let mut file = self.beside().map_err(fail)?;
        file.write_all(html.as_bytes()).map_err(fail)?;
        file.persist(&self.path).map_err(|error| fail(error.error))?;
        Ok(())
    }

    /// A file in the same folder that goes away by itself unless it takes the page's place.
    fn beside(&self) -> io::Result<NamedTempFile> {
        let folder = self.path.parent().filter(|folder| !folder.as_os_str().is_empty());
        // As any new file, less what the umask takes.
        let permissions = Permissions::from_mode(0o666);
        let mut builder = Builder::new();
        builder.prefix(".tertius-").suffix(".html").permissions(permissions);
        builder.tempfile_in(folder.unwrap_or(Path::new(".")))
    }
}
