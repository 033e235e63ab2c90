//! Bus logging in MDF 4: written by python-can and here, read by both, and damaged.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use flate2::Compression;
use flate2::write::GzEncoder;
use proptest::prelude::*;
use proptest::sample::Index;
use serde_json::{Value, json};
use tertius::bus::{BadPlace, Interfaces, Options, in_order};
use tertius::frame::{Frame, Id, Kind};
use tertius::time::Timestamp;
use tertius_testing::candump::{read, read_in_pieces, read_with};
use tertius_testing::oracle;

use crate::mf4_writer::{Form, Stored, file};

const LOG: &str = "tests/oracle/e-type-excerpt.log";

fn written(call: &[&str], folder: &Path) -> Vec<u8> {
    let path = folder.join("written.mf4");
    let name = path.display().to_string();
    let call: Vec<&str> =
        call.iter().map(|word| if *word == "MF4" { &name } else { *word }).collect();
    oracle::run("mf4.py", &call, "");
    fs::read(path).expect("it was written")
}

/// A frame as the script prints it.
fn printed(frame: &Frame, channel: u64) -> Value {
    let hex: String = frame.data().iter().map(|byte| format!("{byte:02x}")).collect();
    let flags = if let Kind::Fd { flags } = frame.kind { flags } else { 0 };
    let remote = matches!(frame.kind, Kind::Remote { .. });
    let fd = matches!(frame.kind, Kind::Fd { .. });
    let (id, extended) = (frame.id.value(), frame.id.is_extended());
    let micros = (frame.timestamp.as_nanos() + 500).div_euclid(1000);
    let error = frame.kind == Kind::Error;
    json!([micros, id, extended, remote, error, fd, flags & 1 != 0, flags & 2 != 0, channel, hex])
}

/// The frames of each file.
fn theirs(paths: &[PathBuf]) -> Vec<Vec<Value>> {
    let paths: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    let call: Vec<&str> = std::iter::once("read").chain(paths.iter().map(String::as_str)).collect();
    serde_json::from_str(&oracle::run("mf4.py", &call, "")).expect("JSON")
}

fn ours(bytes: &[u8]) -> Vec<Value> {
    let of = |channel: u64| {
        let interfaces = Interfaces::Only(format!("channel{channel}"));
        let (frames, statistics) = read_with(bytes, Options { interfaces, ..Options::default() });
        assert_eq!(statistics.bad_lines, 0, "{:?}", statistics.first_bad_lines);
        frames.into_iter().map(move |frame| printed(&frame, channel))
    };
    let mut frames: Vec<Value> = of(1).chain(of(2)).collect();
    frames.sort_by_key(|frame| frame[0].as_i64());
    frames
}

/// Compares frame by frame; error frames have only a time and a channel in common.
fn same(ours: &[Value], theirs: &[Value]) {
    assert_eq!(ours.len(), theirs.len());
    for (ours, theirs) in ours.iter().zip(theirs) {
        let fields: &[usize] =
            if theirs[4] == json!(true) { &[4, 8] } else { &[1, 2, 3, 4, 5, 6, 7, 8, 9] };
        for field in fields {
            assert_eq!(ours[*field], theirs[*field], "{ours} {theirs}");
        }
        // A double of seconds since 1970 has a quarter of a microsecond.
        let [one, other] = [ours, theirs].map(|frame| frame[0].as_i64().expect("µs"));
        assert!((one - other).abs() <= 1, "{ours} {theirs}");
    }
}

#[test]
fn every_kind_of_frame_is_read_as_python_can_reads_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let mf4 = written(&["made", "MF4"], folder.path());
    let ours = ours(&mf4);
    assert_eq!(ours.len(), 9);
    same(&ours, &theirs(&[folder.path().join("written.mf4")])[0]);
}

fn excerpt() -> Vec<Frame> {
    let (mut frames, _) = read(&fs::read(oracle::top().join(LOG)).expect("the excerpt"));
    let mut at = frames[frames.len() - 1].timestamp.as_nanos();
    let standard = Id::standard(0x123).expect("11 bits");
    let extended = |id| Id::extended(id).expect("29 bits");
    for (id, kind, data) in [
        (extended(0x18FE_F100), Kind::Data, &[1_u8][..]),
        (standard, Kind::Remote { length: 3 }, &[]),
        (standard, Kind::Fd { flags: 1 }, &[7; 12]),
        (standard, Kind::Fd { flags: 2 }, &[9; 64]),
        (standard, Kind::Data, &[]),
        (extended(0x80), Kind::Error, &[]),
        (extended(5), Kind::Data, &[1, 2, 3, 4, 5, 6, 7, 8]),
    ] {
        // Farther apart than a floating-point number of nanoseconds is coarse.
        at += 1_000_000;
        frames.push(Frame::new(Timestamp::from_nanos(at), id, kind, data));
    }
    frames
}

#[test]
fn what_python_can_writes_is_the_candump_that_it_was_made_from() {
    let folder = tempfile::tempdir().expect("a folder");
    let (frames, _) = read(&fs::read(oracle::top().join(LOG)).expect("the excerpt"));
    for compression in ["0", "1", "2"] {
        let mf4 = written(&["write", LOG, "MF4", compression], folder.path());
        let (found, statistics) = read(&mf4);
        assert_eq!((found.len(), statistics.bad_lines), (frames.len(), 0), "{compression}");
        assert_eq!(statistics.interfaces_found(), format!("channel1 ({} frames)", frames.len()));
        for (one, other) in found.iter().zip(&frames) {
            assert_eq!((one.id, one.kind, one.data()), (other.id, other.kind, other.data()));
            let apart = one.timestamp.as_nanos() - other.timestamp.as_nanos();
            assert!(apart.abs() <= 1000, "{apart} ns");
        }
        for sizes in [&[1][..], &[7, 0, 64]] {
            let pieces = read_in_pieces(&mf4, sizes, Options::default());
            assert_eq!(pieces, (found.clone(), statistics.clone()), "{compression}");
        }
    }
}

fn forms() -> Vec<Form> {
    let mut forms = Vec::new();
    for stored in [Stored::Block, Stored::List, Stored::Packed, Stored::Transposed] {
        for bits in 0..8 {
            let [mixed, variable, whole] = [1, 2, 4].map(|bit| bits & bit != 0);
            let brief = mixed == whole;
            forms.push(Form { mixed, variable, whole, stored, brief, unfinished: 0 });
        }
    }
    forms
}

#[test]
fn every_form_of_the_data_has_the_frames_that_were_written() {
    let frames = excerpt();
    for form in forms() {
        let bytes = file(form, &frames);
        let (found, statistics) = read(&bytes);
        assert_eq!(statistics.bad_lines, 0, "{form:?} {:?}", statistics.first_bad_lines);
        assert_eq!(found.len(), frames.len(), "{form:?}");
        for (one, other) in found.iter().zip(&frames) {
            assert_eq!((one.id, one.kind, one.data()), (other.id, other.kind, other.data()));
            let apart = (one.timestamp.as_nanos() - other.timestamp.as_nanos()).abs();
            assert!(apart <= if form.whole { 0 } else { 16 }, "{apart} ns {form:?}");
        }
        // Records of other groups count as records.
        let others = if form.mixed { frames.len() / 5 } else { 0 };
        let parts = bytes.len().div_ceil(1 << 16);
        assert_eq!(statistics.lines as usize, frames.len() + others + parts, "{form:?}");
    }
}

#[test]
fn a_form_that_python_can_reads_is_read_alike() {
    let folder = tempfile::tempdir().expect("a folder");
    let frames = excerpt();
    let mut files = Vec::new();
    for (n, form) in forms().into_iter().enumerate() {
        // python-can takes numbers as they stand, without the table that says what they mean.
        if !form.brief {
            let path = folder.path().join(format!("{n}.mf4"));
            fs::write(&path, file(form, &frames)).expect("a file");
            files.push((form, path));
        }
    }
    let (forms, paths): (Vec<Form>, Vec<PathBuf>) = files.into_iter().unzip();
    let theirs = theirs(&paths);
    assert_eq!((theirs.len(), forms.len()), (16, 16));
    for ((form, path), theirs) in forms.iter().zip(paths).zip(theirs) {
        println!("{form:?}");
        same(&ours(&fs::read(path).expect("it was written")), &theirs);
    }
}

/// As a logger leaves it: no counts, the length of the only data block 0, and the last record cut where power was lost.
#[test]
fn a_file_that_was_never_finished_has_what_is_there() {
    let frames = excerpt();
    let form = Form { unfinished: 0x25, ..Form::default() };
    let bytes = file(form, &frames);
    assert_eq!(read(&bytes).0.len(), frames.len());
    // The offsets of payloads were to be filled in, too.
    let form = Form { unfinished: 0x65, ..form };
    assert_eq!(read(&file(form, &frames)).0.len(), frames.len());
    for cut in [1, 5, 11] {
        let (found, statistics) = read(&bytes[..bytes.len() - cut]);
        assert_eq!(found, read(&bytes).0[..frames.len() - 1], "{cut}");
        let said = statistics.first_bad_lines[0].to_string();
        assert!(said.contains("the data of variable length end before it"), "{said}");
        assert_eq!(statistics.damaged_inputs, 0, "which is how such a file ends");
    }
    // Without that mark nothing says that there is more.
    let mut finished = bytes.clone();
    finished[..8].copy_from_slice(b"MDF     ");
    let (found, statistics) = read(&finished);
    let said = statistics.first_bad_lines[0].to_string();
    assert!(found.is_empty() && said.contains("the length of a block, 24 or more"), "{said}");
}

#[test]
fn a_flaw_says_what_was_expected_and_where() {
    let frames = excerpt();
    let bytes = file(Form::default(), &frames);
    let find = |kind: &[u8]| {
        bytes.windows(4).position(|place| place == kind).expect("a block of this kind")
    };
    let [set, group, data] = [&b"##DG"[..], b"##CG", b"##DT"].map(find);
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
            [(1e300, 1e-9), (-1e300, 1e-9), (f64::NAN, 1e-9), (1e300, 0.1), (0.0, f64::INFINITY)]
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

/// A frame is known only once the file was read, which must not keep files from being put in order.
#[test]
fn files_are_sorted_by_their_first_frames() {
    let folder = tempfile::tempdir().expect("a folder");
    let frames = excerpt();
    let names = ["c.mf4", "b.mf4.gz", "a.mf4"].map(|name| folder.path().join(name));
    let [early, between, late] = &names;
    fs::write(early, file(Form::default(), &frames[..10])).expect("a file");
    fs::write(late, file(Form::default(), &frames[20..])).expect("a file");
    // One that is damaged has its place by what can be read of it.
    let mut packer = GzEncoder::new(Vec::new(), Compression::none());
    packer.write_all(&file(Form::default(), &frames[10..20])).expect("a vector takes all");
    let packed = packer.finish().expect("a vector takes all");
    fs::write(between, &packed[..packed.len() - 40]).expect("a file");
    let sorted = in_order(&[late.clone(), between.clone(), early.clone()], &Interfaces::All);
    assert_eq!(sorted, names);
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
