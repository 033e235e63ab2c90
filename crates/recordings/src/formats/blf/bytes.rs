//! Numbers in a log, least byte first, and how long its heads are.

use crate::reason::{Found, Reason};

/// Bytes of the head that are read.
pub(super) const FILE_HEAD: usize = 72;
/// Bytes of a container before its data.
pub(super) const CONTAINER_HEAD: usize = 32;

pub(super) fn expected(bytes: &[u8], expected: &'static str) -> Reason {
    Reason::Expected { found: Found::first(bytes), expected }
}

pub(super) fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..).and_then(<[u8]>::first_chunk).map(|bytes| u32::from_le_bytes(*bytes))
}

pub(super) fn u64_at(bytes: &[u8], at: usize) -> Option<u64> {
    bytes.get(at..).and_then(<[u8]>::first_chunk).map(|bytes| u64::from_le_bytes(*bytes))
}

pub(super) fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..).and_then(<[u8]>::first_chunk).map(|bytes| u16::from_le_bytes(*bytes))
}
