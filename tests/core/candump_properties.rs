//! What holds for every input: no panic, the same result in any pieces, what was written is read.

use std::io::Write;

use proptest::prelude::*;
use tertius::bus::{Interfaces, Options, TimeStamps, append_log_line};
use tertius::frame::{Frame, Id, Kind};
use tertius::time::Timestamp;
use tertius_testing::candump::{read, read_in_pieces, read_with};

const FD_LENGTHS: [usize; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];

fn id() -> impl Strategy<Value = Id> {
    prop_oneof![
        3 => (0..=Id::STANDARD_MAX).prop_map(|id| Id::standard(id).unwrap()),
        1 => (0..=Id::EXTENDED_MAX).prop_map(|id| Id::extended(id).unwrap()),
    ]
}

fn nanos() -> impl Strategy<Value = i64> {
    let micros = (0..3_000_000i64).prop_map(|micros| 1_700_000_000_000_000_000 + micros * 1000);
    let fine = (0..3_000_000_000i64).prop_map(|nanos| 1_700_000_000_000_000_000 + nanos);
    prop_oneof![4 => micros, 2 => fine, 1 => any::<i64>(), 1 => Just(i64::MAX), 1 => Just(i64::MIN)]
}

/// Any frame that a bus can carry.
fn frame() -> impl Strategy<Value = Frame> {
    let new =
        |nanos, id, kind, data: &[u8]| Frame::new(Timestamp::from_nanos(nanos), id, kind, data);
    let bytes = || prop::collection::vec(any::<u8>(), 0..=8);
    let fd_bytes = prop::sample::select(&FD_LENGTHS[..])
        .prop_flat_map(|length| prop::collection::vec(any::<u8>(), length));
    let error_id = (0..=Id::EXTENDED_MAX).prop_map(|id| Id::extended(id).unwrap());
    prop_oneof![
        6 => (nanos(), id(), bytes()).prop_map(move |(t, id, data)| new(t, id, Kind::Data, &data)),
        1 => (nanos(), id(), 0..16u8, fd_bytes)
            .prop_map(move |(t, id, flags, data)| new(t, id, Kind::Fd { flags }, &data)),
        1 => (nanos(), id(), 0..=8u8)
            .prop_map(move |(t, id, length)| new(t, id, Kind::Remote { length }, &[])),
        1 => (nanos(), error_id, bytes()).prop_map(move |(t, id, d)| new(t, id, Kind::Error, &d)),
    ]
}

fn interface() -> impl Strategy<Value = String> {
    prop::sample::select(vec!["can0", "can1", "vcan0", "can10", "a-longer-name"])
        .prop_map(String::from)
}

fn log_line() -> impl Strategy<Value = Vec<u8>> {
    (interface(), frame()).prop_map(|(interface, frame)| {
        let mut line = Vec::new();
        append_log_line(&mut line, &interface, &frame);
        line
    })
}

fn console_line() -> impl Strategy<Value = Vec<u8>> {
    let data = prop::collection::vec(any::<u8>(), 0..=8);
    (0..400_000u32, interface(), id(), data).prop_map(|(micros, interface, id, data)| {
        let bytes: String = data.iter().map(|byte| format!(" {byte:02X}")).collect();
        let stamp = format!(" (000.{micros:06})");
        format!("{stamp}  {interface}  {id}   [{}] {bytes}\n", data.len()).into_bytes()
    })
}

/// A good line with some bytes changed, lost or doubled.
fn mutated_line() -> impl Strategy<Value = Vec<u8>> {
    let change = (any::<prop::sample::Index>(), any::<u8>(), 0..3u8);
    let line = prop_oneof![log_line(), console_line()];
    (line, prop::collection::vec(change, 1..4)).prop_map(|(mut line, changes)| {
        for (place, byte, how) in changes {
            if line.is_empty() {
                break;
            }
            let place = place.index(line.len());
            match how {
                0 => line[place] = byte,
                1 => drop(line.remove(place)),
                _ => line.insert(place, line[place]),
            }
        }
        line
    })
}

fn line() -> impl Strategy<Value = Vec<u8>> {
    prop_oneof![
        8 => log_line(),
        6 => console_line(),
        2 => mutated_line(),
        1 => prop::collection::vec(any::<u8>(), 0..40),
        1 => Just(b"\n\r\n \n".to_vec()),
        1 => Just(vec![b'x'; 1500]),
    ]
}

/// A recording: many lines, and perhaps one cut short at its end.
fn text() -> impl Strategy<Value = Vec<u8>> {
    (prop::collection::vec(line(), 0..120), 0..60usize).prop_map(|(lines, cut)| {
        let mut text = lines.concat();
        text.truncate(text.len().saturating_sub(cut));
        text
    })
}

fn options() -> impl Strategy<Value = Options> {
    let all = vec![TimeStamps::Auto, TimeStamps::Auto, TimeStamps::Delta, TimeStamps::Zero];
    let interfaces = prop_oneof![Just(Interfaces::All), interface().prop_map(Interfaces::Only)];
    (prop::sample::select(all), interfaces)
        .prop_map(|(time_stamps, interfaces)| Options { time_stamps, interfaces })
}

fn sizes() -> impl Strategy<Value = Vec<usize>> {
    let any_size = prop_oneof![3 => 0..100usize, 1 => 0..5000usize];
    prop_oneof![1 => Just(vec![1]), 4 => prop::collection::vec(any_size, 1..20)]
}

fn gzip(text: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(text).unwrap();
    encoder.finish().unwrap()
}

fn zstd(text: &[u8]) -> Vec<u8> {
    zstd::encode_all(text, 1).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_written_is_read(frames in prop::collection::vec((interface(), frame()), 1..40)) {
        let mut text = Vec::new();
        for (interface, frame) in &frames {
            append_log_line(&mut text, interface, frame);
        }
        let (read, statistics) = read(&text);
        prop_assert_eq!(statistics.bad_lines, 0, "{:?}", statistics.first_bad_lines);
        prop_assert_eq!(read.len(), frames.len());
        for (read, (_, written)) in read.iter().zip(&frames) {
            prop_assert_eq!(read, written);
        }
    }

    #[test]
    fn pieces_make_no_difference(text in text(), sizes in sizes(), options in options()) {
        let whole = read_with(&text, options.clone());
        prop_assert_eq!(&read_in_pieces(&text, &sizes, options.clone()), &whole);
        prop_assert_eq!(&read_in_pieces(&text, &[1], options), &whole);
    }

    #[test]
    fn compression_and_pieces_make_no_difference(text in text(), sizes in sizes(), options in options()) {
        let whole = read_with(&text, options.clone());
        let half = text.len() / 2;
        let members = [gzip(&text[..half]), gzip(&text[half..])].concat();
        prop_assert_eq!(&read_in_pieces(&members, &sizes, options.clone()), &whole);
        let frames = [zstd(&text[..half]), zstd(&text[half..])].concat();
        prop_assert_eq!(&read_in_pieces(&frames, &sizes, options), &whole);
    }

    #[test]
    fn damage_is_the_same_in_pieces(
        text in text(),
        sizes in sizes(),
        place in any::<prop::sample::Index>(),
        flip in 0..=255u8,
        is_gzip in any::<bool>(),
    ) {
        let mut data = if is_gzip { gzip(&text) } else { zstd(&text) };
        let place = place.index(data.len());
        if flip == 0 { data.truncate(place) } else { data[place] ^= flip }
        let whole = read(&data);
        prop_assert!(whole.1.damaged_inputs <= 1);
        prop_assert_eq!(&read_in_pieces(&data, &sizes, Options::default()), &whole);
    }

    #[test]
    fn every_line_is_accounted_for(text in text()) {
        let (frames, statistics) = read(&text);
        let newlines = text.iter().filter(|&&byte| byte == b'\n').count() as u64;
        let unfinished = u64::from(!text.is_empty() && !text.ends_with(b"\n"));
        prop_assert_eq!(statistics.lines, newlines + unfinished);
        prop_assert_eq!(statistics.frames, frames.len() as u64);
        let listed: u64 = statistics.interfaces.iter().map(|seen| seen.frames).sum();
        prop_assert_eq!(listed + statistics.unlisted_interface_frames, statistics.frames);
        prop_assert!(statistics.frames + statistics.bad_lines <= statistics.lines);
    }

    #[test]
    fn arbitrary_bytes_do_no_harm(bytes in prop::collection::vec(any::<u8>(), 0..4000)) {
        let (frames, statistics) = read(&bytes);
        prop_assert!(frames.len() as u64 <= statistics.lines);
    }

    #[test]
    fn damaged_lines_do_no_harm(lines in prop::collection::vec(mutated_line(), 1..40)) {
        let (frames, statistics) = read(&lines.concat());
        for frame in frames {
            let limit = if matches!(frame.kind, Kind::Fd { .. }) { 64 } else { 8 };
            prop_assert!(frame.length() <= limit && FD_LENGTHS.contains(&frame.length()));
        }
        for bad in &statistics.first_bad_lines {
            prop_assert!(bad.text.len() <= 80 * 8 && !bad.text.contains(char::is_control));
        }
    }
}
