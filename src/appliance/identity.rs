//! Which configuration is in force.

use crate::config::Loaded;
use crc::{CRC_64_XZ, Crc};

const CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_XZ);

/// Identity of a configuration: 16 hexadecimal digits over the bytes of the file, its DBC and its EDS files.
/// It tells configurations apart, and is no protection against forgery.
pub fn of(loaded: &Loaded) -> String {
    let mut digest = CRC.digest();
    let text = loaded.document.text().as_bytes();
    // With its length, so that no byte can move from one file to the next unnoticed.
    for part in [text, &loaded.layout()] {
        digest.update(&(part.len() as u64).to_le_bytes());
        digest.update(part);
    }
    format!("{:016x}", digest.finalize())
}
