//! The data of a group, in one block or in a list of them, as one row of bytes.

use super::block::{Block, Flaw, HEAD, Walk, number, tail};
use super::packed::{self, Room};
use crate::reason::Reason;

/// What of a file was never finished.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unfinished {
    /// The last data block does not tell its length: it reaches to the end of the file.
    pub length: bool,
    /// The last list does not have all data blocks: more may follow behind one another.
    pub list: bool,
    /// What is of variable length is found by its order, not by its offset.
    pub offsets: bool,
}

/// Bytes that come next.
#[derive(Clone, Debug)]
enum Part {
    /// Of the file, between these places.
    Stored { next: usize, end: usize },
    /// Of a compressed block at a place.
    Unpacked { bytes: Vec<u8>, next: usize, at: u64 },
}

impl Part {
    /// The bytes that are left, and how many there were before them.
    fn rest<'a>(&'a mut self, file: &'a [u8]) -> (&'a [u8], &'a mut usize) {
        match self {
            Self::Stored { next, end } => (&file[*next..*end], next),
            Self::Unpacked { bytes, next, .. } => (&bytes[*next..], next),
        }
    }
}

/// A list of data blocks that is being read: its place, which link is next, and the first one that leads to no data.
#[derive(Clone, Copy, Debug)]
struct List {
    at: u64,
    link: usize,
    last: usize,
}

/// The data behind a link.
#[derive(Clone, Debug)]
pub struct Stream {
    unfinished: Unfinished,
    room: Room,
    /// A block that comes next, before those of the list.
    block: u64,
    list: Option<List>,
    part: Part,
    walk: Walk,
    /// Where a block would be that an unfinished list does not have.
    behind: u64,
    /// Kind of the blocks.
    kind: Option<[u8; 2]>,
    /// What is told at the end.
    cut: Option<Flaw>,
}

/// Links of a list before those to its blocks: the next list.
const FIRST: usize = 1;

impl Stream {
    pub fn new(file: &[u8], link: u64, unfinished: Unfinished, room: Room) -> Self {
        let part = Part::Stored { next: 0, end: 0 };
        let walk = Walk::through(file);
        Self {
            unfinished,
            room,
            block: link,
            list: None,
            part,
            walk,
            behind: 0,
            kind: None,
            cut: None,
        }
    }

    /// Place of the next byte, or of the compressed block that it is in.
    pub fn place(&self) -> u64 {
        match &self.part {
            Part::Stored { next, .. } => *next as u64,
            Part::Unpacked { at, .. } => *at,
        }
    }

    /// Leaves the rest out, since it cannot be read.
    pub fn give_up(&mut self) {
        (self.block, self.list, self.cut) = (0, None, None);
        self.part = Part::Stored { next: 0, end: 0 };
        self.unfinished.list = false;
    }

    /// Reads `length` bytes into `bytes`; false at the end, where nothing is left.
    ///
    /// # Errors
    /// The data end within these bytes, or a block cannot be read; nothing can be read after it.
    pub fn read(&mut self, file: &[u8], length: usize, bytes: &mut Vec<u8>) -> Result<bool, Flaw> {
        bytes.clear();
        self.pass(file, length as u64, |part| bytes.extend_from_slice(part))
    }

    /// As [`Self::read`], leaving the bytes out.
    pub fn skip(&mut self, file: &[u8], length: u64) -> Result<bool, Flaw> {
        self.pass(file, length, |_| {})
    }

    fn pass(
        &mut self,
        file: &[u8],
        length: u64,
        mut take: impl FnMut(&[u8]),
    ) -> Result<bool, Flaw> {
        let (mut left, begin) = (length, self.place());
        while left > 0 {
            if !self.ahead(file)? {
                let incomplete = Flaw::of(begin, Reason::Incomplete);
                return if left == length { Ok(false) } else { Err(incomplete) };
            }
            let (bytes, next) = self.part.rest(file);
            let part = bytes.len().min(usize::try_from(left).unwrap_or(usize::MAX));
            take(&bytes[..part]);
            *next += part;
            left -= part as u64;
        }
        Ok(true)
    }

    /// Goes to the block that the next byte is in; false at the end.
    ///
    /// # Errors
    /// A block cannot be read; nothing can be read after it.
    pub fn ahead(&mut self, file: &[u8]) -> Result<bool, Flaw> {
        while self.part.rest(file).0.is_empty() {
            match self.refill(file) {
                Ok(true) => {}
                Ok(false) => return Ok(false),
                Err(flaw) => {
                    self.give_up();
                    return Err(flaw.losing());
                }
            }
        }
        Ok(true)
    }

    /// Goes to the next block of data; false at the end.
    fn refill(&mut self, file: &[u8]) -> Result<bool, Flaw> {
        loop {
            let link = std::mem::take(&mut self.block);
            if link != 0 {
                self.open(file, link)?;
                return Ok(true);
            }
            let Some(List { at, link, last }) = self.list else { return self.follow(file) };
            let list = Block::open(file, at)?;
            if link < last {
                self.list = Some(List { at, link: link + 1, last });
                self.block = list.link(link);
            } else {
                self.list = None;
                self.block = list.link(0);
            }
        }
    }

    /// Goes on behind what the lists have.
    fn follow(&mut self, file: &[u8]) -> Result<bool, Flaw> {
        if self.unfinished.list
            && let Ok(block) = Block::open(file, self.behind)
            && Some(block.kind) == self.kind
        {
            self.open(file, self.behind)?;
            return Ok(true);
        }
        self.cut.take().map_or(Ok(false), Err)
    }

    /// Opens a data block or a list of them.
    fn open(&mut self, file: &[u8], at: u64) -> Result<(), Flaw> {
        let block = Block::open(file, at)?;
        self.walk.step(&block)?;
        if block.announced < block.stored() && !self.unfinished.length {
            return Err(Flaw::expected(file, at + 8, "the length of a block, 24 or more"));
        }
        match &block.kind {
            b"HL" | b"DL" | b"LD" if self.list.is_some() => {
                let expected = "a data block: lists lead to each other by their first link only";
                return Err(Flaw::expected(file, at + 2, expected));
            }
            b"HL" => self.block = block.link(0),
            b"DL" | b"LD" => self.list = Some(List { at, link: FIRST, last: last(&block) }),
            b"DT" | b"DV" | b"SD" => self.open_stored(file, &block),
            b"DZ" => {
                let (kind, bytes) = packed::unpack(file, &block, self.room)?;
                self.kind = Some(block.kind);
                self.behind = (at + block.stored()).next_multiple_of(8);
                if matches!(&kind, b"DT" | b"DV" | b"SD") {
                    self.part = Part::Unpacked { bytes, next: 0, at };
                }
            }
            _ => {
                let expected = "a data block, ##DT, ##DV, ##SD, ##DZ, or a list of them";
                return Err(Flaw::expected(file, at + 2, expected));
            }
        }
        Ok(())
    }

    fn open_stored(&mut self, file: &[u8], block: &Block<'_>) {
        let begin = block.data_at() as usize;
        let mut end = begin + block.data.len();
        if self.unfinished.length && block.data.is_empty() && !is_followed(file, end) {
            end = file.len();
        } else if block.stored() < block.announced && !self.unfinished.length {
            let told = "this block announces more bytes than the file has: its end is missing";
            self.cut = Some(Flaw::told(block.at, told));
        }
        self.kind = Some(block.kind);
        self.behind = (end as u64).next_multiple_of(8);
        self.part = Part::Stored { next: begin, end };
    }
}

/// The link of a list behind those to data.
fn last(list: &Block<'_>) -> usize {
    let links = list.links();
    // As many behind them lead to the marks of invalid values, which are of no interest.
    let is_marked = list.kind == *b"LD" && number(list.data, 0, 4).unwrap_or(0) >> 31 != 0;
    if is_marked { FIRST + links.saturating_sub(FIRST) / 2 } else { links }
}

/// Whether the data behind a link stand apart from the marks of invalid values, and not in one record with them.
pub fn is_apart(file: &[u8], link: u64) -> bool {
    Block::open(file, link).is_ok_and(|block| match &block.kind {
        b"DV" | b"LD" => true,
        b"DZ" => block.data.starts_with(b"DV"),
        _ => false,
    })
}

/// Whether another block begins at a place, so that the one before it is empty.
fn is_followed(file: &[u8], at: usize) -> bool {
    let bytes = tail(file, at as u64);
    bytes.len() >= HEAD && bytes.starts_with(b"##") && bytes[4..8] == [0; 4]
}
