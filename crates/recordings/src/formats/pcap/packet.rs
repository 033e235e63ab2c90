//! The packets of a capture: where they come from, and the CAN frames in them.

use crate::format::is_fd_length;
use crate::limits::MAX_INTERFACE;
use crate::reason::{Found, Reason};
use tertius_core::frame::{Frame, Id, Kind};

use super::super::channels::NumberedName;

/// LINKTYPE_CAN_SOCKETCAN, LINKTYPE_LINUX_SLL and LINKTYPE_LINUX_SLL2.
pub const SOCKETCAN: u32 = 227;
const COOKED: u32 = 113;
const COOKED_2: u32 = 276;
/// ETH_P_CAN and ETH_P_CANFD of linux/if_ether.h.
const CAN_PROTOCOLS: [u16; 2] = [0x000C, 0x000D];

/// Of linux/can.h: an extended identifier, a remote frame, an error frame.
pub const EXTENDED: u32 = 1 << 31;
pub const REMOTE: u32 = 1 << 30;
pub const ERROR: u32 = 1 << 29;
/// CANFD_FDF: the frame is of CAN FD.
pub const IS_FD: u8 = 4;
/// Bytes of a frame before its payload, and of a whole one of CAN FD, by which older captures tell it.
pub const FRAME_HEAD: usize = 8;
const FD_FRAME: usize = 72;

const NANOS_PER_SECOND: i128 = 1_000_000_000;

/// Where the packets of an interface come from.
#[derive(Clone, Debug)]
pub struct Link {
    /// The link type.
    pub kind: u32,
    pub name: Vec<u8>,
    pub unit: Unit,
    /// Added to every time stamp, s.
    pub offset: i64,
}

/// The unit of time stamps.
#[derive(Clone, Copy, Debug)]
pub enum Unit {
    /// 10⁻ⁿ s.
    Decimal(u8),
    /// 2⁻ⁿ s.
    Binary(u8),
}

impl Unit {
    /// This many units, ns.
    pub fn nanos(self, count: u64) -> i128 {
        let nanos = i128::from(count) * NANOS_PER_SECOND;
        match self {
            Self::Decimal(digits) => nanos / 10_i128.pow(digits.min(30).into()),
            Self::Binary(digits) => nanos >> digits.min(126),
        }
    }
}

/// A CAN frame in a packet, as Linux lays it out.
#[derive(Clone, Copy, Debug)]
pub struct Packed<'a> {
    bytes: &'a [u8],
    /// Whether the identifier has its highest byte first. An interface of CAN is captured in network byte order; a
    /// cooked capture keeps the byte order of the computer that wrote it.
    big: bool,
}

impl Link {
    /// The CAN frame in a packet, and the name of its interface, which may be one of the `numbered`; `None` in a packet
    /// of something else. `written_big` tells whether the numbers of the file have their highest byte first.
    pub fn can_of<'a>(
        &self,
        packet: &'a [u8],
        written_big: bool,
        numbered: &mut NumberedName,
        interface: &mut Vec<u8>,
    ) -> Option<Packed<'a>> {
        let (can, big, index) = match self.kind {
            SOCKETCAN => (Some(packet), true, None),
            COOKED if is_can(packet.get(14..)) => (packet.get(16..), written_big, None),
            COOKED_2 if is_can(packet.get(0..)) => {
                let index = packet.get(4..).and_then(<[u8]>::first_chunk);
                (packet.get(20..), written_big, index.map(|index| u32::from_be_bytes(*index)))
            }
            _ => return None,
        };
        interface.clear();
        match index {
            Some(index) => interface.extend_from_slice(numbered.of("if", index.into())),
            None => interface.extend_from_slice(&self.name),
        }
        Some(Packed { bytes: can.unwrap_or(&[]), big })
    }
}

/// Whether a packet's protocol, with which `bytes` begin, is one of CAN.
fn is_can(bytes: Option<&[u8]>) -> bool {
    let protocol = bytes.and_then(<[u8]>::first_chunk).map(|bytes| u16::from_be_bytes(*bytes));
    protocol.is_some_and(|protocol| CAN_PROTOCOLS.contains(&protocol))
}

/// The printable characters of a name, as many as a name may have.
pub fn printable(name: &[u8]) -> Vec<u8> {
    name.iter().copied().filter(u8::is_ascii_graphic).take(MAX_INTERFACE).collect()
}

/// Reads a frame.
pub fn read(Packed { bytes, big }: Packed<'_>, frame: &mut Frame) -> Result<(), Reason> {
    let expected = "a CAN frame of 8 bytes and its data";
    let short = Reason::Expected { found: Found::first(bytes), expected };
    let (head, data) = bytes.split_first_chunk::<FRAME_HEAD>().ok_or(short)?;
    let [a, b, c, d, length, flags, ..] = *head;
    let word =
        if big { u32::from_be_bytes([a, b, c, d]) } else { u32::from_le_bytes([a, b, c, d]) };
    let length = usize::from(length);
    let value = word & !(EXTENDED | REMOTE | ERROR);
    let is_fd = flags & IS_FD != 0 || bytes.len() == FD_FRAME;
    frame.kind = match word {
        word if word & ERROR != 0 => Kind::Error,
        word if word & REMOTE != 0 => Kind::Remote { length: length.min(8) as u8 },
        _ if is_fd => Kind::Fd { flags: flags & 3 },
        _ => Kind::Data,
    };
    frame.id = if word & (EXTENDED | ERROR) != 0 {
        Id::extended(value).ok_or(Reason::ExtendedRange(value))?
    } else {
        Id::standard(value).ok_or(Reason::StandardRange(value))?
    };
    let length = match frame.kind {
        Kind::Remote { .. } => 0,
        Kind::Fd { .. } if !is_fd_length(length) => return Err(Reason::FdLength(length)),
        Kind::Data | Kind::Error if length > 8 => return Err(Reason::ClassicLength),
        _ => length,
    };
    let mismatch = Reason::LengthMismatch { announced: length, found: data.len() };
    let data = data.get(..length).ok_or(mismatch)?;
    frame.buffer_mut()[..length].copy_from_slice(data);
    frame.set_length(length);
    Ok(())
}
