//! The records of groups that have their data in common, one after the other.

use std::collections::BTreeMap;

use super::block::{Flaw, number};
use super::group::{Carries, FramePart, Group, Groups, Layout, Payload};
use super::packed::Room;
use super::stream::{Stream, Unfinished};
use super::variable::Variable;
use crate::format::{FD_LENGTHS, blank_frame, is_fd_length};
use crate::reason::Reason;
use tertius_core::frame::{Frame, Id, Kind};
use tertius_core::time::Timestamp;

/// The bit of an identifier that has 29 bits, where no channel tells that.
const EXTENDED: u64 = 1 << 31;
const IDENTIFIER: u64 = (1 << 29) - 1;
/// Class of error frames in linux/can/error.h: a fault on the bus.
const BUS_ERROR: u32 = 0x080;
/// Bytes of the length before data of variable length.
const LENGTH: usize = 4;

/// What the next record is.
#[derive(Clone, Copy, Debug)]
pub enum Next {
    /// A frame of this channel.
    Frame(u64),
    /// A record of another kind.
    Other,
    Bad(Flaw),
    End,
}

/// A place in the data of such groups.
#[derive(Debug)]
pub struct Cursor {
    groups: Groups,
    stream: Stream,
    /// Data of variable length, by the links to them.
    variables: BTreeMap<u64, Variable>,
    record: Vec<u8>,
    /// Start of the measurement since 1970, ns.
    start: i64,
}

impl Cursor {
    pub fn new(file: &[u8], groups: Groups, how: (Unfinished, Room), start: i64) -> Self {
        let (unfinished, room) = how;
        let stream = Stream::new(file, groups.data, unfinished, room);
        let mut variables = BTreeMap::new();
        for group in groups.all.values() {
            let Group::Frames(layout) = group else { continue };
            let Payload::Variable(_, link) = layout.payload else { continue };
            let is_group = |group: &Group| matches!(group, Group::Variable(at) if *at == link);
            let variable = if groups.all.values().any(is_group) {
                Variable::new(stream.clone(), Some(link), unfinished.offsets)
            } else {
                Variable::new(Stream::new(file, link, unfinished, room), None, false)
            };
            variables.insert(link, variable);
        }
        Self { groups, stream, variables, record: Vec::new(), start }
    }

    /// Whether all frames are in the order of time, as far as they can be read.
    pub fn are_in_order(mut self, file: &[u8]) -> bool {
        let (mut frame, mut newest) = (blank_frame(), None);
        loop {
            match self.next(file, &mut frame) {
                Next::Frame(_) if newest.is_some_and(|newest| frame.timestamp < newest) => {
                    return false;
                }
                Next::Frame(_) => newest = Some(frame.timestamp),
                Next::Other | Next::Bad(_) => {}
                Next::End => return true,
            }
        }
    }

    /// Reads the next record; a frame is written into `frame`.
    pub fn next(&mut self, file: &[u8], frame: &mut Frame) -> Next {
        match self.record(file, frame) {
            Ok(next) => next,
            Err(flaw) => Next::Bad(flaw),
        }
    }

    fn record(&mut self, file: &[u8], frame: &mut Frame) -> Result<Next, Flaw> {
        let Self { groups, stream, variables, record, start } = self;
        loop {
            if !stream.ahead(file)? {
                return Ok(Next::End);
            }
            let begin = stream.place();
            let incomplete = Flaw::of(begin, Reason::Incomplete);
            stream.read(file, groups.id_bytes, record)?;
            let id = number(record, 0, groups.id_bytes).unwrap_or(0);
            let is_whole = match groups.all.get(&id) {
                Some(Group::Frames(layout)) => {
                    if !stream.read(file, layout.length, record)? {
                        return Err(incomplete);
                    }
                    let payload = match layout.payload {
                        Payload::Nowhere => &[][..],
                        Payload::Fixed(first, room) => &record[first..first + room],
                        Payload::Variable(offset, link) => {
                            let variable = variables.get_mut(&link).ok_or(incomplete)?;
                            variable.at(file, groups, offset.of(record), begin)?
                        }
                    };
                    let filled = fill(layout, record, payload, *start, frame);
                    filled.map_err(|reason| Flaw::of(begin, reason))?;
                    let channel = layout.number(FramePart::BusChannel, record);
                    return Ok(Next::Frame(channel.unwrap_or(1)));
                }
                Some(Group::Variable(_)) => {
                    let is_whole = stream.read(file, LENGTH, record)?;
                    is_whole && stream.skip(file, number(record, 0, LENGTH).unwrap_or(0))?
                }
                Some(Group::Other(length)) if stream.skip(file, *length)? => {
                    return Ok(Next::Other);
                }
                Some(Group::Elsewhere(length)) => stream.skip(file, *length)?,
                Some(Group::Other(_)) => false,
                None => {
                    stream.give_up();
                    let expected = "the number of a group of this file";
                    return Err(Flaw::expected(file, begin, expected).losing());
                }
            };
            if !is_whole {
                return Err(incomplete);
            }
        }
    }
}

/// Makes a record a frame.
fn fill(
    layout: &Layout,
    record: &[u8],
    payload: &[u8],
    start: i64,
    frame: &mut Frame,
) -> Result<(), Reason> {
    let number = |part| layout.number(part, record);
    let is = |part| number(part).is_some_and(|value| value != 0);
    let nanos = layout.clock.nanos(record)?.checked_add(start).ok_or(Reason::StampRange)?;
    frame.timestamp = Timestamp::from_nanos(nanos);
    frame.set_length(0);
    if layout.carries == Carries::Error {
        frame.id = Id::extended(BUS_ERROR).ok_or(Reason::ExtendedRange(BUS_ERROR))?;
        frame.kind = Kind::Error;
        return Ok(());
    }
    let word = number(FramePart::Id).unwrap_or(0);
    let value = (word & IDENTIFIER) as u32;
    frame.id = if is(FramePart::Ide) || word & EXTENDED != 0 {
        Id::extended(value).ok_or(Reason::ExtendedRange(value))?
    } else {
        Id::standard(value).ok_or(Reason::StandardRange(value))?
    };
    let is_fd = is(FramePart::Edl);
    let room = if is_fd { &FD_LENGTHS[..] } else { &FD_LENGTHS[..9] };
    let coded = number(FramePart::Dlc).map(|code| room[(code as usize).min(room.len() - 1)] as u64);
    if layout.carries == Carries::Remote {
        // Of how many bytes the requested frame is, tells its code first: a remote frame has no data.
        let length = coded.or(number(FramePart::DataLength)).unwrap_or(0).min(8) as u8;
        frame.kind = Kind::Remote { length };
        return Ok(());
    }
    frame.kind = if is_fd {
        Kind::Fd { flags: u8::from(is(FramePart::Brs)) | u8::from(is(FramePart::Esi)) << 1 }
    } else {
        Kind::Data
    };
    fill_data(frame, payload, number(FramePart::DataLength).or(coded))
}

/// Gives a frame the data of its length, which are all where none is told.
fn fill_data(frame: &mut Frame, payload: &[u8], length: Option<u64>) -> Result<(), Reason> {
    let length = length.map_or(payload.len(), |told| usize::try_from(told).unwrap_or(usize::MAX));
    match frame.kind {
        Kind::Fd { .. } if !is_fd_length(length) => return Err(Reason::FdLength(length)),
        Kind::Data if length > 8 => return Err(Reason::ClassicLength),
        _ => {}
    }
    let mismatch = Reason::LengthMismatch { announced: length, found: payload.len() };
    let data = payload.get(..length).ok_or(mismatch)?;
    frame.buffer_mut()[..length].copy_from_slice(data);
    frame.set_length(length);
    Ok(())
}
