//! A frame in the log form: `181#E02D`, `12345678##3…`, `123#R8`.

use tertius_core::frame::{Frame, Id, Kind, MAX_DATA};

use super::{Found, Reason};
use crate::format::is_fd_length;
use crate::formats::hex;
use crate::formats::token::token;

const MAX_CLASSIC: usize = 8;
/// CAN_ERR_FLAG of linux/can.h.
const ERROR_FLAG: u32 = 1 << 29;

/// Reads the frame and the flags that `-x` adds after it.
pub fn read(text: &[u8], frame: &mut Frame) -> Result<(), Reason> {
    let (word, rest) = token(text);
    let (direction, rest) = token(rest);
    if !matches!(direction, b"" | b"T" | b"R") {
        return Err(Reason::Trailing(Found::first(direction)));
    }
    if let (after @ [_, ..], _) = token(rest) {
        return Err(Reason::Trailing(Found::first(after)));
    }
    let hash = memchr::memchr(b'#', word).ok_or(Reason::NoFrame)?;
    let (id, is_error) = identifier(&word[..hash])?;
    let data = &word[hash + 1..];
    let kind = match data.first() {
        Some(b'R' | b'r') => Kind::Remote { length: remote_length(&data[1..])? },
        Some(b'#') => Kind::Fd { flags: fd_flags(&data[1..])? },
        _ if is_error => Kind::Error,
        _ => Kind::Data,
    };
    let length = match kind {
        _ if is_error && kind != Kind::Error => return Err(Reason::ErrorKind),
        Kind::Remote { .. } => 0,
        Kind::Fd { .. } => fd_data(&data[2..], frame.buffer_mut())?,
        Kind::Data | Kind::Error => classic_data(data, frame.buffer_mut())?,
    };
    (frame.id, frame.kind) = (id, kind);
    frame.set_length(length);
    Ok(())
}

/// An identifier, and whether it belongs to an error frame.
pub fn identifier(digits: &[u8]) -> Result<(Id, bool), Reason> {
    match digits.len() {
        3 | 8 => {}
        // Virtual network and priority.
        5 => return Err(Reason::Xl),
        length => return Err(Reason::IdentifierLength(length)),
    }
    let value = hex::number(digits).map_err(|byte| Reason::IdentifierDigit(Found(Some(byte))))?;
    if digits.len() == 3 {
        return Ok((Id::standard(value).ok_or(Reason::StandardRange(value))?, false));
    }
    let is_error = value & ERROR_FLAG != 0;
    let id = Id::extended(value & !ERROR_FLAG).ok_or(Reason::ExtendedRange(value))?;
    Ok((id, is_error))
}

fn fd_flags(text: &[u8]) -> Result<u8, Reason> {
    let flags = text.first().and_then(|&byte| hex::digit(byte));
    flags.ok_or(Reason::FdFlags(Found::first(text)))
}

/// The length after `R`: absent, a digit, or 8 with a raw length code.
fn remote_length(text: &[u8]) -> Result<u8, Reason> {
    match text {
        [] => Ok(0),
        [length @ b'0'..=b'8'] => Ok(length - b'0'),
        [b'8', b'_', raw @ ..] => raw_length(raw).map(|()| 8),
        [b'0'..=b'8', rest @ ..] => Err(Reason::Trailing(Found::first(rest))),
        _ => Err(Reason::RemoteLength(Found::first(text))),
    }
}

/// The data length code that the controller saw; the frame still has 8 bytes.
fn raw_length(text: &[u8]) -> Result<(), Reason> {
    match text {
        [b'9' | b'A'..=b'F' | b'a'..=b'f'] => Ok(()),
        [b'9' | b'A'..=b'F' | b'a'..=b'f', rest @ ..] => Err(Reason::Trailing(Found::first(rest))),
        _ => Err(Reason::RawLength(Found::first(text))),
    }
}

fn fd_data(text: &[u8], bytes: &mut [u8; MAX_DATA]) -> Result<usize, Reason> {
    let (length, rest) = data(text, bytes, MAX_DATA)?;
    match rest.first() {
        Some(byte) if byte.is_ascii_hexdigit() => Err(Reason::FdTooLong),
        Some(_) => Err(Reason::DataDigit(Found::first(rest))),
        None if !is_fd_length(length) => Err(Reason::FdLength(length)),
        None => Ok(length),
    }
}

fn classic_data(text: &[u8], bytes: &mut [u8; MAX_DATA]) -> Result<usize, Reason> {
    let (length, rest) = data(text, bytes, MAX_CLASSIC)?;
    match rest.first() {
        None => Ok(length),
        Some(b'_') if length == MAX_CLASSIC => raw_length(&rest[1..]).map(|()| length),
        Some(b'_') => Err(Reason::RawLength(Found(Some(b'_')))),
        Some(byte) if byte.is_ascii_hexdigit() => Err(Reason::ClassicLength),
        Some(_) => Err(Reason::DataDigit(Found::first(rest))),
    }
}

/// Reads up to `limit` bytes, each optionally preceded by a point, and returns their number and the
/// text after them. As in can-utils a final point may follow.
fn data<'a>(
    mut text: &'a [u8],
    bytes: &mut [u8; MAX_DATA],
    limit: usize,
) -> Result<(usize, &'a [u8]), Reason> {
    for (count, byte) in bytes.iter_mut().take(limit).enumerate() {
        text = text.strip_prefix(b".").unwrap_or(text);
        let Some((&first, rest)) = text.split_first() else { return Ok((count, text)) };
        let Some(high) = hex::digit(first) else { return Ok((count, text)) };
        let (low, rest) = match rest.split_first() {
            None | Some((b'.' | b'_', _)) => return Err(Reason::HalfByte),
            Some((&second, rest)) => (second, rest),
        };
        *byte = high << 4 | hex::digit(low).ok_or(Reason::DataDigit(Found(Some(low))))?;
        text = rest;
    }
    Ok((limit, text.strip_prefix(b".").unwrap_or(text)))
}
