//! Writes captures in pcapng: packets of LINKTYPE_CAN_SOCKETCAN, with times in nanoseconds.

use super::block::{ENHANCED_PACKET, INTERFACE, LEAST_BLOCK, MOST_INTERFACES, ORDER, SECTION};
use super::packet::{ERROR, EXTENDED, FRAME_HEAD, IS_FD, REMOTE, SOCKETCAN};
use crate::encoder::{FrameEncoder, Unsayable};
use tertius_core::frame::{Frame, Kind, MAX_DATA};

/// Options: the end of them, the program that wrote it, the name of an interface, and the unit of its times.
const END: u16 = 0;
const PROGRAM: u16 = 4;
const NAME: u16 = 2;
const UNIT: u16 = 9;
/// 10⁻⁹ s.
const NANOSECONDS: u8 = 9;
/// Bytes of a payload that Linux captures of a classic frame, whatever its length.
const MAX_CLASSIC: usize = 8;

/// The encoder of one capture.
#[derive(Default)]
pub struct PcapngEncoder {
    /// Whether the section has begun.
    begun: bool,
    /// Names of the interfaces that were described, in order.
    interfaces: Vec<String>,
}

impl FrameEncoder for PcapngEncoder {
    fn add(
        &mut self,
        interface: &str,
        frame: &Frame,
        bytes: &mut Vec<u8>,
    ) -> Result<(), Unsayable> {
        let nanos = u64::try_from(frame.timestamp.as_nanos()).map_err(|_| Unsayable::Before1970)?;
        if !self.begun {
            self.begun = true;
            section(bytes);
        }
        let number = self.number(interface, bytes)?;
        let packet = packet(frame);
        let mut body = Vec::with_capacity(20 + packet.len());
        let length = packet.len() as u32;
        for word in [number, (nanos >> 32) as u32, nanos as u32, length, length] {
            body.extend(word.to_le_bytes());
        }
        body.extend(packet);
        block(ENHANCED_PACKET, &body, bytes);
        Ok(())
    }
}

impl PcapngEncoder {
    /// The number of an interface, which is described before its first packet.
    fn number(&mut self, name: &str, bytes: &mut Vec<u8>) -> Result<u32, Unsayable> {
        if let Some(known) = self.interfaces.iter().position(|known| known == name) {
            return Ok(known as u32);
        }
        if self.interfaces.len() == MOST_INTERFACES {
            return Err(Unsayable::Channel);
        }
        let mut body = Vec::new();
        body.extend((SOCKETCAN as u16).to_le_bytes());
        // Nothing, and no limit to a packet's length.
        body.extend([0; 6]);
        option(NAME, name.as_bytes(), &mut body);
        option(UNIT, &[NANOSECONDS], &mut body);
        option(END, &[], &mut body);
        block(INTERFACE, &body, bytes);
        self.interfaces.push(name.to_owned());
        Ok(self.interfaces.len() as u32 - 1)
    }
}

/// Begins the only section, of version 1.0 and any length.
fn section(bytes: &mut Vec<u8>) {
    let mut body = Vec::new();
    body.extend(ORDER.to_le_bytes());
    body.extend(1_u16.to_le_bytes());
    body.extend(0_u16.to_le_bytes());
    body.extend(u64::MAX.to_le_bytes());
    let program = concat!("tertius ", env!("CARGO_PKG_VERSION"));
    option(PROGRAM, program.as_bytes(), &mut body);
    option(END, &[], &mut body);
    block(SECTION, &body, bytes);
}

/// Appends an option, up to the next multiple of four bytes.
fn option(code: u16, value: &[u8], body: &mut Vec<u8>) {
    body.extend(code.to_le_bytes());
    body.extend((value.len() as u16).to_le_bytes());
    body.extend_from_slice(value);
    body.resize(body.len().next_multiple_of(4), 0);
}

/// Appends a block with its length at both ends.
fn block(kind: u32, body: &[u8], bytes: &mut Vec<u8>) {
    let padded = body.len().next_multiple_of(4);
    let length = ((LEAST_BLOCK + padded) as u32).to_le_bytes();
    bytes.extend(kind.to_le_bytes());
    bytes.extend(length);
    bytes.extend_from_slice(body);
    bytes.resize(bytes.len() + padded - body.len(), 0);
    bytes.extend(length);
}

/// A frame as Linux captures it: a whole `struct can_frame` or `canfd_frame` with its identifier in network byte order.
fn packet(frame: &Frame) -> Vec<u8> {
    let (word, length, flags, room) = match frame.kind {
        Kind::Data => (0, frame.data().len() as u8, 0, MAX_CLASSIC),
        Kind::Error => (ERROR, frame.data().len() as u8, 0, MAX_CLASSIC),
        Kind::Remote { length } => (REMOTE, length, 0, MAX_CLASSIC),
        Kind::Fd { flags } => (0, frame.data().len() as u8, flags & 3 | IS_FD, MAX_DATA),
    };
    // Of an error frame it is the classes of the error, in 29 bits but without the mark of them.
    let is_extended = frame.id.is_extended() && frame.kind != Kind::Error;
    let word = word | frame.id.value() | if is_extended { EXTENDED } else { 0 };
    let mut packet = Vec::with_capacity(FRAME_HEAD + room);
    packet.extend(word.to_be_bytes());
    packet.extend([length, flags, 0, 0]);
    packet.extend_from_slice(frame.data());
    packet.resize(FRAME_HEAD + room, 0);
    packet
}
