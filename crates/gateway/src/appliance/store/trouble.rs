//! Why the store cannot be used.

use rusqlite::ErrorCode;
use std::io;
use thiserror::Error;

/// Why the store cannot be opened, written or read.
#[derive(Debug, Error)]
pub enum Trouble {
    #[error("another process has locked it")]
    Locked,
    #[error("another gateway keeps its events there; each needs a file of its own")]
    Owned,
    #[error("there is no room on the disk, or within `store.size`")]
    Full,
    #[error("it is damaged ({0})")]
    Corrupt(String),
    #[error(
        "it is of version {found}, and this program knows versions up to {known}; run the newer \
         program, or name another file"
    )]
    Newer { found: i32, known: usize },
    #[error("it is of version {0}; a running gateway brings it up to date")]
    Older(usize),
    #[error("nothing has been written to it yet")]
    Empty,
    #[error("it is a database of another program; name another file")]
    Foreign,
    #[error("what was read cannot be written: {0}")]
    Output(#[from] io::Error),
    #[error("{0}")]
    Other(String),
}

impl From<rusqlite::Error> for Trouble {
    fn from(error: rusqlite::Error) -> Self {
        match error.sqlite_error_code() {
            Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked) => Self::Locked,
            Some(ErrorCode::DiskFull) => Self::Full,
            Some(ErrorCode::DatabaseCorrupt | ErrorCode::NotADatabase) => {
                Self::Corrupt(error.to_string())
            }
            _ => Self::Other(error.to_string()),
        }
    }
}
