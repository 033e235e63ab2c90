//! Bytes of a state, written and read in order.

use super::error::StateError;
use alloc::vec::Vec;

/// Collects the bytes of a state.
#[derive(Clone, Debug, Default)]
pub struct StateWriter {
    bytes: Vec<u8>,
}

impl StateWriter {
    /// A writer with room for so many bytes; it grows beyond them.
    pub fn with_capacity(bytes: usize) -> Self {
        Self { bytes: Vec::with_capacity(bytes) }
    }

    /// Appends bytes of a known number.
    #[inline]
    pub fn put<const N: usize>(&mut self, bytes: [u8; N]) {
        self.bytes.extend_from_slice(&bytes);
    }

    /// Appends `bytes`, whose number is not.
    pub fn put_all(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }

    /// All bytes that were put.
    pub fn finish(self) -> Vec<u8> {
        self.bytes
    }
}

/// The bytes of a state that are still to be read.
#[derive(Clone, Debug)]
pub struct StateReader<'a> {
    rest: &'a [u8],
}

impl<'a> StateReader<'a> {
    pub const fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    /// The next `N` bytes.
    ///
    /// # Errors
    /// There are fewer.
    #[inline]
    pub fn take<const N: usize>(&mut self) -> Result<[u8; N], StateError> {
        let (taken, rest) = self.rest.split_first_chunk().ok_or(StateError::Short)?;
        self.rest = rest;
        Ok(*taken)
    }

    /// The next `length` bytes.
    ///
    /// # Errors
    /// There are fewer.
    pub const fn take_all(&mut self, length: usize) -> Result<&'a [u8], StateError> {
        let Some((taken, rest)) = self.rest.split_at_checked(length) else {
            return Err(StateError::Short);
        };
        self.rest = rest;
        Ok(taken)
    }

    /// Ends the reading.
    ///
    /// # Errors
    /// There are bytes left.
    pub const fn finish(self) -> Result<(), StateError> {
        if self.rest.is_empty() { Ok(()) } else { Err(StateError::Long) }
    }
}
