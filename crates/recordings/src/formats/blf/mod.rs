//! Vector's Binary Logging Format BLF: objects in containers, most of which are compressed.
//!
//! A file begins with its head, which tells the start as a date in UTC. Containers follow, and objects within them, which
//! may begin in one and end in the next. Objects of CAN become frames; others are left out. A compressed container is
//! inflated whole, up to 16 MiB, and its checksum compared before its objects are used: one that is damaged or cut off is
//! left out and told, and reading goes on at the first object behind it. A container that is not compressed has no
//! checksum.

mod bytes;
mod contents;
mod object;
mod writer;

use crate::encoder::Written;
use crate::format::{End, Format, Item, Numbered, Reader, Unread};
use crate::reason::Reason;
use tertius_core::frame::Frame;

use super::candump::stamp::Stamp;
use super::channels::NumberedName;
use bytes::{CONTAINER_HEAD, FILE_HEAD, expected, u16_at, u32_at, u64_at};
use contents::{Container, Contents, Inflater};
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

/// Most bytes that the head may have.
const MOST_HEAD: usize = 4096;
/// Bytes that are taken at a time, of data and of what is dropped.
const PART: usize = 1 << 12;
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
    /// Data of a container.
    Data(Container),
    /// Bytes of a container that cannot be used, or behind one.
    Dropped { left: usize },
    /// Nothing can be found any more.
    Lost,
}

/// The reader of one log.
#[derive(Default)]
struct Blf {
    state: State,
    /// Bytes of the file that were taken, and its length as its head tells it.
    at: u64,
    length: u64,
    /// Start since 1970, ns; `None` if the head does not tell it.
    start: Option<i64>,
    contents: Contents,
    /// Bytes of a long object that are still to come.
    skipped: usize,
    /// Channel of the newest frame, and the name of its interface.
    channel: u16,
    interface: NumberedName,
}

/// What a step of a reader gives: bytes that were taken, or what is wrong.
enum Step {
    Taken(usize),
    More,
    /// An object that is no frame and should be one.
    Bad(Reason),
    /// A place from which on any number of frames cannot be found.
    Missing {
        at: u64,
        reason: Reason,
    },
    Frame,
}

impl Reader for Blf {
    fn read<'a>(&'a mut self, unread: Unread<'a>, frame: &mut Frame) -> Item<'a> {
        let step = match self.object(frame) {
            Step::More => match self.file(unread) {
                Step::More if unread.end != End::Open => self.end(unread.bytes),
                step => step,
            },
            step => step,
        };
        match step {
            Step::Frame => {
                let interface = self.interface.channel(self.channel.into());
                Item::Frame { taken: 0, interface, absolute: self.start.is_some() }
            }
            Step::Taken(taken) => {
                self.at += taken as u64;
                Item::Nothing { taken }
            }
            Step::More => Item::More,
            Step::Bad(reason) => Item::Bad { shown: 0, taken: 0, reason },
            Step::Missing { at, reason } => Item::BadAt { at, shown: &[], reason, loses: true },
        }
    }
}

impl Blf {
    /// The next object of what the containers have had.
    fn object(&mut self, frame: &mut Frame) -> Step {
        self.contents.mend();
        loop {
            let rest = self.contents.unused();
            if self.skipped > 0 {
                let skipped = self.skipped.min(rest.len());
                self.skipped -= skipped;
                self.contents.take(skipped);
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
                let taken = PADDING + places.position(|it| it == OBJECT).unwrap_or(last);
                self.contents.take(taken);
                return Step::Bad(reason);
            };
            let rest = &rest[begin..];
            let Some(head) = ObjectHead::of(rest) else { return Step::More };
            if head.length < ObjectHead::LENGTH {
                let reason = expected(&rest[8..], "the length of an object, 16 or more");
                self.contents.take(begin + OBJECT.len());
                return Step::Bad(reason);
            }
            if !head.is_can() || head.length > LONGEST_OBJECT {
                let reason = expected(&rest[8..], "the length of a frame's object, at most 4096");
                self.contents.take(begin);
                self.skipped = head.length;
                if head.is_can() {
                    return Step::Bad(reason);
                }
                continue;
            }
            let Some(object) = rest.get(..head.length) else { return Step::More };
            let read = object::read(object, &head, self.start.unwrap_or(0), frame);
            self.contents.take(begin + head.length);
            match read {
                Ok(Some(channel)) => {
                    self.channel = channel;
                    return Step::Frame;
                }
                Ok(None) => {}
                Err(reason) => return Step::Bad(reason),
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
            State::Data(container) => match part(container.left) {
                Some(taken) => self.data(&bytes[..taken]),
                None => Step::More,
            },
        }
    }

    /// What is missing at the end of the file, of which `bytes` are left. It is told once.
    fn end(&mut self, bytes: &[u8]) -> Step {
        let (at, expected) = match &self.state {
            State::Begin | State::Lost => return Step::More,
            State::Data(Container { at, inflater: Some(_), .. }) => {
                (*at, "the rest of a container, which is left out since its checksum is there")
            }
            State::Data(container) => (container.at, "the rest of a container"),
            _ if !bytes.is_empty() => (self.at, "the rest of an object's or container's head"),
            _ if self.skipped > 0 || self.contents.has_begun() => {
                (self.at, "the rest of the last object")
            }
            // A container has at least its head.
            _ if self.length >= self.at + CONTAINER_HEAD as u64 => {
                (self.at, "as many bytes as the log's head tells")
            }
            _ => return Step::More,
        };
        self.state = State::Lost;
        Step::Missing { at, reason: Reason::EndExpected(expected) }
    }

    /// Nothing can be found from `at` on.
    fn lost(&mut self, at: u64, reason: Reason) -> Step {
        self.state = State::Lost;
        Step::Missing { at, reason }
    }

    fn begin(&mut self, bytes: &[u8]) -> Step {
        if bytes.len() < FILE_HEAD {
            return Step::More;
        }
        let length = u32_at(bytes, 4).unwrap_or(0) as usize;
        if !(FILE_HEAD..=MOST_HEAD).contains(&length) {
            let reason = expected(&bytes[4..], "the length of a log's head, 72 to 4096");
            return self.lost(4, reason);
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
        self.length = u64_at(bytes, 16).unwrap_or(0);
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
            let reason = expected(bytes, "an object, which begins with LOBJ and its length");
            return self.lost(self.at, reason);
        }
        let (at, padding) = (self.at, head.length % 4);
        if head.kind != CONTAINER {
            // An object outside of any container is taken as if it were in one.
            let container = Container { at, left: head.length, padding, inflater: None };
            self.state = State::Data(container);
            return self.data(&bytes[..ObjectHead::LENGTH]);
        }
        let Some(method) = u16_at(bytes, 16).filter(|_| bytes.len() >= CONTAINER_HEAD) else {
            return Step::More;
        };
        let left = head.length - CONTAINER_HEAD;
        let inflater = match method {
            0 => None,
            2 => Some(Box::new(Inflater::new())),
            _ => {
                let known = "a container that is compressed by zlib, or not at all";
                return self.lose(at, head.length + padding, expected(&bytes[16..], known));
            }
        };
        self.state = match left {
            0 => State::Dropped { left: padding },
            _ => State::Data(Container { at, left, padding, inflater }),
        };
        Step::Taken(CONTAINER_HEAD)
    }

    /// Takes data of a container.
    fn data(&mut self, data: &[u8]) -> Step {
        let State::Data(container) = &mut self.state else { return Step::More };
        let (at, padding, dropped) = (container.at, container.padding, container.left);
        match self.contents.add(container, data) {
            Ok(()) if container.left == 0 => self.state = State::Dropped { left: padding },
            Ok(()) => {}
            Err(reason) => return self.lose(at, dropped + padding, reason),
        }
        Step::Taken(data.len())
    }

    /// Drops the container `at` a place, of which `dropped` bytes are still to be taken.
    fn lose(&mut self, at: u64, dropped: usize, reason: Reason) -> Step {
        self.contents.lose();
        self.skipped = 0;
        self.state = State::Dropped { left: dropped };
        Step::Missing { at, reason }
    }
}
