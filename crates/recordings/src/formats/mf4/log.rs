//! The frames of a whole file, in the order of time where they stand in several groups or were written late.

use std::collections::{BTreeSet, VecDeque};

use super::block::{Block, Flaw, Walk, number, tail};
use super::cursor::{Cursor, Next};
use super::group::Groups;
use super::packed::Room;
use super::stream::Unfinished;
use super::window::Window;
use crate::format::blank_frame;
use crate::reason::Reason;
use tertius_core::frame::Frame;

/// Most bytes of something bad that are shown.
const SHOWN: usize = 64;
/// Where the head of a measurement stands.
const HEADER: u64 = 64;
/// Where the file says what was never finished.
const UNFINISHED: usize = 60;
/// Most places that are read at the same time. Each may hold an unpacked block.
const MOST: usize = 64;

/// The next frame of a group, or of several that are in the order of time together.
#[derive(Debug)]
struct Ahead {
    cursor: Cursor,
    /// The set of groups whose data it reads.
    set: usize,
    frame: Frame,
    /// Its channel, once it is read.
    channel: Option<u64>,
}

/// A measurement.
#[derive(Debug)]
pub struct Log {
    /// What was wrong before the first record.
    flaws: VecDeque<Flaw>,
    groups: Vec<Ahead>,
    /// Flaws for which data of a set cannot be read any more, each of which is met by all readers of the set: the set and
    /// the place.
    met: BTreeSet<(usize, u64)>,
    /// Frames that wait for those that were written late.
    window: Window,
    /// Whether its times count from 1970.
    pub absolute: bool,
}

impl Log {
    /// Finds the groups of a file.
    pub fn open(file: &[u8]) -> Self {
        let (mut flaws, mut groups, mut start) = (Vec::new(), Vec::new(), 0);
        if let Err(flaw) = find(file, &mut start, &mut groups, &mut flaws) {
            flaws.push(flaw.losing());
        }
        let unfinished = unfinished(file, groups.len());
        if groups.is_empty() && flaws.is_empty() {
            let told =
                "the file has no group of CAN frames: bus logging is read, decoded signals are not";
            flaws.push(Flaw::told(HEADER, told));
        }
        let most = groups.iter().map(Groups::readers_apart).sum::<usize>().min(MOST);
        let how = (unfinished, Room::of(most));
        let open = |groups| Cursor::new(file, groups, how, start);
        let mut room = MOST.saturating_sub(groups.iter().map(Groups::readers).sum());
        let mut readers = Vec::new();
        for (set, groups) in groups.into_iter().enumerate() {
            let more = groups.readers_apart() - groups.readers();
            // Groups with data in common may have been written in turn, each when its buffer was full.
            let is_apart = more > 0 && more <= room && !open(groups.clone()).are_in_order(file);
            room -= if is_apart { more } else { 0 };
            let parts = if is_apart { groups.apart() } else { vec![groups] };
            let ahead = |cursor| Ahead { cursor, set, frame: blank_frame(), channel: None };
            readers.extend(parts.into_iter().map(open).map(ahead));
        }
        let (flaws, met, window) = (flaws.into(), BTreeSet::new(), Window::default());
        Self { flaws, groups: readers, met, window, absolute: start != 0 }
    }

    /// Reads on to the next frame in the order of time, which is written into `frame`, or to what is none.
    pub fn next(&mut self, file: &[u8], frame: &mut Frame) -> Next {
        while !self.window.is_full() {
            match self.next_record(file, frame) {
                Next::Frame(channel) => self.window.put(frame.clone(), channel),
                Next::End => break,
                other => return other,
            }
        }
        let Some((next, channel)) = self.window.take() else { return Next::End };
        *frame = next;
        Next::Frame(channel)
    }

    /// Reads the next record of all groups; a frame is written into `frame`.
    fn next_record(&mut self, file: &[u8], frame: &mut Frame) -> Next {
        if let Some(flaw) = self.flaws.pop_front() {
            return Next::Bad(flaw);
        }
        while let Some(place) = self.groups.iter().position(|ahead| ahead.channel.is_none()) {
            let ahead = &mut self.groups[place];
            match ahead.cursor.next(file, &mut ahead.frame) {
                Next::Frame(channel) => ahead.channel = Some(channel),
                Next::End => drop(self.groups.remove(place)),
                Next::Bad(flaw) => {
                    let ends = flaw.loses || matches!(flaw.reason, Reason::Incomplete);
                    let set = ahead.set;
                    if !ends || self.met.insert((set, flaw.at)) {
                        return Next::Bad(flaw);
                    }
                }
                Next::Other => return Next::Other,
            }
        }
        let Some(first) = self.groups.iter_mut().min_by_key(|ahead| ahead.frame.timestamp) else {
            return Next::End;
        };
        std::mem::swap(frame, &mut first.frame);
        first.channel.take().map_or(Next::Other, Next::Frame)
    }
}

/// What was never finished of a file with so many sets of groups.
fn unfinished(file: &[u8], sets: usize) -> Unfinished {
    if !file.starts_with(b"UnFinMF ") {
        return Unfinished::default();
    }
    let is = |bit: u32| number(file, UNFINISHED, 2).unwrap_or(0) >> bit & 1 != 0;
    // Which set blocks behind a list are of, is known where there is one set.
    Unfinished { length: is(2), list: is(4) && sets == 1, offsets: is(6) }
}

/// Finds the sets of groups that have frames, and the start since 1970, ns.
fn find(
    file: &[u8],
    start: &mut i64,
    sets: &mut Vec<Groups>,
    flaws: &mut Vec<Flaw>,
) -> Result<(), Flaw> {
    let header = Block::of(file, HEADER, b"HD", "the head of a measurement, ##HD")?;
    let nanos = number(header.data, 0, 8).and_then(|nanos| i64::try_from(nanos).ok());
    let expected = "a start between 1970 and 2261";
    *start = nanos.ok_or(Flaw::expected(file, header.data_at(), expected))?;
    let (mut walk, mut next, mut readers) = (Walk::through(file), header.link(0), 0);
    while next != 0 {
        let block = Block::of(file, next, b"DG", "a group of data, ##DG")?;
        walk.step(&block)?;
        next = block.link(0);
        let groups = Groups::of(file, &block, &mut walk, flaws)?;
        let needed = groups.readers();
        if needed == 0 || groups.data == 0 {
            continue;
        }
        readers += needed;
        if readers > MOST {
            let told = "the frames of the file are in more than 64 places at the same time";
            return Err(Flaw::told(block.at, told));
        }
        sets.push(groups);
    }
    Ok(())
}

/// The bytes that are shown of a flaw.
pub fn shown(file: &[u8], at: u64) -> &[u8] {
    let bytes = tail(file, at);
    &bytes[..bytes.len().min(SHOWN)]
}
