//! How long the parts of a recording may be.

/// Longest line that is read, bytes without its newline; candump's own stay below 400.
pub const MAX_LINE: usize = 1024;
/// Longest record that may be asked for whole, bytes. A longer one has to be taken in parts.
pub const MAX_RECORD: usize = 128 * 1024;
/// Longest interface name that is accepted; Linux itself allows 15 bytes.
pub const MAX_INTERFACE: usize = 64;
