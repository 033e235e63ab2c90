//! Captures of Wireshark and tcpdump: pcap and pcapng, with CAN frames as Linux captures them.
//!
//! Formats: draft-ietf-opsawg-pcap and draft-ietf-opsawg-pcapng. Packets are read of the link types
//! LINKTYPE_CAN_SOCKETCAN (an interface of CAN), and LINKTYPE_LINUX_SLL and LINKTYPE_LINUX_SLL2 (`-i any`). Other packets
//! are no frames.

mod block;
mod packet;
mod writer;

use crate::encoder::Written;
use crate::format::{End, Format, Item, Numbered, Reader, Unread};
use crate::limits::MAX_RECORD;
use crate::reason::{Found, Reason};
use tertius_core::frame::Frame;
use tertius_core::time::Timestamp;

use super::channels::NumberedName;
use block::{ENHANCED_PACKET, INTERFACE, LEAST_BLOCK, MOST_INTERFACES, ORDER, SECTION};
use packet::{Link, Unit};

pub static FORMAT: Format = Format {
    name: "a capture in pcap or pcapng",
    numbered: Numbered::Bytes,
    is_whole: false,
    recognise,
    reader: |_| Box::new(Pcap::default()),
    written: Some(Written {
        word: "pcapng",
        encoder: || Box::new(writer::PcapngEncoder::default()),
        explains_errors: true,
        is_packed: false,
    }),
};

/// Obsolete, but dumpcap has written it.
const PACKET: u32 = 2;
const SIMPLE_PACKET: u32 = 3;
/// First word of a pcap, with microseconds or nanoseconds.
const MICROSECONDS: u32 = 0xA1B2_C3D4;
const NANOSECONDS: u32 = 0xA1B2_3C4D;

const FILE_HEAD: usize = 24;
const PACKET_HEAD: usize = 16;
const NANOS_PER_SECOND: i128 = 1_000_000_000;

fn recognise(head: &[u8]) -> Option<bool> {
    let words = [MICROSECONDS, NANOSECONDS, SECTION];
    let mut magics = words.iter().flat_map(|word| [word.to_be_bytes(), word.to_le_bytes()]);
    match head.first_chunk() {
        Some(first) => Some(magics.any(|magic| magic == *first)),
        None => magics.all(|magic| !magic.starts_with(head)).then_some(false),
    }
}

/// What of a capture was read.
#[derive(Default)]
enum State {
    /// Nothing.
    #[default]
    Begin,
    /// The head of a pcap.
    Packets(Link),
    /// A section of a pcapng, with its interfaces.
    Blocks(Vec<Link>),
    /// Nothing can be found any more.
    Lost,
}

/// The reader of one capture.
#[derive(Default)]
struct Pcap {
    state: State,
    /// Whether numbers have their highest byte first.
    big: bool,
    /// Bytes of a long block that are left.
    skipped: u64,
    /// Name of the newest frame's interface.
    interface: Vec<u8>,
    numbered: NumberedName,
}

impl Reader for Pcap {
    fn read<'a>(&'a mut self, unread: Unread<'a>, frame: &mut Frame) -> Item<'a> {
        let bytes = unread.bytes;
        if bytes.is_empty() {
            return Item::More;
        }
        let is_lost = matches!(self.state, State::Lost);
        if is_lost || self.skipped > 0 {
            return self.drop(bytes.len(), is_lost && unread.end != End::Open);
        }
        let step = match &self.state {
            State::Begin => self.begin(bytes),
            State::Packets(link) => {
                let link = link.clone();
                self.packet(bytes, &link, frame)
            }
            State::Blocks(_) | State::Lost => self.block(bytes, frame),
        };
        match step {
            Ok(Some((taken, true))) => {
                Item::Frame { taken, interface: &self.interface, absolute: true }
            }
            Ok(Some((taken, false))) => Item::Nothing { taken },
            Ok(None) => Item::More,
            Err(Broken { taken: Some(taken), reason }) => {
                Item::Bad { shown: taken.min(SHOWN), taken, reason }
            }
            Err(Broken { taken: None, reason }) => {
                self.state = State::Lost;
                Item::Bad { shown: LEAST_HEAD, taken: LEAST_HEAD, reason }
            }
        }
    }
}

/// Most bytes of a bad record that are shown.
const SHOWN: usize = 64;
/// Bytes that are there of a record whose length is known.
const LEAST_HEAD: usize = 8;
/// Bytes that are dropped at a time.
const PART: usize = 1 << 16;

/// Bytes that were taken, and whether they are a frame; `None` where more are needed.
type Step = Result<Option<(usize, bool)>, Broken>;

/// A record that cannot be read. Without `taken` it is not known where it ends.
struct Broken {
    taken: Option<usize>,
    reason: Reason,
}

const fn lost(found: &[u8], expected: &'static str) -> Broken {
    let found = Found(if found.is_empty() { None } else { Some(found[0]) });
    Broken { taken: None, reason: Reason::Expected { found, expected } }
}

impl Pcap {
    /// Drops the next part of what is not wanted, of `held` bytes that are there, or all of it at the `end`. The parts
    /// are always the same, however many bytes come at once.
    fn drop(&mut self, held: usize, end: bool) -> Item<'static> {
        let left = usize::try_from(self.skipped).unwrap_or(usize::MAX);
        let part = if left == 0 { PART } else { left.min(PART) };
        if held < part && !end {
            return Item::More;
        }
        let taken = part.min(held);
        self.skipped = self.skipped.saturating_sub(taken as u64);
        Item::Nothing { taken }
    }

    fn u32(&self, bytes: &[u8], at: usize) -> Option<u32> {
        let bytes = *bytes.get(at..)?.first_chunk()?;
        Some(if self.big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    fn u16(&self, bytes: &[u8], at: usize) -> Option<u16> {
        let bytes = *bytes.get(at..)?.first_chunk()?;
        Some(if self.big { u16::from_be_bytes(bytes) } else { u16::from_le_bytes(bytes) })
    }

    /// The head of a pcap, or the first section of a pcapng.
    fn begin(&mut self, bytes: &[u8]) -> Step {
        let Some(first) = bytes.first_chunk() else { return Ok(None) };
        if u32::from_le_bytes(*first) == SECTION {
            return self.section(bytes);
        }
        if bytes.len() < FILE_HEAD {
            return Ok(None);
        }
        let is = |word| matches!(word, MICROSECONDS | NANOSECONDS);
        self.big = is(u32::from_be_bytes(*first));
        let word = self.u32(bytes, 0).unwrap_or(0);
        if !is(word) {
            return Err(lost(bytes, "the first word of a pcap or pcapng"));
        }
        let unit = Unit::Decimal(if word == NANOSECONDS { 9 } else { 6 });
        // The upper bits tell of check sums.
        let kind = self.u32(bytes, 20).unwrap_or(0) & 0xFFFF;
        self.state = State::Packets(Link { kind, name: b"if0".to_vec(), unit, offset: 0 });
        Ok(Some((FILE_HEAD, false)))
    }

    /// A packet of a pcap.
    fn packet(&mut self, bytes: &[u8], link: &Link, frame: &mut Frame) -> Step {
        let head = [0, 4, 8].map(|at| self.u32(bytes, at));
        let [Some(seconds), Some(parts), Some(length)] = head else { return Ok(None) };
        if bytes.len() < PACKET_HEAD {
            return Ok(None);
        }
        let length = length as usize;
        if length > MAX_RECORD - PACKET_HEAD {
            return Err(lost(&bytes[8..], "the length of a packet, at most 128 KiB"));
        }
        let Some(packet) = bytes.get(PACKET_HEAD..PACKET_HEAD + length) else { return Ok(None) };
        let nanos = i128::from(seconds) * NANOS_PER_SECOND + link.unit.nanos(parts.into());
        self.taken(PACKET_HEAD + length, link, packet, nanos, frame)
    }

    /// A block of a pcapng.
    fn block(&mut self, bytes: &[u8], frame: &mut Frame) -> Step {
        let Some(kind) = self.u32(bytes, 0) else { return Ok(None) };
        if kind == SECTION {
            return self.section(bytes);
        }
        let Some(length) = self.u32(bytes, 4) else { return Ok(None) };
        let length = length as usize;
        if length < LEAST_BLOCK || !length.is_multiple_of(4) {
            return Err(lost(&bytes[4..], "the length of a block, 12 or a larger multiple of 4"));
        }
        let is_packet = matches!(kind, PACKET | SIMPLE_PACKET | ENHANCED_PACKET);
        if length > MAX_RECORD {
            if is_packet || kind == INTERFACE {
                return Err(lost(&bytes[4..], "the length of a block, at most 128 KiB"));
            }
            self.skipped = length as u64 - LEAST_HEAD as u64;
            return Ok(Some((LEAST_HEAD, false)));
        }
        let Some(block) = bytes.get(..length) else { return Ok(None) };
        if self.u32(block, length - 4) != Some(length as u32) {
            return Err(lost(&block[length - 4..], "the length of the block once more at its end"));
        }
        let body = &block[8..length - 4];
        let broken = |reason| Broken { taken: Some(length), reason };
        match kind {
            INTERFACE => self.interface(body).map_err(broken)?,
            SIMPLE_PACKET => {
                let expected = "a packet with a time stamp, which a simple one has not";
                return Err(broken(Reason::Expected { found: Found::first(block), expected }));
            }
            ENHANCED_PACKET | PACKET => return self.enhanced(kind, length, body, frame),
            _ => {}
        }
        Ok(Some((length, false)))
    }

    fn section(&mut self, bytes: &[u8]) -> Step {
        let Some(order) = bytes.get(8..).and_then(<[u8]>::first_chunk) else { return Ok(None) };
        self.big = u32::from_be_bytes(*order) == ORDER;
        if !self.big && u32::from_le_bytes(*order) != ORDER {
            return Err(lost(&bytes[8..], "the byte order of a section, 1A2B3C4D"));
        }
        let length = self.u32(bytes, 4).unwrap_or(0) as usize;
        if !(28..=MAX_RECORD).contains(&length) || !length.is_multiple_of(4) {
            return Err(lost(&bytes[4..], "the length of a section's head, 28 or more"));
        }
        if bytes.len() < length {
            return Ok(None);
        }
        self.state = State::Blocks(Vec::new());
        Ok(Some((length, false)))
    }

    /// Takes the description of an interface.
    fn interface(&mut self, body: &[u8]) -> Result<(), Reason> {
        let expected = "the description of an interface";
        let short = Reason::Expected { found: Found::first(body), expected };
        let kind = self.u16(body, 0).filter(|_| body.len() >= 8).ok_or(short)?;
        let mut link =
            Link { kind: kind.into(), name: Vec::new(), unit: Unit::Decimal(6), offset: 0 };
        let mut options = &body[8..];
        while let (Some(code), Some(length)) = (self.u16(options, 0), self.u16(options, 2)) {
            let length = usize::from(length);
            let Some(value) = options.get(4..4 + length).filter(|_| code != 0) else { break };
            match (code, value) {
                (2, name) => link.name = packet::printable(name),
                (9, [unit]) if unit & 0x80 != 0 => link.unit = Unit::Binary(unit & 0x7F),
                (9, [unit]) => link.unit = Unit::Decimal(*unit),
                (14, offset) => {
                    let halves = [self.u32(offset, 0), self.u32(offset, 4)];
                    let [Some(first), Some(second)] = halves else { break };
                    let (high, low) = if self.big { (first, second) } else { (second, first) };
                    link.offset = (u64::from(high) << 32 | u64::from(low)) as i64;
                }
                _ => {}
            }
            options = options.get(4 + length.next_multiple_of(4)..).unwrap_or(&[]);
        }
        let State::Blocks(links) = &mut self.state else { return Ok(()) };
        if links.len() >= MOST_INTERFACES {
            let expected = "at most 1024 interfaces";
            return Err(Reason::Expected { found: Found::first(body), expected });
        }
        if link.name.is_empty() {
            link.name = format!("if{}", links.len()).into_bytes();
        }
        links.push(link);
        Ok(())
    }

    fn enhanced(&mut self, kind: u32, taken: usize, body: &[u8], frame: &mut Frame) -> Step {
        let broken = |expected| {
            let reason = Reason::Expected { found: Found::first(body), expected };
            Broken { taken: Some(taken), reason }
        };
        let number = match kind {
            PACKET => self.u16(body, 0).map(u32::from),
            _ => self.u32(body, 0),
        };
        let words = [number, self.u32(body, 4), self.u32(body, 8), self.u32(body, 12)];
        let [Some(number), Some(high), Some(low), Some(length)] = words else {
            return Err(broken("a packet with its interface, time stamp and lengths"));
        };
        let State::Blocks(links) = &self.state else { return Ok(Some((taken, false))) };
        let Some(link) = links.get(number as usize).cloned() else {
            return Err(broken("a packet of an interface that was described before"));
        };
        let Some(packet) = body.get(20..).and_then(|rest| rest.get(..length as usize)) else {
            return Err(broken("as many bytes of a packet as it announces"));
        };
        let count = u64::from(high) << 32 | u64::from(low);
        let nanos = link.unit.nanos(count) + i128::from(link.offset) * NANOS_PER_SECOND;
        self.taken(taken, &link, packet, nanos, frame)
    }

    /// Reads a packet of `link`, with its time since 1970, into `frame`.
    fn taken(
        &mut self,
        taken: usize,
        link: &Link,
        packet: &[u8],
        nanos: i128,
        frame: &mut Frame,
    ) -> Step {
        let broken = |reason| Broken { taken: Some(taken), reason };
        let can = link.can_of(packet, self.big, &mut self.numbered, &mut self.interface);
        let Some(can) = can else { return Ok(Some((taken, false))) };
        packet::read(can, frame).map_err(broken)?;
        let nanos = i64::try_from(nanos).map_err(|_| broken(Reason::StampRange))?;
        frame.timestamp = Timestamp::from_nanos(nanos);
        Ok(Some((taken, true)))
    }
}
