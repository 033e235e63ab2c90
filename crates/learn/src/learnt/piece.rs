//! Packed frames of a minute.
//!
//! Similar data are put side by side: for each identifier the difference of each byte of the
//! payload to the same byte of the previous frame, byte by byte; and the order of the identifiers
//! and the time from frame to frame, which repeat from cycle to cycle. zstd then compresses well.
//! Nothing is lost: the monitor gets the frames that were recorded.

use tertius_core::frame::{BusNumber, Frame, Id, Kind, MAX_DATA};
use tertius_core::time::{Span, Timestamp};
use thiserror::Error;

/// Longest piece, ns.
const LENGTH: i64 = 60_000_000_000;

/// Most frames of a piece: a full bus of 1 Mbit/s has a quarter of this in a minute.
pub const MOST_FRAMES: usize = 1 << 21;

/// Compression level; a higher one gains little and takes long.
const LEVEL: i32 = 9;

/// Most bytes that a piece is unpacked to.
const MOST_UNPACKED: usize = MOST_FRAMES * (MAX_DATA + 16);

/// Packed frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    first: Timestamp,
    last: Timestamp,
    frames: u32,
    packed: Vec<u8>,
}

/// The contents of a piece are damaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("a piece of it cannot be unpacked")]
pub struct Damage;

/// Place of the bus in the number of an identifier, between its 29 bits and that of the extended format.
const BUS_SHIFT: u32 = 29;

/// Properties that frames of one stream share.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Key {
    bus: BusNumber,
    id: Id,
    kind: Kind,
    length: usize,
}

impl Piece {
    /// The piece stored in a file.
    pub fn of_parts(ends: [Timestamp; 2], frames: u32, packed: Vec<u8>) -> Self {
        let [first, last] = ends;
        Self { first, last, frames, packed }
    }

    /// The earliest time stamp.
    pub const fn first(&self) -> Timestamp {
        self.first
    }

    /// The latest time stamp.
    pub const fn last(&self) -> Timestamp {
        self.last
    }

    pub const fn frames(&self) -> u32 {
        self.frames
    }

    /// Size of the packed piece, bytes.
    pub const fn bytes(&self) -> usize {
        self.packed.len()
    }

    pub fn packed(&self) -> &[u8] {
        &self.packed
    }

    /// Passes its frames to `take`, in the order in which they came.
    ///
    /// # Errors
    /// The piece is damaged; some frames may already have been passed on.
    pub fn unpack(&self, mut take: impl FnMut(&Frame)) -> Result<(), Damage> {
        let (length, packed) = self.packed.split_first_chunk().ok_or(Damage)?;
        let length = u32::from_le_bytes(*length) as usize;
        let bytes = zstd::bulk::decompress(packed, length.min(MOST_UNPACKED));
        let bytes = bytes.map_err(|_| Damage)?;
        let mut rest = Reader(&bytes);
        let unit = i64::try_from(rest.number()?).map_err(|_| Damage)?;
        let count = rest.number()? as usize;
        let mut streams = Vec::new();
        for _ in 0..count {
            streams.push(rest.stream()?);
        }
        let [order, times] = [rest.number()?, rest.number()?].map(|length| length as usize);
        let (mut order, mut times) = (Reader(rest.bytes(order)?), Reader(rest.bytes(times)?));
        let mut at = self.first;
        for _ in 0..self.frames {
            let stream = streams.get_mut(order.number()? as usize).ok_or(Damage)?;
            at = at.after(Span::from_nanos(signed(times.number()?).saturating_mul(unit)));
            take(&stream.next(at)?);
        }
        Ok(())
    }
}

/// Packs frames as they come.
#[derive(Debug, Default)]
pub struct Packing {
    done: Vec<Piece>,
    open: Vec<Frame>,
}

impl Packing {
    /// Takes the next frame to be kept, which must be a data frame.
    pub fn take(&mut self, frame: &Frame) {
        let begun = self.open.first().map(|first| frame.timestamp.since(first.timestamp));
        let over = |begun: Span| !(-LENGTH..LENGTH).contains(&begun.as_nanos());
        if begun.is_some_and(over) || self.open.len() == MOST_FRAMES {
            self.close();
        }
        self.open.push(frame.clone());
    }

    /// Ends the piece, because the next frame does not follow.
    pub fn close(&mut self) {
        let frames = std::mem::take(&mut self.open);
        self.done.extend(pack(&frames));
    }

    /// All pieces.
    pub fn finish(mut self) -> Vec<Piece> {
        self.close();
        self.done
    }
}

fn pack(frames: &[Frame]) -> Option<Piece> {
    let stamps = || frames.iter().map(|frame| frame.timestamp);
    let (first, last) = (stamps().min()?, stamps().max()?);
    let mut keys: Vec<(Key, Vec<&Frame>)> = Vec::new();
    let (mut order, mut steps, mut before) = (Vec::new(), Vec::new(), first);
    for frame in frames {
        let key = Key { bus: frame.bus, id: frame.id, kind: frame.kind, length: frame.length() };
        let known = keys.iter().position(|(known, _)| *known == key);
        let which = known.unwrap_or_else(|| {
            keys.push((key, Vec::new()));
            keys.len() - 1
        });
        keys[which].1.push(frame);
        number(&mut order, which as u64);
        steps.push(frame.timestamp.since(before).as_nanos());
        before = frame.timestamp;
    }
    // candump writes microseconds.
    let unit = if steps.iter().all(|step| step % 1000 == 0) { 1000 } else { 1 };
    let mut times = Vec::new();
    steps.iter().for_each(|step| number(&mut times, unsigned(step / unit)));
    let mut bytes = Vec::new();
    number(&mut bytes, unit.unsigned_abs());
    number(&mut bytes, keys.len() as u64);
    keys.iter().for_each(|(key, frames)| stream(&mut bytes, key, frames));
    number(&mut bytes, order.len() as u64);
    number(&mut bytes, times.len() as u64);
    bytes.extend(order);
    bytes.extend(times);
    // Who unpacks it makes room for so much.
    let mut packed = u32::try_from(bytes.len()).ok()?.to_le_bytes().to_vec();
    packed.extend(zstd::bulk::compress(&bytes, LEVEL).ok()?);
    Some(Piece { first, last, frames: u32::try_from(frames.len()).ok()?, packed })
}

/// The frames of one key, byte by byte of the payload.
fn stream(bytes: &mut Vec<u8>, key: &Key, frames: &[&Frame]) {
    let bus = (key.bus.index() as u32) << BUS_SHIFT;
    number(bytes, (key.id.to_dbc() | bus).into());
    let flags = if let Kind::Fd { flags } = key.kind { 1 + u64::from(flags) } else { 0 };
    number(bytes, flags);
    number(bytes, key.length as u64);
    number(bytes, frames.len() as u64);
    for byte in 0..key.length {
        let mut before = 0;
        for frame in frames {
            let value = frame.data()[byte];
            bytes.push(value.wrapping_sub(before));
            before = value;
        }
    }
}

/// Remaining frames of one key.
struct Stream<'a> {
    key: Key,
    columns: &'a [u8],
    count: usize,
    given: usize,
    payload: [u8; MAX_DATA],
}

impl Stream<'_> {
    fn next(&mut self, at: Timestamp) -> Result<Frame, Damage> {
        let Self { key, columns, count, given, payload } = self;
        if given == count {
            return Err(Damage);
        }
        for (byte, value) in payload[..key.length].iter_mut().enumerate() {
            *value = value.wrapping_add(columns[byte * *count + *given]);
        }
        *given += 1;
        Ok(Frame::new(at, key.id, key.kind, &payload[..key.length]).on(key.bus))
    }
}

/// Remaining unpacked bytes.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    /// Reads a number stored in as few bytes as possible, seven bits each, the lowest first.
    fn number(&mut self) -> Result<u64, Damage> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let (byte, rest) = self.0.split_first().ok_or(Damage)?;
            self.0 = rest;
            value |= u64::from(byte & 0x7F) << shift;
            if byte & 0x80 == 0 {
                return Ok(value);
            }
        }
        Err(Damage)
    }

    fn bytes(&mut self, length: usize) -> Result<&'a [u8], Damage> {
        let (bytes, rest) = self.0.split_at_checked(length).ok_or(Damage)?;
        self.0 = rest;
        Ok(bytes)
    }

    fn stream(&mut self) -> Result<Stream<'a>, Damage> {
        let bits = u32::try_from(self.number()?).map_err(|_| Damage)?;
        let bus = BusNumber::ALL[(bits >> BUS_SHIFT) as usize % BusNumber::ALL.len()];
        let (extended, bits) = (bits & 1 << 31 != 0, bits & Id::EXTENDED_MAX);
        let id = if extended { Id::extended(bits) } else { Id::standard(bits) };
        let id = id.ok_or(Damage)?;
        let kind = match self.number()? {
            0 => Kind::Data,
            flags => Kind::Fd { flags: u8::try_from(flags - 1).map_err(|_| Damage)? },
        };
        let [length, count] = [self.number()?, self.number()?].map(|it| it as usize);
        if length > MAX_DATA || count > MOST_FRAMES {
            return Err(Damage);
        }
        let columns = self.bytes(length * count)?;
        let key = Key { bus, id, kind, length };
        Ok(Stream { key, columns, count, given: 0, payload: [0; MAX_DATA] })
    }
}

fn number(bytes: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
}

/// Maps small numbers of either sign to small numbers without one.
const fn unsigned(value: i64) -> u64 {
    (value << 1 ^ value >> 63).cast_unsigned()
}

const fn signed(value: u64) -> i64 {
    (value >> 1).cast_signed() ^ -((value & 1).cast_signed())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn unpacked(pieces: &[Piece]) -> Vec<Frame> {
        let mut frames = Vec::new();
        for piece in pieces {
            piece.unpack(|frame| frames.push(frame.clone())).expect("it is whole");
        }
        frames
    }

    fn frame() -> impl Strategy<Value = Frame> {
        let id = prop_oneof![
            (0..=Id::STANDARD_MAX).prop_map(Id::standard),
            (0..=Id::EXTENDED_MAX).prop_map(Id::extended),
        ];
        let data = proptest::collection::vec(any::<u8>(), 0..=MAX_DATA);
        let kind = prop_oneof![Just(Kind::Data), any::<u8>().prop_map(|flags| Kind::Fd { flags })];
        let bus = proptest::sample::select(BusNumber::ALL.to_vec());
        (0..200_000_000_000_i64, bus, id, kind, data).prop_map(|(at, bus, id, kind, data)| {
            let at = Timestamp::from_nanos(at);
            Frame::new(at, id.expect("it is in range"), kind, &data).on(bus)
        })
    }

    proptest! {
        /// Holds for any frames in any order.
        #[test]
        fn what_is_unpacked_is_what_was_packed(
            frames in proptest::collection::vec(frame(), 0..200)
        ) {
            let mut packing = Packing::default();
            frames.iter().for_each(|frame| packing.take(frame));
            prop_assert_eq!(unpacked(&packing.finish()), frames);
        }

        #[test]
        fn what_is_no_piece_is_refused_and_not_trusted(
            bytes in proptest::collection::vec(any::<u8>(), 0..200), frames in 0..50_u32
        ) {
            let mut packed = 200_u32.to_le_bytes().to_vec();
            packed.extend(zstd::bulk::compress(&bytes, 1).expect("there is room"));
            for packed in [packed, bytes] {
                let ends = [Timestamp::default(); 2];
                _ = Piece::of_parts(ends, frames, packed).unpack(|_| {});
            }
        }
    }

    #[test]
    fn a_minute_is_a_piece() {
        let id = Id::standard(0x181).expect("11 bits");
        let mut packing = Packing::default();
        for k in 0..9000_i64 {
            let at = Timestamp::from_nanos(k * 20_000_000);
            packing.take(&Frame::new(at, id, Kind::Data, &k.to_le_bytes()));
        }
        let pieces = packing.finish();
        assert_eq!(pieces.iter().map(Piece::frames).collect::<Vec<_>>(), [3000; 3]);
        assert!(pieces.iter().all(|piece| piece.bytes() < 500), "{}", pieces[0].bytes());
    }
}
