//! The readings on the stops, on disk, where they outlive the gateway.

mod file;
mod keeper;
mod worker;

pub use file::{HistoryFile, ReadError};
pub use keeper::{Keeper, Kept};
