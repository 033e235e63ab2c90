//! Numbers within records, and the times that some of them are.

use super::block::{Block, Flaw, number};
use crate::reason::Reason;

/// Kinds of numbers: unsigned and signed integers and floating-point numbers, each little-endian and big-endian.
const KINDS: u8 = 6;
/// Bytes of a conversion before its numbers.
const VALUES: usize = 24;
const NANOS_PER_SECOND: f64 = 1e9;

/// A channel, as its block tells it.
#[derive(Clone, Copy, Debug)]
pub struct Channel {
    /// Place of its block.
    pub at: u64,
    /// What its values are: 0 of a fixed length, 1 of a variable one, 2 the master, 5 of a fixed length that is not always
    /// used, 6 none, so that they are the numbers of the records.
    pub kind: u8,
    /// What a master is of: 1 for time.
    pub sync: u8,
    /// Type of its numbers.
    pub number: u8,
    bit: u32,
    byte: u32,
    /// Number of bits.
    pub bits: u32,
    /// Links: the next channel, those that it is made of, its name, its conversion, and its data.
    pub next: u64,
    pub parts: u64,
    pub name: u64,
    conversion: u64,
    pub data: u64,
}

impl Channel {
    pub fn of(file: &[u8], block: &Block<'_>) -> Result<Self, Flaw> {
        let short = Flaw::expected(file, block.data_at(), "the description of a channel");
        let part = |at, length| number(block.data, at, length).ok_or(short);
        Ok(Self {
            at: block.at,
            kind: part(0, 1)? as u8,
            sync: part(1, 1)? as u8,
            number: part(2, 1)? as u8,
            bit: part(3, 1)? as u32,
            byte: part(4, 4)? as u32,
            bits: part(8, 4)? as u32,
            next: block.link(0),
            parts: block.link(1),
            name: block.link(2),
            conversion: block.link(4),
            data: block.link(5),
        })
    }

    /// The channel's number within records of a length.
    pub fn field(&self, length: usize) -> Result<RecordField, Flaw> {
        let Self { at, bit, bits, byte, .. } = *self;
        let told = "a channel of numbers that are longer than 64 bits, or not within their record";
        if bits == 0 || bits > 64 || bit > 7 {
            return Err(Flaw::told(at, told));
        }
        let bytes = (bit + bits).div_ceil(8) as usize;
        if length.checked_sub(bytes).is_none_or(|last| byte as usize > last) {
            return Err(Flaw::told(at, told));
        }
        Ok(RecordField { byte: byte as usize, bytes, bit, bits, is_big: self.number % 2 == 1 })
    }

    /// The offset of the channel's values, which are elsewhere; its lowest byte is the first one, whatever they are.
    pub fn offset(&self, length: usize) -> Result<RecordField, Flaw> {
        Ok(RecordField { is_big: false, ..self.field(length)? })
    }

    /// Where the channel's bytes are within records of a length: the first, and how many.
    pub fn bytes(&self, length: usize) -> Result<(usize, usize), Flaw> {
        let (first, count) = (self.byte as usize, self.bits as usize / 8);
        let is_within = length.checked_sub(count).is_some_and(|last| first <= last);
        let told = "a channel of bytes that are not within their record";
        if is_within { Ok((first, count)) } else { Err(Flaw::told(self.at, told)) }
    }
}

/// Where a number is within a record.
#[derive(Clone, Copy, Debug)]
pub struct RecordField {
    byte: usize,
    bytes: usize,
    bit: u32,
    bits: u32,
    is_big: bool,
}

impl RecordField {
    /// The number; 0 if the record is too short, which was excluded when the field was made.
    pub fn of(&self, record: &[u8]) -> u64 {
        let bytes = record.get(self.byte..self.byte + self.bytes).unwrap_or(&[]);
        let join = |sum: u128, byte: &u8| sum << 8 | u128::from(*byte);
        let all = match self.is_big {
            true => bytes.iter().fold(0, join),
            false => bytes.iter().rev().fold(0, join),
        };
        ((all >> self.bit) & ((1_u128 << self.bits) - 1)) as u64
    }
}

/// Most pairs of a table that is read.
const PAIRS: usize = 256;

/// A part of a frame that is a number, in the record or the same in all of them.
#[derive(Clone, Debug)]
pub struct Quantity {
    field: Option<RecordField>,
    meaning: Meaning,
}

/// What a number stands for.
#[derive(Clone, Debug)]
enum Meaning {
    Itself,
    /// Offset and factor.
    Linear(f64, f64),
    /// What stands for what: the last pair whose first number is not above it.
    Table(Vec<(f64, f64)>),
}

impl Quantity {
    /// The part in a channel, within records of a length.
    pub fn new(file: &[u8], channel: &Channel, length: usize) -> Result<Self, Flaw> {
        let meaning = Meaning::of(file, channel.conversion)?;
        if channel.kind != 6 {
            return Ok(Self { field: Some(channel.field(length)?), meaning });
        }
        match meaning {
            Meaning::Linear(_, 0.0) => Ok(Self { field: None, meaning }),
            _ => Err(Flaw::told(channel.at, "a part of a frame that is the number of its record")),
        }
    }

    /// The number.
    pub fn of(&self, record: &[u8]) -> u64 {
        let raw = self.field.map_or(0, |field| field.of(record));
        match &self.meaning {
            Meaning::Itself => raw,
            Meaning::Linear(offset, factor) => (offset + factor * raw as f64) as u64,
            Meaning::Table(pairs) => {
                let behind = pairs.partition_point(|(key, _)| *key <= raw as f64);
                pairs.get(behind.saturating_sub(1)).map_or(raw, |(_, value)| *value as u64)
            }
        }
    }
}

impl Meaning {
    /// By the conversion at a place. Texts are for people, and leave the number as it is.
    fn of(file: &[u8], at: u64) -> Result<Self, Flaw> {
        if at == 0 {
            return Ok(Self::Itself);
        }
        let block = Block::of(file, at, b"CC", "a conversion, ##CC")?;
        let values = block.data.get(VALUES..).unwrap_or(&[]);
        let mut values =
            (0..values.len() / 8).filter_map(|n| number(values, 8 * n, 8)).map(f64::from_bits);
        Ok(match block.data.first() {
            Some(1) => match (values.next(), values.next()) {
                (Some(offset), Some(factor)) => Self::Linear(offset, factor),
                _ => return Err(Flaw::told(at, "a linear conversion without its two numbers")),
            },
            Some(4 | 5) => {
                let pairs = std::iter::from_fn(|| values.next().zip(values.next()));
                let mut pairs: Vec<(f64, f64)> = pairs.take(PAIRS).collect();
                pairs.sort_by(|one, other| one.0.total_cmp(&other.0));
                Self::Table(pairs)
            }
            _ => Self::Itself,
        })
    }
}

/// How a number becomes a time.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    field: RecordField,
    /// Type of the number.
    number: u8,
    /// Nanoseconds of 1, also as a whole number if it is one, and of 0.
    scale: f64,
    whole: Option<i64>,
    offset: f64,
}

impl Clock {
    /// The clock of a master channel within records of a length.
    pub fn of(file: &[u8], channel: &Channel, length: usize) -> Result<Self, Flaw> {
        let is_real = matches!(channel.number, 4 | 5);
        if channel.number >= KINDS || (is_real && !matches!(channel.bits, 32 | 64)) {
            return Err(Flaw::told(channel.at, "a time channel whose values are no numbers"));
        }
        let field = channel.field(length)?;
        let (offset, scale) = match channel.conversion {
            0 => (0.0, NANOS_PER_SECOND),
            at => linear(file, at)?,
        };
        let near = scale.round();
        let is_whole = (1.0..1e15).contains(&near) && (scale - near).abs() <= 1e-9 * near;
        let whole = is_whole.then_some(near as i64);
        Ok(Self { field, number: channel.number, scale, whole, offset })
    }

    /// The time in a record, ns.
    pub fn nanos(&self, record: &[u8]) -> Result<i64, Reason> {
        let raw = self.field.of(record);
        let unused = 64 - self.field.bits;
        let nanos = match self.number {
            4 | 5 => {
                let real = match self.field.bits {
                    32 => f32::from_bits(raw as u32).into(),
                    _ => f64::from_bits(raw),
                };
                self.scaled(real)
            }
            2 | 3 => self.counted(i128::from((raw << unused) as i64 >> unused)),
            _ => self.counted(raw.into()),
        };
        i64::try_from(nanos).map_err(|_| Reason::StampRange)
    }

    fn counted(&self, count: i128) -> i128 {
        match self.whole {
            Some(scale) => count * i128::from(scale) + whole(self.offset),
            None => self.scaled(count as f64),
        }
    }

    fn scaled(&self, real: f64) -> i128 {
        let scale = self.whole.map_or(self.scale, |scale| scale as f64);
        whole((real * scale).round() + self.offset)
    }
}

/// The nearest whole number; one out of the range of times where there is none, and small enough to count on with.
fn whole(nanos: f64) -> i128 {
    const FAR: i128 = i128::MAX / 4;
    if nanos.is_finite() { (nanos.round() as i128).clamp(-FAR, FAR) } else { FAR }
}

/// Offset and scale of a linear conversion to seconds, ns.
fn linear(file: &[u8], at: u64) -> Result<(f64, f64), Flaw> {
    let block = Block::of(file, at, b"CC", "a conversion, ##CC")?;
    let value = |at| number(block.data, at, 8).map(f64::from_bits);
    match (block.data.first(), value(VALUES), value(VALUES + 8)) {
        (Some(0), ..) => Ok((0.0, NANOS_PER_SECOND)),
        (Some(1), Some(offset), Some(scale)) => {
            Ok((offset * NANOS_PER_SECOND, scale * NANOS_PER_SECOND))
        }
        _ => Err(Flaw::told(at, "a time channel is read if its conversion is linear, or has none")),
    }
}
