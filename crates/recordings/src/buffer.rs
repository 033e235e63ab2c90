//! A bounded window on a stream of bytes.

use std::io;

use super::input::Input;
use super::limits::MAX_RECORD;

/// Size of the buffer: room for the longest record, or for the look-ahead of the time stamps' vote, and
/// for a read behind it; small enough to stay in a core's second-level cache.
const CAPACITY: usize = 256 * 1024;
/// Least free room for a read; below it the unread bytes are moved to the front first.
const LEAST_READ: usize = 64 * 1024;

const _: () = assert!(CAPACITY >= MAX_RECORD + LEAST_READ);

/// Bytes that were read and not yet consumed.
pub struct Buffer {
    bytes: Box<[u8]>,
    start: usize,
    end: usize,
    /// Number of bytes of the input before those in the buffer.
    before: u64,
    /// Whether the input has given its last byte.
    ended: bool,
}

impl Buffer {
    pub fn new() -> Self {
        let bytes = vec![0; CAPACITY].into_boxed_slice();
        Self { bytes, start: 0, end: 0, before: 0, ended: false }
    }

    /// Empties the buffer for the next input.
    pub fn restart(&mut self) {
        (self.start, self.end, self.before, self.ended) = (0, 0, 0, false);
    }

    #[inline(always)]
    pub fn unread(&self) -> &[u8] {
        &self.bytes[self.start..self.end]
    }

    pub fn ended(&self) -> bool {
        self.ended
    }

    #[inline(always)]
    pub fn consume(&mut self, length: usize) {
        self.start += length;
        debug_assert!(self.start <= self.end);
    }

    /// Number of bytes of the input that were consumed.
    pub fn consumed(&self) -> u64 {
        self.before + self.start as u64
    }

    /// Drops bytes up to the next newline; returns false if it is not there yet.
    pub fn drop_line(&mut self) -> bool {
        match memchr::memchr(b'\n', self.unread()) {
            Some(length) => {
                self.consume(length + 1);
                true
            }
            None => {
                self.start = self.end;
                false
            }
        }
    }

    /// Reads once from `input`. After an error the input counts as ended.
    ///
    /// # Errors
    /// The input's errors, except that it was interrupted.
    pub fn fill(&mut self, input: &mut Input) -> io::Result<()> {
        if self.bytes.len() - self.end < LEAST_READ {
            self.bytes.copy_within(self.start..self.end, 0);
            self.before += self.start as u64;
            (self.start, self.end) = (0, self.end - self.start);
        }
        match input.read(&mut self.bytes[self.end..]) {
            Ok(0) => self.ended = true,
            Ok(length) => self.end += length,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => {
                self.ended = true;
                return Err(error);
            }
        }
        Ok(())
    }
}
