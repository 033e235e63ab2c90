//! Parses, checks and compiles the text of a DBC file into bit plans.
//!
//! [`Database::parse`] returns messages that are known to be sound, and [`Finding`]s about the
//! rest. Nothing here reads files; [`text::from_bytes`] turns the bytes of a file into text.

mod check;
mod collect;
mod database;
mod device;
mod draft;
mod finding;
mod lookup;
mod message;
mod multiplex;
mod parse_error;
mod statement;
mod syntax;
pub mod text;

pub use database::Database;
pub use device::{DeviceMessages, DeviceServices, IdTaken};
pub use finding::{Concern, Finding, Severity};
pub use lookup::LookupError;
pub use message::{Message, Signal};
pub use parse_error::ParseError;

/// The longest DBC text that is read, in bytes.
pub const MAX_TEXT: usize = 16 << 20;
/// The longest statement (a message with its signals, a value table), in bytes.
pub const MAX_STATEMENT: usize = 1 << 20;
/// The most messages that a DBC may have.
pub const MAX_MESSAGES: usize = 8192;
/// The most signals of one message.
pub const MAX_SIGNALS_PER_MESSAGE: usize = 2048;
/// The most signals of a whole DBC.
pub const MAX_SIGNALS: usize = 65_536;
/// The longest name of a message or signal, in bytes; the format's own limit is 32.
pub const MAX_NAME: usize = 128;
/// The most multiplexors on the way to one signal.
pub const MAX_MULTIPLEX_DEPTH: usize = 8;
/// The most value ranges of one `SG_MUL_VAL_`.
pub const MAX_MULTIPLEX_RANGES: usize = 1024;
/// The most findings that are kept; further ones are counted.
pub const MAX_FINDINGS: usize = 1000;
