//! Writes Vector's Binary Logging Format BLF, in containers that are compressed by zlib.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::bytes::{CONTAINER_HEAD, FILE_HEAD};
use super::object::{
    BRS, CONTAINER, ERROR_EXTENDED, ESI, EXTENDED, FD, FD_MESSAGE, MESSAGE, OBJECT, REMOTE,
};
use crate::encoder::{FrameEncoder, Unsayable};
use crate::format::fd_code;
use crate::formats::channels::Channels;
use crate::formats::civil::{CivilTime, start_of};
use tertius_core::frame::{Frame, Kind, MAX_DATA};

/// Length of the head with its reserve, bytes.
const HEAD: usize = 144;
/// Bytes of objects from which on a container is written.
const CONTAINER_SIZE: usize = 128 * 1024;
/// Length of an object's head with its time, bytes.
const OBJECT_HEAD: usize = 32;
/// The flag of time stamps in nanoseconds.
const NANOSECONDS: u32 = 2;
/// Compression of containers: zlib.
const ZLIB: u16 = 2;
/// Which program wrote it: none of Vector's. And the version of the format that is written, with its own figures.
const PROGRAM: u8 = 5;
const VERSION: [u8; 4] = [2, 6, 8, 1];

/// The encoder of one log.
#[derive(Default)]
pub struct BlfEncoder {
    /// Start since 1970, ns, once there was a frame; and the time of the latest frame.
    start: Option<i64>,
    stop: i64,
    channels: Channels,
    /// Objects that are in no container yet.
    objects: Vec<u8>,
    count: u32,
    /// Bytes of the file so far, and as many as it had if nothing were compressed.
    written: u64,
    unpacked: u64,
}

impl FrameEncoder for BlfEncoder {
    fn add(
        &mut self,
        interface: &str,
        frame: &Frame,
        bytes: &mut Vec<u8>,
    ) -> Result<(), Unsayable> {
        let nanos = frame.timestamp.as_nanos();
        let start = match self.start {
            Some(start) => start,
            None => self.begin(nanos, bytes),
        };
        if nanos < start {
            return Err(Unsayable::BeforeStart);
        }
        let channel = self.channels.number(interface).ok_or(Unsayable::Channel)?;
        self.stop = self.stop.max(nanos);
        self.object(channel, nanos.abs_diff(start), frame);
        if self.objects.len() >= CONTAINER_SIZE {
            self.container(bytes);
        }
        Ok(())
    }

    fn finish(&mut self, bytes: &mut Vec<u8>) -> Option<Vec<u8>> {
        if !self.objects.is_empty() {
            self.container(bytes);
        }
        Some(self.head())
    }

    fn channels(&self) -> &[(String, u16)] {
        self.channels.all()
    }
}

impl BlfEncoder {
    /// Writes the head as far as it is known; returns the start.
    fn begin(&mut self, nanos: i64, bytes: &mut Vec<u8>) -> i64 {
        let start = start_of(nanos);
        (self.start, self.stop) = (Some(start), nanos);
        (self.written, self.unpacked) = (HEAD as u64, HEAD as u64);
        bytes.extend(self.head());
        start
    }

    fn head(&self) -> Vec<u8> {
        let mut head = Vec::with_capacity(HEAD);
        head.extend_from_slice(b"LOGG");
        head.extend((HEAD as u32).to_le_bytes());
        head.extend([PROGRAM, 0, 0, 0]);
        head.extend(VERSION);
        head.extend(self.written.to_le_bytes());
        head.extend(self.unpacked.to_le_bytes());
        head.extend(self.count.to_le_bytes());
        head.extend(0_u32.to_le_bytes());
        for nanos in [self.start.unwrap_or(0), self.stop] {
            let at = CivilTime::of(nanos);
            let CivilTime { year, month, day, weekday, hour, minute, second, milli } = at;
            for part in [year, month, weekday, day, hour, minute, second, milli] {
                head.extend((part as u16).to_le_bytes());
            }
        }
        debug_assert_eq!(head.len(), FILE_HEAD);
        head.resize(HEAD, 0);
        head
    }

    /// Adds a frame, `since` the start, ns.
    fn object(&mut self, channel: u16, since: u64, frame: &Frame) {
        let body = body(channel, frame);
        let (kind, length) = (kind(frame), OBJECT_HEAD + body.len());
        let objects = &mut self.objects;
        begin_object(objects, OBJECT_HEAD, length, kind);
        objects.extend(NANOSECONDS.to_le_bytes());
        // The client, and the version of the object.
        objects.extend([0; 4]);
        objects.extend(since.to_le_bytes());
        // Every body is of a multiple of four bytes, so that nothing stands between two objects.
        objects.extend(body);
        self.count = self.count.saturating_add(1);
    }

    /// Writes a container of the objects so far.
    fn container(&mut self, bytes: &mut Vec<u8>) {
        let mut packer = ZlibEncoder::new(Vec::new(), Compression::default());
        let packed = packer.write_all(&self.objects).and_then(|()| packer.finish());
        let packed = packed.expect("a vector takes all bytes");
        let (before, length) = (bytes.len(), CONTAINER_HEAD + packed.len());
        begin_object(bytes, super::object::ObjectHead::LENGTH, length, CONTAINER);
        bytes.extend(ZLIB.to_le_bytes());
        bytes.extend([0; 6]);
        bytes.extend((self.objects.len() as u32).to_le_bytes());
        bytes.extend([0; 4]);
        bytes.extend(packed);
        bytes.resize(bytes.len() + length % 4, 0);
        self.written += (bytes.len() - before) as u64;
        self.unpacked += (CONTAINER_HEAD + self.objects.len()) as u64;
        self.objects.clear();
    }
}

/// Appends what every object begins with: its signature, the length of its head, the version of the head, its own
/// length and its type.
fn begin_object(bytes: &mut Vec<u8>, head: usize, length: usize, kind: u32) {
    bytes.extend_from_slice(OBJECT);
    bytes.extend((head as u16).to_le_bytes());
    bytes.extend(1_u16.to_le_bytes());
    bytes.extend((length as u32).to_le_bytes());
    bytes.extend(kind.to_le_bytes());
}

const fn kind(frame: &Frame) -> u32 {
    match frame.kind {
        Kind::Data | Kind::Remote { .. } => MESSAGE,
        Kind::Fd { .. } => FD_MESSAGE,
        Kind::Error => ERROR_EXTENDED,
    }
}

/// What stands behind the head of a frame's object.
fn body(channel: u16, frame: &Frame) -> Vec<u8> {
    let word = frame.id.value() | if frame.id.is_extended() { EXTENDED } else { 0 };
    let mut body = Vec::with_capacity(20 + MAX_DATA);
    body.extend(channel.to_le_bytes());
    let length = frame.data().len();
    match frame.kind {
        // Which frame was disturbed, and how, an error frame of Linux does not tell in Vector's terms.
        Kind::Error => body.resize(32, 0),
        Kind::Data | Kind::Remote { .. } => {
            let (flags, length) = match frame.kind {
                Kind::Remote { length } => (REMOTE, length),
                _ => (0, length as u8),
            };
            body.extend([flags, length]);
            body.extend(word.to_le_bytes());
            body.extend_from_slice(frame.data());
            body.resize(16, 0);
        }
        Kind::Fd { flags } => {
            let bits =
                FD | if flags & 1 != 0 { BRS } else { 0 } | if flags & 2 != 0 { ESI } else { 0 };
            body.extend([0, fd_code(length)]);
            body.extend(word.to_le_bytes());
            // Its duration, and the number of its bits at the lower rate.
            body.extend([0; 5]);
            body.extend([bits, length as u8]);
            body.extend([0; 5]);
            body.extend_from_slice(frame.data());
            body.resize(20 + MAX_DATA, 0);
        }
    }
    body
}
