//! Groups of channels: how the records of a group become frames.

use std::collections::BTreeMap;

use super::block::{Block, Flaw, Walk, number, text};
use super::field::{Channel, Clock, Quantity, RecordField};
use super::stream::is_apart;

/// Longest record of a frame. A payload has 64 bytes at the most.
const MOST: usize = 4096;
/// Most groups with data in common.
const GROUPS: usize = 1024;
/// Most flaws of groups that are told; every one leaves a group out.
const FLAWS: usize = 256;
/// The flag of a group whose records are data of variable length, of a channel in another group.
const VARIABLE: u64 = 1;
/// What a source of the type bus says that it is.
const CAN: u8 = 2;

/// What the frames of a group are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carries {
    Data,
    Remote,
    Error,
}

/// The channels of frames in bus logging.
const NAMES: [(&[u8], Carries); 3] = [
    (b"CAN_DataFrame", Carries::Data),
    (b"CAN_RemoteFrame", Carries::Remote),
    (b"CAN_ErrorFrame", Carries::Error),
];

/// Where the payload of a frame is.
#[derive(Clone, Copy, Debug)]
pub enum Payload {
    Nowhere,
    /// In the record: its first byte, and room.
    Fixed(usize, usize),
    /// Elsewhere: at the offset that the field tells, behind the link, which leads to data or to a group.
    Variable(RecordField, u64),
}

/// How a record becomes a frame.
#[derive(Clone, Debug)]
pub struct Layout {
    pub carries: Carries,
    /// Bytes of a record.
    pub length: usize,
    pub clock: Clock,
    pub payload: Payload,
    /// By [`FramePart`].
    parts: [Option<Quantity>; FramePart::NAMES.len()],
}

/// The parts of a frame that are numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FramePart {
    BusChannel,
    Id,
    Ide,
    Dlc,
    DataLength,
    Edl,
    Brs,
    Esi,
}

impl FramePart {
    /// Names of their channels behind that of the frame's, by number.
    const NAMES: [&[u8]; 8] =
        [b"BusChannel", b"ID", b"IDE", b"DLC", b"DataLength", b"EDL", b"BRS", b"ESI"];
}

impl Layout {
    const fn is_variable(&self) -> bool {
        matches!(self.payload, Payload::Variable(..))
    }

    /// The number in a record; `None` if frames of the group have none.
    pub fn number(&self, part: FramePart, record: &[u8]) -> Option<u64> {
        self.parts[part as usize].as_ref().map(|part| part.of(record))
    }
}

/// A group.
#[derive(Clone, Debug)]
pub enum Group {
    Frames(Box<Layout>),
    /// Data of variable length; the place of the group's block.
    Variable(u64),
    /// Something else, in records of this length.
    Other(u64),
    /// Frames, or something else, that another reader of the same data takes, in records of this length.
    Elsewhere(u64),
}

/// The groups with data in common, by the numbers that their records begin with.
#[derive(Clone, Debug)]
pub struct Groups {
    /// Bytes of such a number; 0 where there is one group.
    pub id_bytes: usize,
    pub all: BTreeMap<u64, Group>,
    /// Where the data are.
    pub data: u64,
}

impl Groups {
    /// The groups of a DG block. Groups that cannot be read are told and left out.
    pub fn of(
        file: &[u8],
        block: &Block<'_>,
        walk: &mut Walk,
        flaws: &mut Vec<Flaw>,
    ) -> Result<Self, Flaw> {
        let id_bytes = number(block.data, 0, 1).unwrap_or(0) as usize;
        if !matches!(id_bytes, 0 | 1 | 2 | 4 | 8) {
            let expected = "the length of record numbers, 0, 1, 2, 4 or 8";
            return Err(Flaw::expected(file, block.data_at(), expected));
        }
        let (mut all, mut next, data) = (BTreeMap::new(), block.link(1), block.link(2));
        let is_apart = is_apart(file, data);
        while next != 0 {
            let group = Block::of(file, next, b"CG", "a group of channels, ##CG")?;
            walk.step(&group)?;
            if all.len() == GROUPS {
                return Err(Flaw::told(next, "more than 1024 groups have their data in common"));
            }
            next = group.link(0);
            let id = number(group.data, 0, 8).unwrap_or(0);
            let length = length(&group, is_apart);
            let read = read(file, &group, length, walk).unwrap_or_else(|flaw| {
                if flaws.len() < FLAWS {
                    flaws.push(flaw.losing());
                }
                Group::Other(length)
            });
            if all.insert(if id_bytes == 0 { 0 } else { id }, read).is_some() {
                let told = "two groups have the same record number, or links lead here in a circle";
                return Err(Flaw::told(group.at, told));
            }
        }
        Ok(Self { id_bytes, all, data })
    }

    /// How many places of the file are read at the same time for frames: none where no group has any.
    pub fn readers(&self) -> usize {
        let frames = self.frames().map(|layout| usize::from(layout.is_variable()));
        frames.fold(0, |readers, variable| readers.max(1) + variable)
    }

    /// The same, if each group of frames has a reader of its own.
    pub fn readers_apart(&self) -> usize {
        self.frames().map(|layout| 1 + usize::from(layout.is_variable())).sum()
    }

    fn frames(&self) -> impl Iterator<Item = &Layout> {
        self.all.values().filter_map(|group| match group {
            Group::Frames(layout) => Some(&**layout),
            _ => None,
        })
    }

    /// The groups for one reader for each group of frames. The first reader has what is of no frames, too.
    pub fn apart(&self) -> Vec<Self> {
        let is_frames = |(_, group): &(&u64, &Group)| matches!(group, Group::Frames(_));
        let ids = self.all.iter().filter(is_frames).map(|(id, _)| *id);
        let only = |(n, id): (usize, u64)| {
            let mut groups = self.clone();
            for (other, group) in &mut groups.all {
                *group = match group {
                    Group::Frames(layout) if *other != id => Group::Elsewhere(layout.length as u64),
                    Group::Other(length) if n > 0 => Group::Elsewhere(*length),
                    _ => continue,
                };
            }
            groups
        };
        ids.enumerate().map(only).collect()
    }
}

/// Bytes of a group's records: its values, and the marks of invalid ones unless those stand apart.
fn length(group: &Block<'_>, is_apart: bool) -> u64 {
    let part = |at| number(group.data, at, 4).unwrap_or(0);
    part(24) + if is_apart { 0 } else { part(28) }
}

/// Reads a group whose records have a length.
fn read(file: &[u8], group: &Block<'_>, length: u64, walk: &mut Walk) -> Result<Group, Flaw> {
    if number(group.data, 16, 2).unwrap_or(0) & VARIABLE != 0 {
        return Ok(Group::Variable(group.at));
    }
    let other = Ok(Group::Other(length));
    if !may_be_can(file, group.link(3)) {
        return other;
    }
    let (mut master, mut frames) = (None, None);
    let mut next = group.link(1);
    while next != 0 {
        let channel = channel(file, next, walk)?;
        next = channel.next;
        let name = text(file, channel.name);
        if channel.kind == 2 && channel.sync == 1 {
            master = Some(channel);
        } else if let Some((name, carries)) = NAMES.iter().find(|(known, _)| *known == name) {
            frames = Some((*name, *carries, channel));
        }
    }
    let Some((name, carries, frames)) = frames else { return other };
    let Some(master) = master else {
        let told = "a group of CAN frames is read if it has a channel of times";
        return Err(Flaw::told(group.at, told));
    };
    let length = usize::try_from(length).unwrap_or(usize::MAX);
    if length > MOST {
        return Err(Flaw::told(group.at, "records of CAN frames of more than 4096 bytes"));
    }
    let clock = Clock::of(file, &master, length)?;
    let (payload, parts) = (Payload::Nowhere, Default::default());
    let mut layout = Layout { carries, length, clock, payload, parts };
    layout.add_all(file, name, &frames, walk)?;
    Ok(Group::Frames(Box::new(layout)))
}

impl Layout {
    /// Adds the parts of the channel `frames`, whose names begin with its `name`.
    fn add_all(
        &mut self,
        file: &[u8],
        name: &[u8],
        frames: &Channel,
        walk: &mut Walk,
    ) -> Result<(), Flaw> {
        let mut next = frames.parts;
        while next != 0 {
            let channel = channel(file, next, walk)?;
            next = channel.next;
            let part = text(file, channel.name);
            let part = part.strip_prefix(name).and_then(|part| part.strip_prefix(b"."));
            self.add(file, part.unwrap_or_default(), &channel)?;
        }
        if self.carries != Carries::Error && self.parts[FramePart::Id as usize].is_none() {
            let told = "a group of CAN frames is read if it has a channel of identifiers";
            return Err(Flaw::told(frames.at, told));
        }
        Ok(())
    }

    /// Adds a part of the frame.
    fn add(&mut self, file: &[u8], part: &[u8], channel: &Channel) -> Result<(), Flaw> {
        if let Some(place) = FramePart::NAMES.iter().position(|name| *name == part) {
            self.parts[place] = Some(Quantity::new(file, channel, self.length)?);
        } else if part == b"DataBytes" && self.carries == Carries::Data {
            self.payload = match channel.kind {
                0 | 5 => {
                    let (first, room) = channel.bytes(self.length)?;
                    Payload::Fixed(first, room)
                }
                1 => Payload::Variable(channel.offset(self.length)?, channel.data),
                _ => {
                    let told = "data bytes are read of a fixed or variable length (VLSD)";
                    return Err(Flaw::told(channel.at, told));
                }
            };
        }
        Ok(())
    }
}

fn channel(file: &[u8], at: u64, walk: &mut Walk) -> Result<Channel, Flaw> {
    let block = Block::of(file, at, b"CN", "a channel, ##CN")?;
    walk.step(&block)?;
    Channel::of(file, &block)
}

/// Whether a source may be of CAN, since it is, or since nothing is said of it.
fn may_be_can(file: &[u8], at: u64) -> bool {
    let source = Block::of(file, at, b"SI", "a source").ok();
    source.and_then(|source| source.data.get(1).copied()).is_none_or(|bus| matches!(bus, 0 | CAN))
}
