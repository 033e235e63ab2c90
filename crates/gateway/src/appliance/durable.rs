//! Files that are whole whenever the power fails.

use super::aside::beside;
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::Path;

/// Replaces the file `path` by one with `content`, atomically: at any time it is this one or the one before.
///
/// # Errors
/// The file cannot be written; the one before then remains.
pub(super) fn replace(path: &Path, content: &[u8]) -> io::Result<()> {
    // Always the same name, so that crashes do not heap them up.
    let beside = beside(path, ".new");
    match fs::remove_file(&beside) {
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let written = put(&beside, content).and_then(|()| fs::rename(&beside, path));
    if let Err(error) = written {
        // What could not be written whole is of no use to anybody.
        _ = fs::remove_file(&beside);
        return Err(error);
    }
    File::open(folder(path))?.sync_all()
}

fn put(path: &Path, content: &[u8]) -> io::Result<()> {
    let mut file = OpenOptions::new().write(true).create_new(true).open(path)?;
    file.write_all(content)?;
    file.sync_all()
}

fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}
