//! Vector's Binary Logging Format BLF: objects in containers, most of which are compressed.
//!
//! A file begins with its head, which tells the start as a date in UTC. Containers follow, and objects within them, which
//! may begin in one and end in the next. Objects of CAN become frames; others are left out. What is inflated is bounded.

mod object;
mod writer;

use crate::bus::encoder::Written;
use crate::bus::format::{End, Format, Item, Numbered, Reader, Unread};
use crate::bus::reason::{Found, Reason};
use crate::frame::Frame;
use flate2::{Decompress, FlushDecompress, Status};

use super::candump::stamp::Stamp;
use super::channels::NumberedName;
use object::{CONTAINER, OBJECT, ObjectHead};

pub static FORMAT: Format = Format {
    name: "a Vector log in BLF",
    numbered: Numbered::Bytes,
    is_whole: false,
    recognise: |head| match head.first_chunk() {
        Some(first) => Some(first == b"LOGG"),
        None => (!b"LOGG".starts_with(head)).then_some(false),
    },
    reader: |_| Box::new(Blf::default()),
    written: Some(Written {
        word: "blf",
        encoder: || Box::new(writer::BlfEncoder::default()),
        explains_errors: false,
        is_packed: true,
    }),
};

/// Bytes of the head that are read, and most bytes that it may have.
const FILE_HEAD: usize = 72;
const MOST_HEAD: usize = 4096;
/// Bytes of a container before its data.
const CONTAINER_HEAD: usize = 32;
/// Bytes that are taken at a time, of data and of what is dropped.
const PART: usize = 1 << 12;
/// Bytes that are inflated at a time.
const INFLATED: usize = 8 * PART;
/// Most bytes that a part may inflate to; zlib reaches a thousandfold.
const MOST_INFLATED: usize = 1100 * PART;
/// Longest object that is looked at; others are dropped.
const LONGEST_OBJECT: usize = 4096;
/// Most bytes between two objects.
const PADDING: usize = 8;

/// What comes next in the file.
#[derive(Default)]
enum State {
    #[default]
    Begin,
    /// An object or container.
    Object,
    /// Data of a container of which these bytes are left.
    Data { left: usize, padding: usize, inflater: Option<Box<Decompress>> },
    /// Bytes of a container that cannot be used.
    Dropped { left: usize },
    /// Nothing can be found any more.
    Lost,
}

/// The reader of one log.
#[derive(Default)]
struct Blf {
    state: State,
    /// Start since 1970, ns; `None` if the head does not tell it.
    start: Option<i64>,
    /// What the containers have had, from its first byte that was not used.
    objects: Vec<u8>,
    used: usize,
    /// Bytes of a long object that are still to come.
    skipped: usize,
    /// What a part of a container inflates to, before it goes to `objects`: [`INFLATED`] bytes once there is one.
    inflated: Vec<u8>,
    /// Channel of the newest frame, and the name of its interface.
    channel: u16,
    interface: NumberedName,
}

/// What a step of a reader gives: bytes that were taken, or what is wrong.
enum Step {
    Taken(usize),
    More,
    Bad { taken: usize, reason: Reason },
    Frame,
}

fn expected(bytes: &[u8], expected: &'static str) -> Reason {
    Reason::Expected { found: Found::first(bytes), expected }
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..).and_then(<[u8]>::first_chunk).map(|bytes| u32::from_le_bytes(*bytes))
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..).and_then(<[u8]>::first_chunk).map(|bytes| u16::from_le_bytes(*bytes))
}

impl Reader for Blf {
    fn read<'a>(&'a mut self, unread: Unread<'a>, frame: &mut Frame) -> Item<'a> {
        let step = match self.object(frame) {
            Step::More => self.file(unread),
            step => step,
        };
        match step {
            Step::Frame => {
                let interface = self.interface.channel(self.channel.into());
                Item::Frame { taken: 0, interface, absolute: self.start.is_some() }
            }
            Step::Taken(taken) => Item::Nothing { taken },
            Step::More => Item::More,
            Step::Bad { taken, reason } => Item::Bad { shown: 0, taken, reason },
        }
    }
}

impl Blf {
    /// The next object of what the containers have had.
    fn object(&mut self, frame: &mut Frame) -> Step {
        loop {
            let rest = &self.objects[self.used..];
            if self.skipped > 0 {
                let skipped = self.skipped.min(rest.len());
                (self.skipped, self.used) = (self.skipped - skipped, self.used + skipped);
                if self.skipped > 0 {
                    return Step::More;
                }
                continue;
            }
            let mut places = rest.windows(OBJECT.len());
            let Some(begin) = places.by_ref().take(PADDING).position(|it| it == OBJECT) else {
                if rest.len() < PADDING + OBJECT.len() {
                    return Step::More;
                }
                let reason = expected(rest, "an object, which begins with LOBJ");
                // It may begin with the last bytes.
                let last = rest.len() - PADDING - (OBJECT.len() - 1);
                self.used += PADDING + places.position(|it| it == OBJECT).unwrap_or(last);
                return Step::Bad { taken: 0, reason };
            };
            self.used += begin;
            let rest = &rest[begin..];
            let Some(head) = ObjectHead::of(rest) else { return Step::More };
            if head.length < ObjectHead::LENGTH {
                self.used += OBJECT.len();
                let reason = expected(&rest[8..], "the length of an object, 16 or more");
                return Step::Bad { taken: 0, reason };
            }
            if !head.is_can() || head.length > LONGEST_OBJECT {
                self.skipped = head.length;
                continue;
            }
            let Some(object) = rest.get(..head.length) else { return Step::More };
            let read = object::read(object, &head, self.start.unwrap_or(0), frame);
            self.used += head.length;
            match read {
                Ok(Some(channel)) => {
                    self.channel = channel;
                    return Step::Frame;
                }
                Ok(None) => {}
                Err(reason) => return Step::Bad { taken: 0, reason },
            }
        }
    }

    /// The next part of the file.
    fn file(&mut self, unread: Unread<'_>) -> Step {
        let bytes = unread.bytes;
        let part = |left: usize| {
            let part = left.min(PART);
            // Of a file that was never finished, what there is of the last container.
            let cut = unread.end != End::Open && !bytes.is_empty();
            if bytes.len() >= part { Some(part) } else { cut.then_some(bytes.len()) }
        };
        match &mut self.state {
            State::Begin => self.begin(bytes),
            State::Object => self.container(bytes),
            State::Lost => part(PART).map_or(Step::More, Step::Taken),
            State::Dropped { left: 0 } => {
                self.state = State::Object;
                self.container(bytes)
            }
            State::Dropped { left } => {
                let Some(taken) = part(*left) else { return Step::More };
                *left -= taken;
                Step::Taken(taken)
            }
            State::Data { left, .. } => match part(*left) {
                Some(taken) => self.data(&bytes[..taken]),
                None => Step::More,
            },
        }
    }

    fn begin(&mut self, bytes: &[u8]) -> Step {
        if bytes.len() < FILE_HEAD {
            return Step::More;
        }
        let length = u32_at(bytes, 4).unwrap_or(0) as usize;
        if !(FILE_HEAD..=MOST_HEAD).contains(&length) {
            self.state = State::Lost;
            let reason = expected(&bytes[4..], "the length of a log's head, 72 to 4096");
            return Step::Bad { taken: FILE_HEAD, reason };
        }
        if bytes.len() < length {
            return Step::More;
        }
        // Year, month, day of the week, day, hours, minutes, seconds, milliseconds.
        let words: Vec<u16> = (0..8).filter_map(|n| u16_at(bytes, 40 + 2 * n)).collect();
        if let [year, month, _, day, hour, minute, second, milli] = words[..] {
            let date = format!(
                "{year:04}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02}.{milli:03}"
            );
            self.start = Stamp::parse(date.as_bytes()).ok().map(|stamp| stamp.nanos);
        }
        self.state = State::Object;
        Step::Taken(length)
    }

    /// What stands in the file itself: a container, or an object outside of any.
    fn container(&mut self, bytes: &[u8]) -> Step {
        if bytes.first() == Some(&0) {
            return Step::Taken(1);
        }
        let Some(head) = ObjectHead::of(bytes) else { return Step::More };
        let least = if head.kind == CONTAINER { CONTAINER_HEAD } else { ObjectHead::LENGTH };
        if !bytes.starts_with(OBJECT) || head.length < least {
            self.state = State::Lost;
            let reason = expected(bytes, "an object, which begins with LOBJ and its length");
            return Step::Bad { taken: ObjectHead::LENGTH, reason };
        }
        let padding = head.length % 4;
        if head.kind != CONTAINER {
            // An object outside of any container is taken as if it were in one.
            self.state = State::Data { left: head.length, padding, inflater: None };
            return self.data(&bytes[..ObjectHead::LENGTH]);
        }
        let Some(method) = u16_at(bytes, 16).filter(|_| bytes.len() >= CONTAINER_HEAD) else {
            return Step::More;
        };
        let left = head.length - CONTAINER_HEAD;
        let step = match method {
            0 => Ok(None),
            2 => Ok(Some(Box::new(Decompress::new(true)))),
            _ => {
                Err(expected(&bytes[16..], "a container that is compressed by zlib, or not at all"))
            }
        };
        match step {
            Ok(inflater) => self.state = State::Data { left, padding, inflater },
            Err(reason) => {
                self.state = State::Dropped { left: left + padding };
                return Step::Bad { taken: CONTAINER_HEAD, reason };
            }
        }
        if left == 0 {
            self.state = State::Dropped { left: padding };
        }
        Step::Taken(CONTAINER_HEAD)
    }

    /// Takes data of a container.
    fn data(&mut self, data: &[u8]) -> Step {
        let State::Data { left, padding, inflater } = &mut self.state else { return Step::More };
        self.objects.drain(..self.used);
        self.used = 0;
        *left -= data.len();
        let (left, padding) = (*left, *padding);
        let result = match inflater {
            Some(inflater) => inflate(inflater, data, &mut self.inflated, &mut self.objects),
            None => {
                self.objects.extend_from_slice(data);
                Ok(())
            }
        };
        if left == 0 || result.is_err() {
            self.state = State::Dropped { left: left + padding };
        }
        match result {
            Ok(()) => Step::Taken(data.len()),
            Err(reason) => Step::Bad { taken: data.len(), reason },
        }
    }
}

/// Adds what `data` inflate to, by way of `room`: the room that a vector has is filled with zeros at each call.
fn inflate(
    inflater: &mut Decompress,
    data: &[u8],
    room: &mut Vec<u8>,
    objects: &mut Vec<u8>,
) -> Result<(), Reason> {
    let damaged = || expected(data, "the data of a container by zlib");
    room.resize(INFLATED, 0);
    let (before, held) = (inflater.total_in(), objects.len());
    loop {
        let (used, had) = ((inflater.total_in() - before) as usize, inflater.total_out());
        let status = inflater.decompress(&data[used..], room, FlushDecompress::None);
        // What comes before damage is sound.
        let more = (inflater.total_out() - had) as usize;
        objects.extend_from_slice(&room[..more]);
        let status = status.map_err(|_| damaged())?;
        let is_full = more == room.len();
        if objects.len() - held > MOST_INFLATED {
            return Err(damaged());
        }
        match status {
            Status::StreamEnd => return Ok(()),
            Status::Ok | Status::BufError if is_full => {}
            Status::Ok | Status::BufError => return Ok(()),
        }
    }
}
