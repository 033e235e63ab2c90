//! Data of variable length, to which a frame's record tells the offset.

use super::block::{Flaw, number};
use super::group::{Group, Groups};
use super::stream::Stream;
use crate::bus::reason::Reason;

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

    /// The data at an offset.
    ///
    /// # Errors They are before those that were read, too long, or not there.
    pub fn at(&mut self, file: &[u8], groups: &Groups, offset: u64) -> Result<&[u8], Reason> {
        let offset = if self.in_order { self.offset } else { offset };
        if self.newest.is_none_or(|(newest, _)| newest != offset) {
            let told = "the payload's offset is not that of a payload behind the one before it";
            loop {
                if offset < self.offset {
                    return Err(Reason::Told(told));
                }
                if self.group.is_none() {
                    let gap = offset - self.offset;
                    self.stream.skip(file, gap).map_err(|flaw| flaw.reason)?;
                    self.offset = offset;
                }
                let begin = self.offset;
                self.next(file, groups).map_err(|flaw| flaw.reason)?;
                if begin == offset {
                    break;
                }
            }
        }
        match self.newest {
            Some((_, None)) => Ok(&self.bytes),
            Some((_, Some(reason))) => Err(reason),
            None => Err(Reason::Incomplete),
        }
    }

    /// Reads the next data.
    fn next(&mut self, file: &[u8], groups: &Groups) -> Result<(), Flaw> {
        let at = self.stream.place();
        let incomplete = Flaw { at, reason: Reason::Incomplete };
        if let Some(group) = self.group {
            self.find(file, groups, group)?;
        }
        if !self.stream.read(file, LENGTH, &mut self.bytes)? {
            return Err(incomplete);
        }
        let length = number(&self.bytes, 0, LENGTH).unwrap_or(0);
        let is_whole = if length > MOST {
            self.stream.skip(file, length)?
        } else {
            self.stream.read(file, length as usize, &mut self.bytes)?
        };
        if !is_whole {
            return Err(incomplete);
        }
        self.newest = Some((self.offset, (length > MOST).then_some(Reason::FdTooLong)));
        self.offset += LENGTH as u64 + length;
        Ok(())
    }

    /// Goes to the length in the next record of a group.
    fn find(&mut self, file: &[u8], groups: &Groups, wanted: u64) -> Result<(), Flaw> {
        loop {
            let at = self.stream.place();
            let incomplete = Flaw { at, reason: Reason::Incomplete };
            if !self.stream.read(file, groups.id_bytes, &mut self.bytes)? {
                return Err(incomplete);
            }
            let id = number(&self.bytes, 0, groups.id_bytes).unwrap_or(0);
            let length = match groups.all.get(&id) {
                Some(Group::Variable(group)) if *group == wanted => return Ok(()),
                Some(Group::Variable(_)) => {
                    if !self.stream.read(file, LENGTH, &mut self.bytes)? {
                        return Err(incomplete);
                    }
                    number(&self.bytes, 0, LENGTH).unwrap_or(0)
                }
                Some(Group::Frames(layout)) => layout.length as u64,
                Some(Group::Other(length)) => *length,
                None => {
                    self.stream.give_up();
                    return Err(incomplete);
                }
            };
            if !self.stream.skip(file, length)? {
                return Err(incomplete);
            }
        }
    }
}
