//! What was read on the stops, on disk: it lives longer than the gateway.

mod file;
mod keeper;
mod worker;

pub use file::{HistoryFile, ReadError};
pub use keeper::{Keeper, Kept};
