//! Captures in pcap and pcapng, written here as their specifications say.

use std::fs;

use proptest::prelude::*;
use proptest::sample::Index;
use tertius::bus::{BadPlace, Interfaces, Options, Statistics};
use tertius::frame::{Frame, Id, Kind};
use tertius::time::Timestamp;
use tertius_testing::candump::{read, read_in_pieces, read_with};
use tertius_testing::oracle;

/// Writes numbers in one of the two byte orders.
#[derive(Clone, Copy, Debug)]
struct Order(bool);

impl Order {
    fn u16(self, value: u16) -> [u8; 2] {
        if self.0 { value.to_be_bytes() } else { value.to_le_bytes() }
    }

    fn u32(self, value: u32) -> [u8; 4] {
        if self.0 { value.to_be_bytes() } else { value.to_le_bytes() }
    }

    fn block(self, kind: u32, body: &[u8]) -> Vec<u8> {
        let padded = body.len().next_multiple_of(4);
        let length = self.u32(padded as u32 + 12);
        let padding = vec![0; padded - body.len()];
        [&self.u32(kind)[..], &length, body, &padding, &length].concat()
    }

    fn section(self) -> Vec<u8> {
        let body = [&self.u32(0x1A2B_3C4D)[..], &self.u16(1), &self.u16(0), &[0xFF; 8]].concat();
        self.block(0x0A0D_0D0A, &body)
    }

    fn interface(self, link: u16, options: &[(u16, &[u8])]) -> Vec<u8> {
        let mut body = [&self.u16(link)[..], &self.u16(0), &self.u32(0)].concat();
        for (code, value) in options {
            body.extend([self.u16(*code), self.u16(value.len() as u16)].concat());
            body.extend(*value);
            body.resize(body.len().next_multiple_of(4), 0);
        }
        self.block(1, &body)
    }

    /// A packet of `-i any`, link type 113: the kind of packet, ARPHRD_CAN, no address, ETH_P_CAN.
    fn cooked(self, frame: &Frame) -> Vec<u8> {
        [&[0, 0, 1, 24, 0, 0][..], &[0; 8], &[0, 12], &self.host(frame)].concat()
    }

    /// The same, of link type 276 and interface 3.
    fn cooked_2(self, frame: &Frame) -> Vec<u8> {
        let head = [0, 12, 0, 0, 0, 0, 0, 3, 1, 24, 0, 0];
        [&head[..], &[0; 8], &self.host(frame)].concat()
    }

    /// A frame as a cooked capture has it: its identifier in the byte order of the computer.
    fn host(self, frame: &Frame) -> Vec<u8> {
        let mut bytes = captured(frame);
        if !self.0 {
            bytes[..4].reverse();
        }
        bytes
    }

    /// An enhanced packet of an interface, at a count of its unit.
    fn packet(self, interface: u32, count: u64, packet: &[u8]) -> Vec<u8> {
        let length = self.u32(packet.len() as u32);
        let [high, low] = [(count >> 32) as u32, count as u32].map(|half| self.u32(half));
        let head = [self.u32(interface), high, low, length, length].concat();
        // With an option behind the data, which is of no interest.
        let padding = vec![0; packet.len().next_multiple_of(4) - packet.len()];
        let option = [&self.u16(2)[..], &self.u16(4), &[0; 4], &[0; 4]].concat();
        self.block(6, &[&head[..], packet, &padding, &option].concat())
    }
}

/// A frame as Linux captures it.
fn captured(frame: &Frame) -> Vec<u8> {
    let extended = if frame.id.is_extended() { 1 << 31 } else { 0 };
    let (flags, length, kind) = match frame.kind {
        Kind::Data => (0, frame.data().len() as u8, 0),
        Kind::Remote { length } => (0, length, 1 << 30),
        Kind::Error => (0, frame.data().len() as u8, 1 << 29),
        Kind::Fd { flags } => (flags | 4, frame.data().len() as u8, 0),
    };
    let extended = if frame.kind == Kind::Error { 0 } else { extended };
    let id = (frame.id.value() | extended | kind).to_be_bytes();
    [&id[..], &[length, flags, 0, 0], frame.data()].concat()
}

fn excerpt() -> Vec<Frame> {
    let log = oracle::top().join("tests/oracle/e-type-excerpt.log");
    let (mut frames, _) = read(&fs::read(log).expect("the excerpt"));
    let at = frames[frames.len() - 1].timestamp;
    let standard = Id::standard(0x123).expect("11 bits");
    frames.extend([
        Frame::new(at, Id::extended(0x18FE_F100).expect("29 bits"), Kind::Data, &[1]),
        Frame::new(at, standard, Kind::Remote { length: 3 }, &[]),
        Frame::new(at, standard, Kind::Fd { flags: 1 }, &[7; 12]),
        Frame::new(at, Id::extended(0x40).expect("29 bits"), Kind::Error, &[0; 8]),
    ]);
    frames
}

fn micros(frame: &Frame) -> u64 {
    frame.timestamp.as_nanos() as u64 / 1000
}

/// A pcapng of the frames on can0.
fn pcapng(order: Order, frames: &[Frame]) -> Vec<u8> {
    let packets = frames.iter().map(|frame| order.packet(0, micros(frame), &captured(frame)));
    let head = [order.section(), order.interface(227, &[(2, b"can0"), (0, b"")])].concat();
    std::iter::once(head).chain(packets).collect::<Vec<_>>().concat()
}

fn pcap(order: Order, nanoseconds: bool, link: u32, packets: &[(i64, Vec<u8>)]) -> Vec<u8> {
    let magic = if nanoseconds { 0xA1B2_3C4D } else { 0xA1B2_C3D4 };
    let version = [order.u16(2), order.u16(4)].concat();
    let mut bytes =
        [&order.u32(magic)[..], &version, &[0; 8], &order.u32(262_144), &order.u32(link)].concat();
    for (nanos, packet) in packets {
        let (seconds, rest) = (nanos / 1_000_000_000, nanos % 1_000_000_000);
        let parts = if nanoseconds { rest } else { rest / 1000 };
        let length = packet.len() as u32;
        for word in [seconds as u32, parts as u32, length, length] {
            bytes.extend(order.u32(word));
        }
        bytes.extend(packet);
    }
    bytes
}

fn packets(frames: &[Frame], head: &[u8]) -> Vec<(i64, Vec<u8>)> {
    let packet = |frame: &Frame| (frame.timestamp.as_nanos(), [head, &captured(frame)].concat());
    frames.iter().map(packet).collect()
}

#[track_caller]
fn has(capture: &[u8], frames: &[Frame], interface: &str) {
    let (found, statistics) = read(capture);
    assert_eq!(statistics.bad_lines, 0, "{:?}", statistics.first_bad_lines);
    assert_eq!(found, frames);
    let plural = if frames.len() == 1 { "" } else { "s" };
    let interfaces = format!("{interface} ({} frame{plural})", frames.len());
    assert_eq!(statistics.interfaces_found(), interfaces);
    for sizes in [&[1][..], &[7, 0, 64, 3]] {
        let pieces = read_in_pieces(capture, sizes, Options::default());
        assert_eq!(pieces, (found.clone(), statistics.clone()));
    }
}

#[test]
fn captures_of_every_form_have_the_frames_that_were_captured() {
    let frames = excerpt();
    for order in [Order(false), Order(true)] {
        has(&pcapng(order, &frames), &frames, "can0");
        for nanoseconds in [false, true] {
            has(&pcap(order, nanoseconds, 227, &packets(&frames, &[])), &frames, "if0");
        }
        let cooked = |head: &dyn Fn(&Frame) -> Vec<u8>| -> Vec<(i64, Vec<u8>)> {
            frames.iter().map(|frame| (frame.timestamp.as_nanos(), head(frame))).collect()
        };
        has(&pcap(order, false, 113, &cooked(&|it| order.cooked(it))), &frames, "if0");
        has(&pcap(order, false, 276, &cooked(&|it| order.cooked_2(it))), &frames, "if3");
    }
}

/// Two computers wrote a section each, into one file.
#[test]
fn a_cooked_identifier_has_the_byte_order_of_its_section() {
    let frames = excerpt();
    let section = |order: Order, frames: &[Frame]| {
        let packets =
            frames.iter().map(|frame| order.packet(0, micros(frame), &order.cooked_2(frame)));
        let head = [order.section(), order.interface(276, &[])].concat();
        std::iter::once(head).chain(packets).collect::<Vec<_>>().concat()
    };
    let (first, second) = frames.split_at(frames.len() / 2);
    for big in [false, true] {
        let capture = [section(Order(big), first), section(Order(!big), second)].concat();
        has(&capture, &frames, "if3");
    }
}

/// Nanoseconds, milliseconds, parts of 2⁻²⁰ s, and seconds that are added.
#[test]
fn time_stamps_have_the_unit_that_their_interface_tells() {
    let order = Order(true);
    let id = Id::standard(0x181).expect("11 bits");
    let at = |nanos| Frame::new(Timestamp::from_nanos(nanos), id, Kind::Data, &[1, 2]);
    let second = 1_700_000_000;
    for (options, count, nanos) in [
        (&[(9, &[9_u8][..])][..], second * 1_000_000_000 + 516, second * 1_000_000_000 + 516),
        (&[(9, &[3])], second * 1000 + 5, second * 1_000_000_000 + 5_000_000),
        (&[(9, &[0x80 | 20])], (second << 20) + (1 << 19), second * 1_000_000_000 + 500_000_000),
        (&[(14, &[0, 0, 0, 0, 0x65, 0x53, 0xF1, 0])], 1_000_000, (second + 1) * 1_000_000_000),
    ] {
        let frame = at(nanos as i64);
        let packet = order.packet(0, count, &captured(&frame));
        let head = [order.section(), order.interface(227, options)].concat();
        has(&[head, packet].concat(), &[frame], "if0");
    }
}

#[test]
fn interfaces_are_told_apart_and_what_is_no_can_is_left_out() {
    let order = Order(false);
    let frames = excerpt();
    let capture = [
        order.section(),
        order.interface(1, &[(2, b"eth0")]),
        order.interface(227, &[(2, b"can0")]),
        order.interface(227, &[(2, b"can1")]),
        order.packet(0, micros(&frames[0]), &[0; 60]),
        order.packet(1, micros(&frames[0]), &captured(&frames[0])),
        order.packet(2, micros(&frames[1]), &captured(&frames[1])),
        // Statistics, and a block of more than may be held at once.
        order.block(5, &[0; 12]),
        order.block(0x0BAD, &vec![7; 300_000]),
        order.packet(2, micros(&frames[2]), &captured(&frames[2])),
        // A second section describes its interfaces anew.
        Order(true).section(),
        Order(true).interface(227, &[(2, b"can1")]),
        Order(true).packet(0, micros(&frames[3]), &captured(&frames[3])),
    ]
    .concat();
    let only = |name: &str| Options {
        interfaces: Interfaces::Only(name.to_owned()),
        ..Options::default()
    };
    let (found, statistics) = read_with(&capture, only("can1"));
    assert_eq!(found, frames[1..4]);
    assert_eq!(statistics.bad_lines, 0, "{:?}", statistics.first_bad_lines);
    assert_eq!(statistics.interfaces_found(), "can0 (1 frame), can1 (3 frames)");
    let pieces = read_in_pieces(&capture, &[1000, 1], only("can1"));
    assert_eq!(pieces, (found, statistics));
}

/// What is said of the only bad record, and its place.
fn bad(capture: &[u8]) -> (String, BadPlace, Statistics) {
    let (_, statistics) = read(capture);
    assert_eq!(statistics.bad_lines, 1, "{:?}", statistics.first_bad_lines);
    let bad = &statistics.first_bad_lines[0];
    (bad.reason.to_string(), bad.place, statistics.clone())
}

#[test]
fn a_bad_record_says_what_was_expected_and_where() {
    let order = Order(false);
    let frames = excerpt();
    let head = [order.section(), order.interface(227, &[])].concat();
    let good = order.packet(0, micros(&frames[0]), &captured(&frames[0]));
    for (record, reason) in [
        (order.packet(7, 0, &captured(&frames[0])), "a packet of an interface that was described"),
        (order.packet(0, 0, &[0, 0, 8, 0, 0, 0, 0, 0]), "the identifier 800 is out of range"),
        (order.packet(0, 0, &[0, 0, 1, 0, 9, 0, 0, 0]), "more than 8 bytes of data"),
        (order.packet(0, 0, &[0, 0, 1, 0, 9, 4, 0, 0]), "9 bytes of data, but a CAN FD frame has"),
        (order.packet(0, 0, &[0, 0, 1, 0, 2, 0, 0, 0, 1]), "announces 2 bytes, but 1 follow"),
        (order.packet(0, 0, &[0, 0, 1]), "a CAN frame of 8 bytes and its data"),
        (order.packet(0, u64::MAX, &captured(&frames[0])), "the time stamp is out of range"),
        (order.block(3, &[0; 20]), "a packet with a time stamp, which a simple one has not"),
        (order.block(1, &[0; 4]), "the description of an interface"),
    ] {
        let capture = [&head[..], &good, &record, &good].concat();
        let (said, place, statistics) = bad(&capture);
        assert!(said.contains(reason), "{said}: {reason}");
        assert_eq!(place, BadPlace::Byte((head.len() + good.len()) as u64), "{reason}");
        assert_eq!(statistics.frames, 2, "what follows is read");
    }
    // Where a length is wrong, nothing can be found any more.
    for length in [0, 8, 13, 0x7FFF_FFF0] {
        let mut record = good.clone();
        record[4..8].copy_from_slice(&order.u32(length));
        let (said, _, statistics) = bad(&[&head[..], &good, &record, &good].concat());
        assert!(said.contains("the length of a block"), "{said}");
        assert_eq!(statistics.frames, 1);
    }
    let whole = [&head[..], &good, &good].concat();
    let (said, _, statistics) = bad(&whole[..whole.len() - 5]);
    assert!(said.contains("ends in the middle of a record") && statistics.frames == 1, "{said}");
}

proptest! {
    /// Whatever becomes of some bytes, nothing breaks, every record is accounted for, and the sizes of the
    /// reads make no difference.
    #[test]
    fn damaged_captures_do_no_harm(
        kind in 0..4_usize,
        damage in prop::collection::vec((any::<Index>(), any::<u8>()), 0..8),
        sizes in prop::collection::vec(1..200_usize, 1..4),
    ) {
        let frames = &excerpt()[..12];
        let mut bytes = match kind {
            0 | 1 => pcapng(Order(kind == 0), frames),
            _ => pcap(Order(kind == 2), true, 227, &packets(frames, &[])),
        };
        for (place, byte) in &damage {
            let place = place.index(bytes.len());
            bytes[place] = *byte;
        }
        let (frames, statistics) = read(&bytes);
        prop_assert!(statistics.frames + statistics.bad_lines <= statistics.lines);
        prop_assert!(frames.len() as u64 <= statistics.frames);
        let pieces = read_in_pieces(&bytes, &sizes, Options::default());
        prop_assert_eq!(pieces, (frames, statistics));
    }
}
