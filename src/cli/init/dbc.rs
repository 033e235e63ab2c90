//! The DBC of a machine that has no configuration yet.

use crate::config::MAX_DBC_SIZE;
use crate::dbc::{Database, text};
use crate::failure::Failure;
use std::fs::File;
use std::io::Read as _;
use std::path::{Component, Path, PathBuf};

/// Reads the DBC `path`.
///
/// # Errors
/// It cannot be read or is no DBC.
pub fn read(path: &Path) -> Result<Database, Failure> {
    let wrong = |why: String| Failure::Wrong(format!("{}: {why}", path.display()));
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(|error| wrong(format!("cannot be read: {error}")))?;
    file.take(MAX_DBC_SIZE as u64 + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| wrong(format!("cannot be read: {error}")))?;
    if bytes.len() > MAX_DBC_SIZE {
        return Err(wrong(format!("longer than {MAX_DBC_SIZE} bytes; is this the right file?")));
    }
    Database::parse(&text::from_bytes(&bytes))
        .map_err(|error| wrong(format!("{error}; the first file is the DBC, recordings follow")))
}

/// The path of a file from a folder, as a configuration in that folder names it.
pub fn relative(path: &Path, folder: &Path) -> String {
    let real = |path: &Path| std::fs::canonicalize(path).ok();
    let (Some(path), Some(folder)) = (real(path), real(folder)) else {
        return path.display().to_string();
    };
    let same = path.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    // Only the root in common: the whole path says more.
    if same <= 1 {
        return path.display().to_string();
    }
    let up = folder.components().skip(same).map(|_| Component::ParentDir);
    up.chain(path.components().skip(same)).collect::<PathBuf>().display().to_string()
}
