//! Compressed data blocks.

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::block::{Block, Flaw, number};
use crate::reason::Reason;

/// Most bytes that a block may have when it is unpacked. Writers are told to stay below 4 MiB.
const MOST: u64 = 16 << 20;
/// Most bytes of all unpacked blocks of a file: each place that is read holds one.
const MOST_OF_ALL: u64 = 128 << 20;

/// How long a block may be when it is unpacked.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    /// Number of places at which the file is read.
    places: usize,
    /// Most bytes of a block at each.
    most: u64,
}

impl Room {
    /// The room in a file that is read at so many places.
    pub fn of(places: usize) -> Self {
        Self { places, most: MOST.min(MOST_OF_ALL / places.max(1) as u64) }
    }
}
/// Bytes before the compressed ones.
const HEAD: usize = 24;

/// Unpacks a DZ block; returns the kind of block that was packed, and its data.
pub fn unpack(file: &[u8], block: &Block<'_>, room: Room) -> Result<([u8; 2], Vec<u8>), Flaw> {
    let (at, data) = (block.data_at(), block.data);
    let short = Flaw::expected(file, at, "the head of compressed data");
    let kind = *data.first_chunk().ok_or(short)?;
    let columns = number(data, 4, 4).ok_or(short)?;
    let length = number(data, 8, 8).ok_or(short)?;
    let packed = number(data, 16, 8).ok_or(short)?;
    let Room { places, most } = room;
    if length > most {
        return Err(Flaw::of(at + 8, Reason::UnpackedTooLong { found: length, most, places }));
    }
    let packed = usize::try_from(packed).ok().and_then(|packed| data[HEAD..].get(..packed));
    let cut = Flaw::expected(file, at + 16, "as many compressed bytes as the block announces");
    let packed = packed.ok_or(cut)?;
    let method = data.get(2).copied().unwrap_or(u8::MAX);
    if method > 1 {
        return Err(Flaw::expected(file, at + 2, "compression by zlib, 0 or 1 (transposed)"));
    }
    // No more than it says, whatever comes.
    let mut bytes = Vec::with_capacity(length as usize);
    let read = ZlibDecoder::new(packed).take(length).read_to_end(&mut bytes);
    if read.is_err() || bytes.len() as u64 != length {
        return Err(Flaw::expected(
            file,
            at + HEAD as u64,
            "data that zlib unpacks to their length",
        ));
    }
    Ok((kind, if method == 1 { transposed(&bytes, columns as usize) } else { bytes }))
}

/// Rows of bytes out of `columns` that were stored one after the other. What fills no row stands at the end as it is.
fn transposed(bytes: &[u8], columns: usize) -> Vec<u8> {
    let rows = bytes.len().checked_div(columns).unwrap_or(0);
    let (stored, rest) = bytes.split_at(rows * columns);
    let mut turned = Vec::with_capacity(bytes.len());
    for row in 0..rows {
        turned.extend((0..columns).map(|column| stored[column * rows + row]));
    }
    turned.extend_from_slice(rest);
    turned
}
