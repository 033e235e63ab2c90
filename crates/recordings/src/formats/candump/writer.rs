//! Writes frames as lines of `candump -l`.

use std::io::{self, Write};

use crate::encoder::{FrameEncoder, Unsayable};
use tertius_core::frame::{Frame, Kind};

const NANOS_PER_SECOND: u64 = 1_000_000_000;
/// CAN_ERR_FLAG of linux/can.h.
const ERROR_FLAG: u32 = 1 << 29;
const DIGITS: &[u8; 16] = b"0123456789ABCDEF";

/// Writes frames as a recording that [`crate::Recording`], canplayer and others can read.
pub struct LogWriter<W> {
    out: W,
    interface: String,
    line: Vec<u8>,
}

impl<W: Write> LogWriter<W> {
    /// `out` should be buffered: each frame is one write. `interface` is the name in every line,
    /// such as `can0`; without blanks.
    pub fn new(out: W, interface: &str) -> Self {
        Self { out, interface: interface.to_owned(), line: Vec::with_capacity(192) }
    }

    /// Writes one line.
    ///
    /// # Errors
    /// Errors of `out`.
    pub fn write(&mut self, frame: &Frame) -> io::Result<()> {
        self.line.clear();
        append_log_line(&mut self.line, &self.interface, frame);
        self.out.write_all(&self.line)
    }

    /// Flushes `out`.
    ///
    /// # Errors
    /// Errors of `out`.
    pub fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }

    /// The writer underneath.
    pub fn into_inner(self) -> W {
        self.out
    }
}

/// The encoder of a log.
pub struct LogEncoder;

impl FrameEncoder for LogEncoder {
    fn add(
        &mut self,
        interface: &str,
        frame: &Frame,
        bytes: &mut Vec<u8>,
    ) -> Result<(), Unsayable> {
        append_log_line(bytes, interface, frame);
        Ok(())
    }
}

/// Appends the frame's line with its newline: with six decimals where they are exact, else nine.
///
/// Reading the line gives the same frame, if a bus can carry it: at most 8 bytes in a classic
/// frame, a CAN FD length, flags up to 15, at most 8 bytes requested by a remote frame. An error
/// frame's identifier is always read as extended: candump writes it with eight digits.
pub fn append_log_line(line: &mut Vec<u8>, interface: &str, frame: &Frame) {
    append_stamp(line, frame.timestamp.as_nanos());
    line.extend_from_slice(interface.as_bytes());
    line.push(b' ');
    let id = frame.id.value();
    match frame.kind {
        Kind::Error => append_hex(line, id | ERROR_FLAG, 8),
        _ if frame.id.is_extended() => append_hex(line, id, 8),
        _ => append_hex(line, id, 3),
    }
    line.push(b'#');
    match frame.kind {
        Kind::Data | Kind::Error => {}
        Kind::Fd { flags } => line.extend([b'#', DIGITS[usize::from(flags & 0xF)]]),
        Kind::Remote { length } => {
            line.push(b'R');
            if length > 0 {
                line.push(DIGITS[usize::from(length & 0xF)]);
            }
            line.push(b'\n');
            return;
        }
    }
    for byte in frame.data() {
        line.extend([DIGITS[usize::from(byte >> 4)], DIGITS[usize::from(byte & 0xF)]]);
    }
    line.push(b'\n');
}

/// Appends `(1700000000.000516) `; at least ten digits of seconds mark an absolute time.
fn append_stamp(line: &mut Vec<u8>, nanos: i64) {
    let size = nanos.unsigned_abs();
    let (seconds, fraction) = (size / NANOS_PER_SECOND, size % NANOS_PER_SECOND);
    line.push(b'(');
    if nanos < 0 {
        line.push(b'-');
    }
    append_decimal(line, seconds, 10);
    line.push(b'.');
    if fraction % 1000 == 0 {
        append_decimal(line, fraction / 1000, 6);
    } else {
        append_decimal(line, fraction, 9);
    }
    line.extend_from_slice(b") ");
}

/// Appends the last `digits` decimal digits; seconds of an `i64` of nanoseconds never have more
/// than ten.
fn append_decimal(line: &mut Vec<u8>, mut value: u64, digits: usize) {
    let start = line.len();
    line.resize(start + digits, b'0');
    for place in line[start..].iter_mut().rev() {
        *place = b'0' + (value % 10) as u8;
        value /= 10;
    }
}

fn append_hex(line: &mut Vec<u8>, value: u32, digits: u32) {
    for place in (0..digits).rev() {
        line.push(DIGITS[(value >> (4 * place)) as usize & 0xF]);
    }
}
