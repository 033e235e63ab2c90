//! Files that cannot be used, renamed so that somebody can look at them.

use std::ffi::OsString;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Most files that are set aside; by then somebody should have looked.
pub(super) const ASIDE: usize = 8;

/// Renames the file `target`, and returns the new name.
///
/// # Errors
/// The file cannot be renamed, or many have already been set aside; it then stays where it is.
pub(super) fn set_aside(target: &Path) -> io::Result<PathBuf> {
    let names = (1..=ASIDE).map(|n| beside(target, &format!(".aside-{n}")));
    let mut free = names.filter(|name| fs::symlink_metadata(name).is_err());
    let Some(name) = free.next() else {
        let told = format!("{ASIDE} are set aside already; look at them and remove them");
        return Err(io::Error::new(ErrorKind::AlreadyExists, told));
    };
    fs::rename(target, &name)?;
    Ok(name)
}

/// The path with `suffix` after its name.
pub(super) fn beside(path: &Path, suffix: &str) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(suffix);
    name.into()
}
