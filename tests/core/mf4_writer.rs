//! Writes bus logging in MDF 4 as CANedge lays it out, in every form that the format has for the data.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use tertius::frame::{Frame, Kind};

/// How the data of a group are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stored {
    /// In one block.
    Block,
    /// In three blocks of a list, cut anywhere.
    List,
    /// In two compressed blocks of a list.
    Packed,
    /// In a compressed block, column by column.
    Transposed,
    /// In a block of a list of MDF 4.2, with a block of marks of invalid values; for groups with data of their own.
    Marked,
}

/// How a file is written.
#[derive(Clone, Copy, Debug)]
pub struct Form {
    /// Whether all groups are mixed in one set of data.
    pub mixed: bool,
    /// Whether payloads have a variable length, or 64 bytes each.
    pub variable: bool,
    pub stored: Stored,
    /// Whether times are whole numbers of nanoseconds, or floating-point ones.
    pub whole: bool,
    /// Whether the channel is the same in all records without being there, and lengths are looked up by their codes.
    pub brief: bool,
    /// What was never finished.
    pub unfinished: u16,
}

impl Default for Form {
    fn default() -> Self {
        let stored = Stored::Block;
        Self { mixed: true, variable: true, stored, whole: false, brief: false, unfinished: 0 }
    }
}

/// Start of the measurement, ns.
const START: i64 = 1_600_000_000_000_000_000;

/// A part of a frame: its name, byte, bit, and number of bits.
type Part = (&'static str, u32, u8, u32);
const PARTS: [Part; 9] = [
    ("BusChannel", 8, 1, 2),
    ("ID", 8, 3, 29),
    ("IDE", 8, 0, 1),
    ("DLC", 13, 4, 4),
    ("DataLength", 12, 1, 7),
    ("Dir", 12, 0, 1),
    ("EDL", 13, 0, 1),
    ("BRS", 13, 1, 1),
    ("ESI", 13, 2, 1),
];

/// Each code with the length that it stands for, bytes.
const LENGTHS: [f64; 32] = [
    0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 5.0, 5.0, 6.0, 6.0, 7.0, 7.0, 8.0, 8.0, 9.0,
    12.0, 10.0, 16.0, 11.0, 20.0, 12.0, 24.0, 13.0, 32.0, 14.0, 48.0, 15.0, 64.0,
];

struct Writer {
    bytes: Vec<u8>,
    /// Bytes of marks of invalid values that groups announce for each record.
    marks: u32,
}

impl Writer {
    fn block(&mut self, kind: &str, links: &[u64], data: &[u8]) -> u64 {
        self.bytes.resize(self.bytes.len().next_multiple_of(8), 0);
        let at = self.bytes.len() as u64;
        self.bytes.extend(b"##");
        self.bytes.extend(kind.as_bytes());
        self.bytes.extend([0; 4]);
        self.bytes.extend((24 + 8 * links.len() as u64 + data.len() as u64).to_le_bytes());
        self.bytes.extend((links.len() as u64).to_le_bytes());
        self.bytes.extend(links.iter().flat_map(|link| link.to_le_bytes()));
        self.bytes.extend(data);
        at
    }

    fn text(&mut self, text: &str) -> u64 {
        self.block("TX", &[], &[text.as_bytes(), &[0]].concat())
    }

    /// A channel: [next, parts, conversion, data], its name, [kind, sync, number, bit], byte and bits.
    fn channel(&mut self, links: [u64; 4], name: &str, kind: [u8; 4], places: [u32; 2]) -> u64 {
        let [next, parts, conversion, data] = links;
        let name = self.text(name);
        let places = places.map(u32::to_le_bytes).concat();
        let described = [&kind[..], &places, &[0; 60]].concat();
        self.block("CN", &[next, parts, name, 0, conversion, data, 0, 0], &described)
    }

    fn conversion(&mut self, kind: u8, values: &[f64]) -> u64 {
        let count = (values.len() as u16).to_le_bytes();
        let values: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let head = [&[kind, 0, 0, 0, 0, 0][..], &count, &[0; 16]].concat();
        self.block("CC", &[0; 4], &[head, values].concat())
    }

    /// The channels of a group of frames; `payload` is its kind, its bits, and the link to its data.
    fn channels(&mut self, form: Form, name: &str, payload: Option<(u8, u32, u64)>) -> u64 {
        let mut next = 0;
        if let Some((kind, bits, data)) = payload {
            let part = format!("{name}.DataBytes");
            next = self.channel([0, 0, 0, data], &part, [kind, 0, 10, 0], [14, bits]);
        }
        for (part, byte, bit, bits) in PARTS {
            let (links, kind, places) = match part {
                "BusChannel" if form.brief => {
                    ([next, 0, self.conversion(1, &[1.0, 0.0]), 0], 6, (0, 0, 0))
                }
                "DataLength" if form.brief => {
                    ([next, 0, self.conversion(5, &LENGTHS), 0], 0, (13, 4, 4))
                }
                _ => ([next, 0, 0, 0], 0, (byte, bit, bits)),
            };
            let (byte, bit, bits) = places;
            let part = format!("{name}.{part}");
            next = self.channel(links, &part, [kind, 0, 0, bit], [byte, bits]);
        }
        let frames = self.channel([0, next, 0, 0], name, [0, 0, 10, 0], [8, 48]);
        let linear = self.conversion(1, &[0.0, 1e-9]);
        let number = if form.whole { 0 } else { 4 };
        self.channel([frames, 0, linear, 0], "Timestamp", [2, 1, number, 0], [0, 64])
    }

    /// A group of so many records of a length: [next, channels].
    fn group(&mut self, links: [u64; 2], id: u64, flags: u16, count: usize, length: usize) -> u64 {
        let [next, channels] = links;
        let source = self.block("SI", &[0; 3], &[2, 2, 0, 0, 0, 0, 0, 0]);
        let counts = [id, count as u64].map(u64::to_le_bytes).concat();
        let flags = [flags.to_le_bytes(), [0; 2], [0; 2], [0; 2]].concat();
        let lengths = [length as u32, self.marks].map(u32::to_le_bytes).concat();
        self.block("CG", &[next, channels, 0, source, 0, 0], &[counts, flags, lengths].concat())
    }

    /// Data, in records of a length.
    fn data(&mut self, form: Form, kind: &str, bytes: &[u8], length: usize) -> u64 {
        let (third, half) = (bytes.len() / 3 + 1, bytes.len() / 2 + 1);
        match form.stored {
            Stored::Block => self.block(kind, &[], bytes),
            Stored::List => {
                let parts = bytes.chunks(third).map(|part| self.block(kind, &[], part));
                let mut parts: Vec<u64> = parts.collect();
                let behind = parts.split_off(parts.len().saturating_sub(1));
                let last = self.list(0, &behind);
                self.list(last, &parts)
            }
            Stored::Packed => {
                let parts = bytes.chunks(half).map(|part| self.packed(kind, 0, part, 0));
                let parts: Vec<u64> = parts.collect();
                let list = self.list(0, &parts);
                self.block("HL", &[list], &[0; 8])
            }
            Stored::Transposed => self.packed(kind, 1, bytes, length),
            Stored::Marked => {
                let parts = [self.block("DV", &[], bytes), self.block("DI", &[], &[7; 99])];
                let described = [0, 0, 0, 0x80, 1, 0, 0, 0];
                self.block("LD", &[0, parts[0], parts[1]], &described)
            }
        }
    }

    fn list(&mut self, next: u64, parts: &[u64]) -> u64 {
        let described = [[0; 4], (parts.len() as u32).to_le_bytes()].concat();
        // The offsets of the parts, which the list tells where they are not of the same length, are not needed.
        let described = [described, vec![0; 8 * parts.len()]].concat();
        self.block("DL", &[&[next], parts].concat(), &described)
    }

    fn packed(&mut self, kind: &str, method: u8, bytes: &[u8], columns: usize) -> u64 {
        let rows = bytes.len().checked_div(columns).unwrap_or(0);
        let stored = (0..rows * columns).map(|n| bytes[n % rows * columns + n / rows]);
        let stored: Vec<u8> = stored.chain(bytes[rows * columns..].iter().copied()).collect();
        let mut packer = ZlibEncoder::new(Vec::new(), Compression::default());
        packer.write_all(&stored).expect("a vector takes all");
        let packed = packer.finish().expect("a vector takes all");
        let lengths = [bytes.len() as u64, packed.len() as u64].map(u64::to_le_bytes).concat();
        let head = [kind.as_bytes(), &[method, 0], &(columns as u32).to_le_bytes(), &lengths];
        self.block("DZ", &[], &[&head.concat()[..], &packed].concat())
    }
}

/// The record of a frame without its number and payload.
fn record(form: Form, frame: &Frame) -> Vec<u8> {
    let nanos = frame.timestamp.as_nanos() - START;
    let stamp = if form.whole { nanos.to_le_bytes() } else { (nanos as f64).to_le_bytes() };
    let (length, is_fd, flags) = match frame.kind {
        Kind::Remote { length } => (length, 0, 0),
        Kind::Fd { flags } => (frame.data().len() as u8, 1, flags),
        _ => (frame.data().len() as u8, 0, 0),
    };
    let code = match length {
        0..=8 => length,
        12..=24 => 6 + length / 4,
        _ => 11 + length / 16,
    };
    let code = if length == 32 { 13 } else { code };
    let word = u32::from(frame.id.is_extended()) | 1 << 1 | frame.id.value() << 3;
    let parts = [length << 1, is_fd | flags << 1 | code << 4];
    [&stamp[..], &word.to_le_bytes(), &parts].concat()
}

/// Writes the frames, which are of channel 1, with a record of something else behind each fifth one.
pub fn file(form: Form, frames: &[Frame]) -> Vec<u8> {
    // Records of data, payloads, records of error and of remote frames, and all of them mixed.
    let (mut data, mut payloads, mut errors) = (Vec::new(), Vec::new(), Vec::new());
    let (mut remotes, mut mixed) = (Vec::new(), Vec::new());
    for (n, frame) in frames.iter().enumerate() {
        let record = record(form, frame);
        match frame.kind {
            Kind::Error => {
                mixed.extend([&[3][..], &record].concat());
                errors.extend(record);
            }
            Kind::Remote { .. } => {
                mixed.extend([&[4][..], &record].concat());
                remotes.extend(record);
            }
            _ => {
                let mut payload = frame.data().to_vec();
                let mut whole = record;
                if form.variable {
                    whole.extend((payloads.len() as u64).to_le_bytes());
                    payload.splice(0..0, (payload.len() as u32).to_le_bytes());
                    payloads.extend(&payload);
                } else {
                    payload.resize(64, 0);
                    whole.extend(&payload);
                }
                mixed.extend([&[1][..], &whole].concat());
                if form.variable {
                    mixed.extend([&[2][..], &payload].concat());
                }
                data.extend(whole);
            }
        }
        if n % 5 == 4 {
            mixed.extend([5, 0xAA, 0xBB, 0xCC]);
        }
    }
    let marks = if form.stored == Stored::Marked { 3 } else { 0 };
    let mut writer = Writer { bytes: Vec::new(), marks };
    let begins: &[u8] = if form.unfinished == 0 { b"MDF     " } else { b"UnFinMF " };
    writer.bytes.extend([begins, b"4.11    test    ", &[0; 36]].concat());
    writer.bytes.extend(form.unfinished.to_le_bytes());
    writer.bytes.extend([0; 2]);
    let header = writer.block("HD", &[0; 6], &[&START.to_le_bytes()[..], &[0; 24]].concat());
    let first = if form.mixed {
        let are = |is: fn(&Kind) -> bool| frames.iter().filter(|frame| is(&frame.kind)).count();
        let errors = are(|kind| *kind == Kind::Error);
        let remotes = are(|kind| matches!(kind, Kind::Remote { .. }));
        let counts = [frames.len() - errors - remotes, errors, remotes, frames.len() / 5];
        // A file that was never finished does not have them.
        let counts = if form.unfinished & 1 == 0 { counts } else { [0; 4] };
        let lengths = if form.unfinished & 0x20 == 0 { payloads.len() } else { 0 };
        all_in_one(&mut writer, form, &mixed, counts, lengths)
    } else {
        one_by_one(&mut writer, form, [&data, &payloads, &errors, &remotes])
    };
    writer.bytes[header as usize + 24..][..8].copy_from_slice(&first.to_le_bytes());
    writer.bytes
}

/// All groups in one set of data; the counts are those of data, error, remote and other records, and `lengths` are the
/// bytes of all payloads.
fn all_in_one(
    writer: &mut Writer,
    form: Form,
    mixed: &[u8],
    counts: [usize; 4],
    lengths: usize,
) -> u64 {
    let [frames, errors, remotes, others] = counts;
    let other = writer.group([0, 0], 5, 0, others, 3);
    let channels = writer.channels(form, "CAN_RemoteFrame", None);
    let remotes = writer.group([other, channels], 4, 6, remotes, 14);
    let channels = writer.channels(form, "CAN_ErrorFrame", None);
    let errors = writer.group([remotes, channels], 3, 6, errors, 14);
    let payloads = writer.group([errors, 0], 2, 1, frames, lengths);
    let payload = if form.variable { (1, 64, payloads) } else { (0, 512, 0) };
    let channels = writer.channels(form, "CAN_DataFrame", Some(payload));
    let length = if form.variable { 22 } else { 78 };
    let groups = writer.group([payloads, channels], 1, 6, frames, length);
    // The set stands before its data, and they at the end, as a logger writes them.
    let set = writer.block("DG", &[0, groups, 0, 0], &[1, 0, 0, 0, 0, 0, 0, 0]);
    let data = writer.data(form, "DT", mixed, length);
    writer.bytes[set as usize + 24 + 16..][..8].copy_from_slice(&data.to_le_bytes());
    if form.unfinished & 4 != 0 {
        writer.bytes[data as usize + 8..][..8].fill(0);
    }
    set
}

/// Each group with data of its own: those of data frames, payloads, errors and remote frames.
fn one_by_one(writer: &mut Writer, form: Form, data: [&[u8]; 4]) -> u64 {
    let [frames, payloads, errors, remotes] = data;
    let mut next = 0;
    for (name, records) in [("CAN_RemoteFrame", remotes), ("CAN_ErrorFrame", errors)] {
        let channels = writer.channels(form, name, None);
        let group = writer.group([0, channels], 0, 6, records.len() / 14, 14);
        let data = writer.data(form, "DT", records, 14);
        next = writer.block("DG", &[next, group, data, 0], &[0; 8]);
    }
    let payloads = writer.data(form, "SD", payloads, 5);
    let payload = if form.variable { (1, 64, payloads) } else { (5, 512, 0) };
    let length = if form.variable { 22 } else { 78 };
    let channels = writer.channels(form, "CAN_DataFrame", Some(payload));
    let group = writer.group([0, channels], 0, 6, frames.len() / length, length);
    let data = writer.data(form, "DT", frames, length);
    writer.block("DG", &[next, group, data, 0], &[0; 8])
}

/// A file of so many sets of data, each a compressed block of so many bytes, of which none is a frame.
pub fn bombs(sets: usize, length: usize) -> Vec<u8> {
    let mut writer = Writer { bytes: Vec::new(), marks: 0 };
    writer.bytes.extend([&b"MDF     4.11    test    "[..], &[0; 40]].concat());
    let header = writer.block("HD", &[0; 6], &[&START.to_le_bytes()[..], &[0; 24]].concat());
    let zeros = vec![0; length];
    let mut packer = ZlibEncoder::new(Vec::new(), Compression::best());
    packer.write_all(&zeros).expect("a vector takes all");
    let packed = packer.finish().expect("a vector takes all");
    let lengths = [length as u64, packed.len() as u64].map(u64::to_le_bytes).concat();
    let block = [&b"DT"[..], &[0; 6], &lengths, &packed].concat();
    let mut next = 0;
    for _ in 0..sets {
        let channels = writer.channels(Form::default(), "CAN_DataFrame", Some((0, 512, 0)));
        let group = writer.group([0, channels], 0, 6, length / 78, 78);
        let data = writer.block("DZ", &[], &block);
        next = writer.block("DG", &[next, group, data, 0], &[0; 8]);
    }
    writer.bytes[header as usize + 24..][..8].copy_from_slice(&next.to_le_bytes());
    writer.bytes
}
