//! AUTOSAR E2E Profile 5, by which a receiver checks that a frame is intact, of the right kind and
//! fresh.
//!
//! Bytes 0–1 hold a CRC-16/CCITT-FALSE, little-endian, over bytes 2.. and then the data ID, low
//! byte first. Byte 2 holds a counter that rises by one with each frame of the data ID, modulo 256.
//! The data ID is never sent, so that a frame taken for another fails the check. Source: AUTOSAR
//! *Specification of SW-C End-to-End Communication Protection Library*, profile 5, with offset 0.

use crc::{CRC_16_IBM_3740, Crc};
use thiserror::Error;

/// Length of CRC and counter before the payload, bytes.
pub const HEADER: usize = 3;

/// CRC-16/CCITT-FALSE, which is the catalogue's IBM-3740: polynomial 0x1021, start 0xFFFF, not
/// reflected.
const CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);

/// Why a frame is rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum E2eError {
    #[error(
        "{length} bytes are too few for E2E profile 5, whose CRC and counter alone take {HEADER}"
    )]
    TooShort { length: usize },
    #[error(
        "the CRC in bytes 0-1 is 0x{found:04X}, but the data make it 0x{expected:04X}: the frame \
         was damaged, or sent under another data ID"
    )]
    Crc { found: u16, expected: u16 },
}

/// Writes `counter` and then the CRC into the first [`HEADER`] bytes of `frame`.
///
/// # Panics
/// `frame` is shorter than [`HEADER`]: a bug of the caller, not bad input.
pub fn protect(frame: &mut [u8], data_id: u16, counter: u8) {
    assert!(frame.len() >= HEADER, "a frame under E2E profile 5 has at least {HEADER} bytes");
    frame[2] = counter;
    let crc = checksum(&frame[2..], data_id);
    frame[..2].copy_from_slice(&crc.to_le_bytes());
}

/// The counter of a frame whose CRC is right.
///
/// # Errors
/// [`E2eError::TooShort`] if the frame has no room for the header, [`E2eError::Crc`] if
/// the CRC is wrong.
pub fn check(frame: &[u8], data_id: u16) -> Result<u8, E2eError> {
    let &[low, high, counter, ..] = frame else {
        return Err(E2eError::TooShort { length: frame.len() });
    };
    let found = u16::from_le_bytes([low, high]);
    let expected = checksum(&frame[2..], data_id);
    if found == expected { Ok(counter) } else { Err(E2eError::Crc { found, expected }) }
}

fn checksum(counter_and_payload: &[u8], data_id: u16) -> u16 {
    let mut digest = CRC.digest();
    digest.update(counter_and_payload);
    digest.update(&data_id.to_le_bytes());
    digest.finalize()
}
