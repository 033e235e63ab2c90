//! Compressed data blocks.

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::block::{Block, Flaw, number};

/// Most bytes that a block may have when it is unpacked. Writers are told to stay below 4 MiB.
const MOST: u64 = 16 << 20;
/// Bytes before the compressed ones.
const HEAD: usize = 24;

/// Unpacks a DZ block; returns the kind of block that was packed, and its data.
pub fn unpack(file: &[u8], block: &Block<'_>) -> Result<([u8; 2], Vec<u8>), Flaw> {
    let (at, data) = (block.data_at(), block.data);
    let short = Flaw::expected(file, at, "the head of compressed data");
    let kind = *data.first_chunk().ok_or(short)?;
    let columns = number(data, 4, 4).ok_or(short)?;
    let length = number(data, 8, 8).ok_or(short)?;
    let packed = number(data, 16, 8).ok_or(short)?;
    if length > MOST {
        return Err(Flaw::told(at + 8, "compressed data of more than 16 MiB in one block"));
    }
    let packed = usize::try_from(packed).ok().and_then(|packed| data[HEAD..].get(..packed));
    let cut = Flaw::expected(file, at + 16, "as many compressed bytes as the block announces");
    let packed = packed.ok_or(cut)?;
    let method = data.get(2).copied().unwrap_or(u8::MAX);
    if method > 1 {
        return Err(Flaw::expected(file, at + 2, "compression by zlib, 0 or 1 (transposed)"));
    }
    let mut bytes = Vec::new();
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
