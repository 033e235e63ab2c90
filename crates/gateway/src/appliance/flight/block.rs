//! Frames on their way from the data path to the worker, in memory that was reserved before.

use tertius_core::frame::{BusNumber, Frame, Id, Kind};
use tertius_core::incident::Incident;
use tertius_core::monitor::Monitor;
use tertius_core::time::Timestamp;

/// Room for frames, bytes: about a second of a full bus with 500 kbit/s.
const SIZE: usize = 64 * 1024;

/// Most incidents in a block: twice as many as can be open at once.
pub(super) const INCIDENTS: usize = 36;

/// Bytes of a frame before its payload: time stamp, identifier, kind, length.
const HEAD: usize = 14;

/// Longest payload of a classic frame, bytes.
const WORD: usize = 8;

const DATA: u8 = 0x00;
const FD: u8 = 0x10;
const REMOTE: u8 = 0x20;
const ERROR: u8 = 0x30;

/// Place of the bus in the byte of the kind, whose two highest bits it takes.
const BUS_SHIFT: u32 = 6;

/// Frames, and what was found while they came.
#[derive(Debug)]
pub(super) struct Block {
    bytes: Box<[u8]>,
    /// Number of bytes that are filled.
    used: usize,
    /// Number of frames lost before those of this block, because no block was free.
    pub lost: u64,
    /// The monitor before the first of its frames.
    pub state: Option<Box<Monitor>>,
    pub incidents: Vec<Incident>,
    /// Number of incidents lost for want of room.
    pub left_out: u64,
    /// Whether somebody asks for everything up to here.
    pub demanded: bool,
    /// Time up to which everything is in this block or an earlier one.
    pub until: Timestamp,
}

impl Block {
    pub fn new() -> Self {
        Self {
            bytes: vec![0; SIZE].into(),
            used: 0,
            lost: 0,
            state: None,
            incidents: Vec::with_capacity(INCIDENTS),
            left_out: 0,
            demanded: false,
            until: Timestamp::default(),
        }
    }

    /// Copies a frame with the time stamp `at`; returns `false` if there is no room for it.
    #[inline]
    pub fn push(&mut self, at: Timestamp, frame: &Frame) -> bool {
        let length = frame.length();
        let Some(room) = self.bytes.get_mut(self.used..) else { return false };
        let Some((head, room)) = room.split_first_chunk_mut::<HEAD>() else { return false };
        // A copy of fixed length is faster, and nearly every frame has at most eight bytes.
        match room.first_chunk_mut::<WORD>().zip(frame.buffer().first_chunk::<WORD>()) {
            Some((room, word)) if length <= WORD => *room = *word,
            _ => match room.get_mut(..length) {
                Some(room) => room.copy_from_slice(frame.data()),
                None => return false,
            },
        }
        head[..8].copy_from_slice(&at.as_nanos().to_le_bytes());
        head[8..12].copy_from_slice(&frame.id.to_dbc().to_le_bytes());
        head[12] = match frame.kind {
            Kind::Data => DATA,
            Kind::Fd { flags } => FD | (flags & 0xF),
            Kind::Remote { length } => REMOTE | (length & 0xF),
            Kind::Error => ERROR,
        };
        head[12] |= (frame.bus.index() as u8) << BUS_SHIFT;
        // At most 64.
        head[13] = length as u8;
        self.used += HEAD + length;
        true
    }

    /// The frames, in the order in which they came.
    pub fn frames(&self) -> impl Iterator<Item = Frame> {
        let mut rest = &self.bytes[..self.used];
        std::iter::from_fn(move || {
            let (head, after) = rest.split_first_chunk::<HEAD>()?;
            let (data, after) = after.split_at_checked(usize::from(head[13]))?;
            rest = after;
            unpack(head, data)
        })
    }

    pub fn clear(&mut self) {
        self.used = 0;
        self.incidents.clear();
        (self.lost, self.left_out) = (0, 0);
        self.state = None;
        self.demanded = false;
    }
}

fn unpack(head: &[u8; HEAD], data: &[u8]) -> Option<Frame> {
    let nanos = i64::from_le_bytes(*head.first_chunk()?);
    let bits = u32::from_le_bytes(*head[8..].first_chunk()?);
    let id = match bits >> 31 {
        0 => Id::standard(bits)?,
        _ => Id::extended(bits & Id::EXTENDED_MAX)?,
    };
    let low = head[12] & 0xF;
    let bus = BusNumber::ALL[usize::from(head[12] >> BUS_SHIFT)];
    let kind = match head[12] & 0x30 {
        DATA => Kind::Data,
        FD => Kind::Fd { flags: low },
        REMOTE => Kind::Remote { length: low },
        _ => Kind::Error,
    };
    Some(Frame::new(Timestamp::from_nanos(nanos), id, kind, data).on(bus))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_of_every_kind_come_out_as_they_went_in() {
        let [standard, extended] =
            [Id::standard(0x7FF), Id::extended(0x1FFF_FFFF)].map(Option::unwrap);
        let at = Timestamp::from_nanos;
        let frames = [
            Frame::new(
                at(1_700_000_000_123_456_000),
                standard,
                Kind::Data,
                &[1, 2, 3, 4, 5, 6, 7, 8],
            ),
            Frame::new(at(-1), extended, Kind::Data, &[]),
            Frame::new(at(2), extended, Kind::Fd { flags: 3 }, &[9; 64]),
            Frame::new(at(3), standard, Kind::Remote { length: 8 }, &[]).on(BusNumber::Second),
            Frame::new(at(4), Id::extended(0x40).unwrap(), Kind::Error, &[0; 8])
                .on(BusNumber::ALL[3]),
        ];
        let mut block = Block::new();
        assert!(frames.iter().all(|frame| block.push(frame.timestamp, frame)));
        assert_eq!(block.frames().collect::<Vec<_>>(), frames);
        block.clear();
        assert_eq!(block.frames().count(), 0);
    }

    #[test]
    fn a_full_block_takes_no_more_and_does_not_grow() {
        let frame = Frame::new(Timestamp::default(), Id::standard(1).unwrap(), Kind::Data, &[0; 8]);
        let mut block = Block::new();
        let taken = (0..10_000).filter(|_| block.push(frame.timestamp, &frame)).count();
        assert_eq!(taken, SIZE / (HEAD + 8));
        assert_eq!((block.frames().count(), block.bytes.len()), (taken, SIZE));
    }
}
