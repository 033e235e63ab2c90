//! Bus logging in MDF 4 that is damaged, or odd: what is told of it, and what is read.

use std::sync::LazyLock;

use proptest::prelude::*;
use proptest::sample::Index;
use tertius::bus::{BadPlace, Options};
use tertius::frame::Frame;
use tertius_testing::candump::{read, read_in_pieces};

use crate::mf4::{excerpt, forms};
use crate::mf4_writer::{Form, Stored, bombs, file};

#[test]
fn a_flaw_says_what_was_expected_and_where() {
    let frames = excerpt();
    let bytes = file(Form::default(), &frames);
    let find = |kind: &[u8]| {
        bytes.windows(4).position(|place| place == kind).expect("a block of this kind")
    };
    let [set, group, data, channel] = [&b"##DG"[..], b"##CG", b"##DT", b"##CN"].map(find);
    for (at, value, place, told) in [
        (64, u64::from_le_bytes(*b"##XX\0\0\0\0"), 66, "the head of a measurement, ##HD"),
        (88, 0, 64, "has no group of CAN frames"),
        (88, set as u64 + 8, set + 8, "a block of MDF, which begins with ##"),
        (88, 1 << 40, 1 << 40, "found the end of the file, expected a block of MDF"),
        (set + 24, set as u64, set, "links lead here in a circle"),
        (set + 8, 0, set + 8, "a block with as many bytes as it announces"),
        (set + 16, u64::MAX, set + 16, "as many links as a block announces"),
        (set + 56, 3, set + 56, "the length of record numbers"),
        (group + 24, group as u64, group, "links lead here in a circle"),
        (channel + 24, channel as u64, channel, "links lead here in a circle"),
        (data, 0, data, "a block of MDF"),
        (data + 4, 0, data + 8, "the length of a block, 24 or more"),
        (data + 8, 1 << 40, data, "announces more bytes than the file has"),
        (data + 24, 99, data + 24, "the number of a group of this file"),
    ] {
        let mut damaged = bytes.clone();
        damaged[at..at + 8].copy_from_slice(&u64::to_le_bytes(value));
        let (_, statistics) = read(&damaged);
        let bad = &statistics.first_bad_lines.first().unwrap_or_else(|| panic!("{told}"));
        assert!(bad.reason.to_string().contains(told), "{} instead of {told}", bad.reason);
        // A circle is noticed at any of its blocks.
        if !told.contains("circle") {
            assert_eq!(bad.place, BadPlace::Byte(place as u64), "{told}");
        }
        // Frames are missing, but for a file that announces none.
        let is_damage = at != 88 || value != 0;
        assert_eq!(statistics.damaged_inputs, u64::from(is_damage), "{told}");
    }
}

/// What unpacks to a thousand times its size is refused before it is unpacked at many places at the same time.
#[test]
fn blocks_that_unpack_to_more_than_there_is_room_for_are_refused() {
    let (_, statistics) = read(&bombs(64, 16 << 20));
    let told = statistics.first_bad_lines[0].reason.to_string();
    let expected = "found a compressed block of 16777216 bytes, expected at most 2097152";
    assert!(told.starts_with(expected) && told.contains("at 64 places"), "{told}");
    assert!(statistics.damaged_inputs > 0);
    // What loggers write fits in.
    let (frames, statistics) = read(&bombs(8, 4 << 20));
    assert!(!frames.is_empty(), "{:?}", statistics.first_bad_lines);
}

/// Numbers that are far out of any range are told of each frame.
#[test]
fn times_that_nobody_could_have_are_out_of_range() {
    let frames = excerpt();
    for whole in [false, true] {
        let bytes = file(Form { whole, ..Form::default() }, &frames);
        let scale: Vec<u8> = [0.0, 1e-9].into_iter().flat_map(f64::to_le_bytes).collect();
        let clocks: Vec<usize> = (0..bytes.len() - scale.len())
            .filter(|place| bytes[*place..].starts_with(&scale))
            .collect();
        assert_eq!(clocks.len(), 3, "one of each group");
        for (offset, scale) in
            [(1e290, 1e-9), (-1e290, 1e-9), (f64::NAN, 1e-9), (1e300, 0.1), (0.0, f64::INFINITY)]
        {
            let mut damaged = bytes.clone();
            for clock in &clocks {
                damaged[*clock..*clock + 8].copy_from_slice(&f64::to_le_bytes(offset));
                damaged[*clock + 8..*clock + 16].copy_from_slice(&f64::to_le_bytes(scale));
            }
            let (found, statistics) = read(&damaged);
            assert_eq!((found.len(), statistics.bad_lines), (0, frames.len() as u64), "{offset}");
            let said = statistics.first_bad_lines[0].to_string();
            assert!(said.contains("the time stamp is out of range"), "{said}");
        }
    }
}

/// Wherever a file ends, it has the first frames of the whole one, and says that others are missing.
#[test]
fn a_file_that_is_cut_anywhere_says_so() {
    let frames = excerpt();
    for stored in [Stored::Block, Stored::List, Stored::Packed] {
        for variable in [false, true] {
            let form = Form { stored, variable, whole: true, ..Form::default() };
            let bytes = file(form, &frames);
            let mut least = frames.len();
            for length in (16..bytes.len()).rev().step_by(37) {
                let (found, statistics) = read(&bytes[..length]);
                assert!(found.len() <= least, "{length} {form:?}");
                least = found.len();
                assert_eq!(found, frames[..least], "{length} {form:?}");
                // Of the last list, what nobody needs may be missing.
                let is_damage = least < frames.len();
                assert_eq!(statistics.bad_lines > 0, is_damage, "{length} {form:?}");
                assert_eq!(statistics.damaged_inputs, u64::from(is_damage), "{length} {form:?}");
            }
            assert_eq!(least, 0);
        }
    }
}

/// A payload that no record needs, since its own is not there any more, is not taken for that of the next one.
#[test]
fn a_payload_that_nobody_needs_is_passed_over() {
    let frames = &excerpt()[..6];
    for mixed in [false, true] {
        let mut bytes = file(Form { mixed, ..Form::default() }, frames);
        let stamps = frames.iter().map(|frame| {
            let since = (frame.timestamp.as_nanos() - 1_600_000_000_000_000_000) as f64;
            let stamp = since.to_le_bytes();
            bytes.windows(8).position(|place| place == stamp).expect("it is in the record")
        });
        let stamps: Vec<usize> = stamps.collect();
        // The third one becomes the fourth, at its own time, with the place of the payload.
        bytes.copy_within(stamps[3] + 8..stamps[3] + 22, stamps[2] + 8);
        let (found, statistics) = read(&bytes);
        assert_eq!(statistics.bad_lines, 0, "{:?}", statistics.first_bad_lines);
        let data =
            |frames: &[Frame]| frames.iter().map(|frame| frame.data().to_vec()).collect::<Vec<_>>();
        let mut expected = data(frames);
        expected[2] = expected[3].clone();
        assert_eq!(data(&found), expected, "{mixed}");
    }
}

/// Lists lead to each other by their first link. What is between others would be left out unnoticed.
#[test]
fn a_list_within_a_list_is_refused() {
    let frames = excerpt();
    let mut bytes = file(Form { stored: Stored::List, ..Form::default() }, &frames);
    let mut lists = bytes.windows(4).enumerate().filter(|(_, place)| *place == b"##DL");
    let last = lists.next().expect("a list").0;
    let first = lists.next().expect("a list").0;
    assert!(lists.next().is_none() && read(&bytes).0.len() == frames.len());
    bytes[first + 40..first + 48].copy_from_slice(&(last as u64).to_le_bytes());
    let (found, statistics) = read(&bytes);
    assert!(!found.is_empty() && found.len() < frames.len());
    let said = statistics.damage[0].to_string();
    assert!(said.contains("lists lead to each other by their first link only"), "{said}");
}

/// With a list of MDF 4.2 the marks of invalid values stand apart, behind as many links as the data.
#[test]
fn marks_of_invalid_values_are_left_out() {
    let frames = excerpt();
    for is_marked in [false, true] {
        let (stored, whole) = (Stored::Marked, true);
        let form = Form { mixed: false, variable: false, stored, whole, ..Form::default() };
        let mut bytes = file(form, &frames);
        if !is_marked {
            let lists = bytes.windows(4).enumerate().filter(|(_, place)| *place == b"##LD");
            let lists: Vec<usize> = lists.map(|(place, _)| place).collect();
            assert_eq!(lists.len(), 4);
            for list in lists {
                bytes[list + 24 + 3 * 8 + 3] = 0;
            }
        }
        let (found, statistics) = read(&bytes);
        assert_eq!(found, frames);
        // Taken for data, they are none.
        assert_eq!(statistics.damaged_inputs, u64::from(!is_marked));
    }
}

/// Files of every form, with few frames.
static FILES: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let frames = excerpt();
    let frames = &frames[frames.len() - 12..];
    let unfinished = Form { unfinished: 0x75, ..Form::default() };
    forms().into_iter().chain([unfinished]).map(|form| file(form, frames)).collect()
});

proptest! {
    /// Whatever becomes of some bytes, nothing breaks, every record is accounted for, and the sizes of the
    /// reads make no difference.
    #[test]
    fn damaged_measurements_do_no_harm(
        which in any::<Index>(),
        damage in prop::collection::vec((any::<Index>(), any::<u8>()), 0..8),
        links in prop::collection::vec((any::<Index>(), any::<Index>()), 0..3),
        sizes in prop::collection::vec(1..200_usize, 1..4),
    ) {
        let mut bytes = which.get(&FILES[..]).clone();
        for (place, byte) in &damage {
            let place = place.index(bytes.len());
            bytes[place] = *byte;
        }
        // Numbers of eight bytes, which are lengths, counts and links, become places of the file.
        for (place, value) in &links {
            let (place, value) = (place.index(bytes.len() / 8 - 1) * 8, value.index(bytes.len()));
            bytes[place..place + 8].copy_from_slice(&(value as u64 / 8 * 8).to_le_bytes());
        }
        let (frames, statistics) = read(&bytes);
        prop_assert!(statistics.frames + statistics.bad_lines <= statistics.lines);
        prop_assert!(frames.len() as u64 <= statistics.frames);
        let pieces = read_in_pieces(&bytes, &sizes, Options::default());
        prop_assert_eq!(pieces, (frames, statistics));
    }
}
