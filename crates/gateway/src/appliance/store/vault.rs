//! The open database, and the lock by which only one gateway writes it.

use super::plan::StorePlan;
use super::schema;
use super::trouble::Trouble;
use crate::appliance::aside::{self, beside};
use rusqlite::Connection;
use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use tracing::info;

/// A database that is open to write.
#[derive(Debug)]
pub(super) struct Vault {
    pub database: Connection,
    /// Held as long as it is open. It is a file of its own: SQLite's locks end when anyone in the process closes the
    /// database.
    _lock: File,
}

impl Vault {
    /// Opens the database of `plan`, or makes it.
    ///
    /// # Errors
    /// Why it cannot be written.
    pub fn open(plan: &StorePlan) -> Result<Self, Trouble> {
        let lock = lock(&plan.path)?;
        let database = schema::open(&plan.path, plan.size)?;
        info!("the event store is {}", plan.path.display());
        Ok(Self { database, _lock: lock })
    }

    /// Whether the run `run` is in it: the file may be another one than before.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn knows(&self, run: i64) -> Result<bool, Trouble> {
        let sql = "SELECT count(*) FROM runs WHERE id = ?";
        Ok(self.database.query_row(sql, [run], |row| row.get::<_, i64>(0))? > 0)
    }

    /// Changes the size that it keeps to, bytes.
    pub fn limit(&mut self, size: u64) {
        // Where it fails, the old one holds until the next start.
        _ = schema::limit(&self.database, size, 0);
    }

    /// Renames a database that cannot be used, with its log, and returns the new name.
    ///
    /// # Errors
    /// It cannot be renamed.
    pub fn set_aside(path: &Path) -> io::Result<PathBuf> {
        let name = aside::set_aside(path)?;
        // The log has what the database does not have yet. There may be none.
        _ = fs::rename(beside(path, "-wal"), beside(&name, "-wal"));
        _ = fs::remove_file(beside(path, "-shm"));
        Ok(name)
    }
}

fn lock(path: &Path) -> Result<File, Trouble> {
    let path = beside(path, ".lock");
    let file = OpenOptions::new().create(true).truncate(false).write(true).open(&path);
    let file = file.map_err(|error| Trouble::Other(format!("{}: {error}", path.display())))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(fs::TryLockError::WouldBlock) => Err(Trouble::Owned),
        Err(fs::TryLockError::Error(error)) => Err(Trouble::Other(error.to_string())),
    }
}
