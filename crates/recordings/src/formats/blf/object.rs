//! The objects of a BLF, and the frames in them.

use super::bytes::{expected, u16_at, u32_at};
use crate::format::is_fd_length;
use crate::reason::Reason;
use tertius_core::frame::{Frame, Id, Kind, MAX_DATA};
use tertius_core::time::Timestamp;

/// What every object begins with.
pub const OBJECT: &[u8; 4] = b"LOBJ";

/// Types of objects.
pub const CONTAINER: u32 = 10;
pub const MESSAGE: u32 = 1;
const ERROR: u32 = 2;
pub const ERROR_EXTENDED: u32 = 73;
const MESSAGE_2: u32 = 86;
pub const FD_MESSAGE: u32 = 100;
const FD_MESSAGE_64: u32 = 101;

pub const EXTENDED: u32 = 1 << 31;
const IDENTIFIER: u32 = (1 << 29) - 1;
/// Flag of classic messages and of [`FD_MESSAGE`].
pub const REMOTE: u8 = 0x80;
/// Flags of [`FD_MESSAGE`]: it is of CAN FD, bit rate switch, error state.
pub const FD: u8 = 1;
pub const BRS: u8 = 2;
pub const ESI: u8 = 4;
/// The same of [`FD_MESSAGE_64`], and that it is a remote frame.
const REMOTE_64: u32 = 0x10;
const FD_64: u32 = 0x1000;
const BRS_64: u32 = 0x2000;
const ESI_64: u32 = 0x4000;
/// The flag of time stamps in tens of microseconds; others are in nanoseconds.
const TEN_MICROSECONDS: u32 = 1;
/// Class of error frames in linux/can/error.h: a fault on the bus.
const BUS_ERROR: u32 = 0x080;

/// The head that all objects have.
#[derive(Clone, Copy, Debug)]
pub struct ObjectHead {
    /// Version of the rest of the head: 1 or 2.
    version: u16,
    /// Length of the whole object.
    pub length: usize,
    pub kind: u32,
}

impl ObjectHead {
    pub const LENGTH: usize = 16;

    /// The head with which `bytes` begin; `None` if there are too few.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        let bytes = bytes.get(..Self::LENGTH)?;
        let (length, kind) = (u32_at(bytes, 8)? as usize, u32_at(bytes, 12)?);
        Some(Self { version: u16_at(bytes, 6)?, length, kind })
    }

    /// Whether it is a frame.
    pub fn is_can(&self) -> bool {
        let kinds = [MESSAGE, ERROR, ERROR_EXTENDED, MESSAGE_2, FD_MESSAGE, FD_MESSAGE_64];
        kinds.contains(&self.kind)
    }
}

/// Reads a whole object into `frame`; returns its channel, or `None` if it is no frame that is known.
pub fn read(
    object: &[u8],
    head: &ObjectHead,
    start: i64,
    frame: &mut Frame,
) -> Result<Option<u16>, Reason> {
    let short = expected(object, "an object as long as its type");
    let length = match head.version {
        1 => 32,
        2 => 40,
        _ => return Ok(None),
    };
    let flags = u32_at(object, 16).ok_or(short)?;
    let count = object.get(24..).and_then(<[u8]>::first_chunk).ok_or(short)?;
    let unit = if flags & 3 == TEN_MICROSECONDS { 10_000 } else { 1 };
    let nanos = i128::from(start) + i128::from(u64::from_le_bytes(*count)) * unit;
    let nanos = i64::try_from(nanos).map_err(|_| Reason::StampRange)?;
    let body = object.get(length..).ok_or(short)?;
    let channel = match head.kind {
        MESSAGE | MESSAGE_2 => classic(body, frame),
        FD_MESSAGE => fd(body, frame),
        FD_MESSAGE_64 => fd_64(body, length, frame),
        _ => error(body, frame),
    };
    frame.timestamp = Timestamp::from_nanos(nanos);
    channel.ok_or(short)?.map(Some)
}

/// The channel; `None` where the object is too short.
type Channel = Option<Result<u16, Reason>>;

fn identifier(word: u32) -> Result<Id, Reason> {
    let value = word & IDENTIFIER;
    match word & EXTENDED {
        0 => Id::standard(value).ok_or(Reason::StandardRange(value)),
        _ => Id::extended(value).ok_or(Reason::ExtendedRange(value)),
    }
}

fn classic(body: &[u8], frame: &mut Frame) -> Channel {
    let (channel, flags, code) = (u16_at(body, 0)?, *body.get(2)?, *body.get(3)?);
    let (word, data) = (u32_at(body, 4)?, body.get(8..16)?);
    // Codes from 9 on mean 8 bytes, too.
    Some(
        put(frame, word, flags & REMOTE != 0, None, data, usize::from(code.min(8)))
            .map(|()| channel),
    )
}

fn fd(body: &[u8], frame: &mut Frame) -> Channel {
    let (channel, flags, code) = (u16_at(body, 0)?, *body.get(2)?, *body.get(3)?);
    let (word, bits, valid) = (u32_at(body, 4)?, *body.get(13)?, usize::from(*body.get(14)?));
    let kind = flags_of(bits & FD != 0, bits & BRS != 0, bits & ESI != 0);
    let remote = flags & REMOTE != 0;
    let length = if remote { usize::from(code.min(8)) } else { valid };
    Some(put(frame, word, remote, kind, body.get(20..)?, length).map(|()| channel))
}

/// Reads the body of an object whose head has `before` bytes.
fn fd_64(body: &[u8], before: usize, frame: &mut Frame) -> Channel {
    let (channel, code, valid) = (*body.first()?, *body.get(1)?, usize::from(*body.get(2)?));
    let (word, flags) = (u32_at(body, 4)?, u32_at(body, 12)?);
    let kind = flags_of(flags & FD_64 != 0, flags & BRS_64 != 0, flags & ESI_64 != 0);
    let remote = flags & REMOTE_64 != 0;
    let length = if remote { usize::from(code.min(8)) } else { valid };
    // Vector's tools may store fewer bytes than the frame had: the rest are zeros. What is told of its timing may follow.
    let end = match usize::from(*body.get(35)?) {
        0 => body.len(),
        offset => offset.saturating_sub(before).clamp(40, body.len()),
    };
    let (stored, mut data) = (body.get(40..end)?, [0; MAX_DATA]);
    data.iter_mut().zip(stored).for_each(|(byte, stored)| *byte = *stored);
    Some(put(frame, word, remote, kind, &data, length).map(|()| channel.into()))
}

fn error(body: &[u8], frame: &mut Frame) -> Channel {
    let channel = u16_at(body, 0)?;
    let id = Id::extended(BUS_ERROR).ok_or(Reason::ExtendedRange(BUS_ERROR));
    frame.kind = Kind::Error;
    frame.set_length(0);
    Some(id.map(|id| {
        frame.id = id;
        channel
    }))
}

/// The flags of a CAN FD frame; `None` for a classic one.
const fn flags_of(is_fd: bool, switch: bool, state: bool) -> Option<u8> {
    if is_fd { Some(switch as u8 | (state as u8) << 1) } else { None }
}

fn put(
    frame: &mut Frame,
    word: u32,
    remote: bool,
    fd: Option<u8>,
    data: &[u8],
    length: usize,
) -> Result<(), Reason> {
    frame.id = identifier(word)?;
    frame.kind = match fd {
        _ if remote => Kind::Remote { length: length as u8 },
        Some(flags) => Kind::Fd { flags },
        None => Kind::Data,
    };
    let length = if remote { 0 } else { length };
    match fd {
        Some(_) if !is_fd_length(length) => return Err(Reason::FdLength(length)),
        None if length > 8 => return Err(Reason::ClassicLength),
        _ => {}
    }
    let mismatch = Reason::LengthMismatch { announced: length, found: data.len() };
    let data = data.get(..length).ok_or(mismatch)?;
    frame.buffer_mut()[..length].copy_from_slice(data);
    frame.set_length(length);
    Ok(())
}
