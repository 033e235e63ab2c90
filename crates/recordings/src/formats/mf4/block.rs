//! The blocks of an MDF 4, which links hold together.

use crate::reason::{Found, Reason};

/// Bytes of a block before its links.
pub const HEAD: usize = 24;
/// What is wrong with a block that is not whole.
const WHOLE: &str = "a block with as many bytes as it announces";

/// What is wrong, and where.
#[derive(Clone, Copy, Debug)]
pub struct Flaw {
    /// Number of bytes of the file before it.
    pub at: u64,
    pub reason: Reason,
    /// Whether more frames than one cannot be found for it.
    pub loses: bool,
}

impl Flaw {
    /// Found is what stands at the place.
    pub fn expected(file: &[u8], at: u64, expected: &'static str) -> Self {
        let found = Found::first(tail(file, at));
        let reason = match found {
            Found(None) => Reason::EndExpected(expected),
            Found(Some(_)) => Reason::Expected { found, expected },
        };
        Self::of(at, reason)
    }

    pub const fn told(at: u64, told: &'static str) -> Self {
        Self::of(at, Reason::Text(told))
    }

    pub const fn of(at: u64, reason: Reason) -> Self {
        Self { at, reason, loses: false }
    }

    /// The same flaw, for which more frames than one cannot be found.
    pub const fn losing(self) -> Self {
        Self { loses: true, ..self }
    }
}

/// The bytes of the file from a place on; none behind its end.
pub fn tail(file: &[u8], at: u64) -> &[u8] {
    usize::try_from(at).ok().and_then(|at| file.get(at..)).unwrap_or(&[])
}

/// A little-endian number of up to eight bytes; `None` where there are too few.
pub fn number(bytes: &[u8], at: usize, length: usize) -> Option<u64> {
    let bytes = bytes.get(at..at.checked_add(length)?)?;
    Some(bytes.iter().rev().fold(0, |sum, byte| sum << 8 | u64::from(*byte)))
}

/// A block.
#[derive(Clone, Copy, Debug)]
pub struct Block<'a> {
    /// Number of bytes before it.
    pub at: u64,
    /// The two letters behind `##`.
    pub kind: [u8; 2],
    /// Its length as it is announced.
    pub announced: u64,
    links: &'a [u8],
    /// What stands behind its links, as far as the file has it.
    pub data: &'a [u8],
}

impl<'a> Block<'a> {
    /// The block at a place; its data may reach behind the file's end, or be of a length that nobody has filled in.
    pub fn open(file: &'a [u8], at: u64) -> Result<Self, Flaw> {
        let bytes = tail(file, at);
        let head = (number(bytes, 8, 8), number(bytes, 16, 8));
        let (Some(announced), Some(links), [b'#', b'#', first, second, ..]) =
            (head.0, head.1, bytes)
        else {
            return Err(Flaw::expected(file, at, "a block of MDF, which begins with ##"));
        };
        let links = usize::try_from(links).ok().and_then(|links| links.checked_mul(8));
        let Some((links, rest)) = links.and_then(|links| bytes[HEAD..].split_at_checked(links))
        else {
            return Err(Flaw::expected(file, at + 16, "as many links as a block announces"));
        };
        let length = usize::try_from(announced).unwrap_or(usize::MAX);
        let length = length.saturating_sub(HEAD + links.len());
        let data = &rest[..length.min(rest.len())];
        Ok(Self { at, kind: [*first, *second], announced, links, data })
    }

    /// The whole block of a kind at a place.
    pub fn of(file: &'a [u8], at: u64, kind: &[u8; 2], is: &'static str) -> Result<Self, Flaw> {
        let block = Self::open(file, at)?;
        if &block.kind != kind {
            return Err(Flaw::expected(file, at + 2, is));
        }
        if block.stored() != block.announced {
            return Err(Flaw::expected(file, at + 8, WHOLE));
        }
        Ok(block)
    }

    /// Where a link leads to; 0 is nowhere.
    pub fn link(&self, number: usize) -> u64 {
        self::number(self.links, 8 * number, 8).unwrap_or(0)
    }

    /// Number of its links.
    pub fn links(&self) -> usize {
        self.links.len() / 8
    }

    /// Place of its data.
    pub fn data_at(&self) -> u64 {
        self.at + (HEAD + self.links.len()) as u64
    }

    /// Its length as far as the file has it.
    pub fn stored(&self) -> u64 {
        (HEAD + self.links.len() + self.data.len()) as u64
    }
}

/// Most bytes of a text; no name that is looked for has as many.
const TEXT: usize = 64;

/// The beginning of the text in a block at a place.
pub fn text(file: &[u8], at: u64) -> &[u8] {
    let text = Block::of(file, at, b"TX", "a text").map_or(&[][..], |block| block.data);
    let text = &text[..text.len().min(TEXT)];
    &text[..memchr::memchr(0, text).unwrap_or(text.len())]
}

/// Bytes that may still be walked through: blocks do not overlap, so that all of them together have no more than the file,
/// unless links lead in a circle.
#[derive(Clone, Copy, Debug)]
pub struct Walk(u64);

impl Walk {
    pub const fn through(file: &[u8]) -> Self {
        Self(file.len() as u64)
    }

    /// Walks through a block.
    pub fn step(&mut self, block: &Block<'_>) -> Result<(), Flaw> {
        let circle = "links lead here in a circle, or blocks overlap";
        self.0 = self.0.checked_sub(block.stored()).ok_or(Flaw::told(block.at, circle))?;
        Ok(())
    }
}
