//! Data of variable length, to which a frame's record tells the offset.

use super::block::{Flaw, number};
use super::group::{Group, Groups};
use super::stream::Stream;
use crate::reason::Reason;

/// Longest payload of a frame.
const MOST: u64 = 64;
/// Bytes that tell a length.
const LENGTH: usize = 4;

/// The data of one channel, which are read forwards only.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Where they are. Those of a group are among the records of others, and are sought by a reader of their own, since
    /// nobody says whether they stand before or behind the record that needs them.
    stream: Stream,
    /// Place of the group's block.
    group: Option<u64>,
    /// Offset of what comes next.
    offset: u64,
    /// Offset of the newest ones, and whether they could be used.
    newest: Option<(u64, Option<Reason>)>,
    bytes: Vec<u8>,
    /// Whether they are found by their order.
    in_order: bool,
}

impl Variable {
    pub fn new(stream: Stream, group: Option<u64>, in_order: bool) -> Self {
        let in_order = in_order && group.is_some();
        Self { stream, group, offset: 0, newest: None, bytes: Vec::new(), in_order }
    }

    /// The data at an offset, which the record at the place `record` tells.
    ///
    /// # Errors
    /// They are before those that were read, too long, or not there.
    pub fn at(
        &mut self,
        file: &[u8],
        groups: &Groups,
        offset: u64,
        record: u64,
    ) -> Result<&[u8], Flaw> {
        let offset = if self.in_order { self.offset } else { offset };
        if self.newest.is_none_or(|(newest, _)| newest != offset) {
            self.seek(file, groups, offset, record)?;
        }
        match self.newest {
            Some((_, Some(reason))) => Err(Flaw::of(record, reason)),
            _ => Ok(&self.bytes),
        }
    }

    /// Reads on up to the data at an offset.
    fn seek(&mut self, file: &[u8], groups: &Groups, offset: u64, record: u64) -> Result<(), Flaw> {
        loop {
            let Some(gap) = offset.checked_sub(self.offset) else {
                let told = "the payload's offset is not that of a payload behind the one before it";
                return Err(Flaw::told(record, told));
            };
            // Of a group, nobody knows where data begin until they were passed.
            let gap = if self.group.is_none() { gap } else { 0 };
            let begin = self.offset + gap;
            match self.next(file, groups, gap) {
                Ok(true) if begin == offset => return Ok(()),
                Ok(true) => {}
                Err(flaw) if flaw.loses => return Err(flaw),
                Ok(false) | Err(_) => {
                    let told =
                        "the payload is not there: the data of variable length end before it";
                    return Err(Flaw::told(record, told));
                }
            }
        }
    }

    /// Reads the next data behind a gap; false at the end.
    fn next(&mut self, file: &[u8], groups: &Groups, gap: u64) -> Result<bool, Flaw> {
        self.newest = None;
        self.offset += gap;
        if !self.stream.skip(file, gap)? {
            return Ok(false);
        }
        if let Some(group) = self.group
            && !self.find(file, groups, group)?
        {
            return Ok(false);
        }
        if !self.stream.read(file, LENGTH, &mut self.bytes)? {
            return Ok(false);
        }
        let length = number(&self.bytes, 0, LENGTH).unwrap_or(0);
        let is_whole = if length > MOST {
            self.stream.skip(file, length)?
        } else {
            self.stream.read(file, length as usize, &mut self.bytes)?
        };
        if is_whole {
            self.newest = Some((self.offset, (length > MOST).then_some(Reason::FdTooLong)));
        }
        self.offset += LENGTH as u64 + length;
        Ok(is_whole)
    }

    /// Goes to the length in the next record of a group; false at the end.
    fn find(&mut self, file: &[u8], groups: &Groups, wanted: u64) -> Result<bool, Flaw> {
        loop {
            if !self.stream.read(file, groups.id_bytes, &mut self.bytes)? {
                return Ok(false);
            }
            let id = number(&self.bytes, 0, groups.id_bytes).unwrap_or(0);
            let length = match groups.all.get(&id) {
                Some(Group::Variable(group)) if *group == wanted => return Ok(true),
                Some(Group::Variable(_)) => {
                    if !self.stream.read(file, LENGTH, &mut self.bytes)? {
                        return Ok(false);
                    }
                    number(&self.bytes, 0, LENGTH).unwrap_or(0)
                }
                Some(Group::Frames(layout)) => layout.length as u64,
                Some(Group::Other(length) | Group::Elsewhere(length)) => *length,
                None => {
                    // The reader of the records tells it.
                    self.stream.give_up();
                    return Ok(false);
                }
            };
            if !self.stream.skip(file, length)? {
                return Ok(false);
            }
        }
    }
}
