//! Bus logging in MDF 4: written by python-can and here, and read by both.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::{Value, json};
use tertius::bus::{Interfaces, Options, in_order};
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

/// Frames of the machine, and others of every kind.
pub fn excerpt() -> Vec<Frame> {
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

/// Every form of the data.
pub fn forms() -> Vec<Form> {
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

/// A logger with a buffer for each group writes each when it is full.
#[test]
fn groups_that_were_written_in_turn_are_read_in_the_order_of_time() {
    let start = excerpt()[0].timestamp.as_nanos();
    let id = Id::standard(0x123).expect("11 bits");
    // One a second, which is farther apart than frames of one group are sorted.
    let frames: Vec<Frame> = (0..60)
        .map(|n| {
            let at = Timestamp::from_nanos(start + i64::from(n) * 1_000_000_000);
            match n % 3 {
                0 => Frame::new(at, id, Kind::Remote { length: 3 }, &[]),
                _ => Frame::new(at, id, Kind::Data, &[n, 1, 2]),
            }
        })
        .collect();
    let (remotes, data): (Vec<Frame>, Vec<Frame>) =
        frames.iter().cloned().partition(|it| matches!(it.kind, Kind::Remote { .. }));
    for form in forms() {
        let bytes = file(Form { whole: true, ..form }, &[data.clone(), remotes.clone()].concat());
        let (found, statistics) = read(&bytes);
        assert_eq!(statistics.bad_lines, 0, "{form:?} {:?}", statistics.first_bad_lines);
        assert_eq!(found, frames, "{form:?}");
        let others = if form.mixed { frames.len() / 5 } else { 0 };
        let parts = bytes.len().div_ceil(1 << 16);
        assert_eq!(statistics.lines as usize, frames.len() + others + parts, "{form:?}");
    }
    // What is lost behind a damaged record is told once, and not by each reader.
    let form = Form { stored: Stored::Block, variable: false, unfinished: 0x25, ..Form::default() };
    let bytes = file(form, &[data, remotes].concat());
    let (found, statistics) = read(&bytes[..bytes.len() - 12]);
    assert!(found.len() < frames.len(), "{}", found.len());
    assert_eq!(statistics.bad_lines, 1);
}

/// A logger with a buffer for each message writes them into one group, each when it is full. The clock may be set back.
#[test]
fn messages_of_one_group_that_were_written_in_turn_are_read_in_the_order_of_time() {
    let start = excerpt()[0].timestamp.as_nanos();
    let frame = |k: i64, id: u32| {
        let at = Timestamp::from_nanos(start + k * 20_000_000 + i64::from(id & 0xF0) * 10_000);
        Frame::new(at, Id::standard(id).expect("11 bits"), Kind::Data, &[k as u8, 1, 2])
    };
    let blocks = |range: std::ops::Range<i64>| {
        let cycles: Vec<i64> = range.collect();
        let of_block = |block: &[i64]| -> Vec<Frame> {
            [0x211, 0x201].iter().flat_map(|id| block.iter().map(|k| frame(*k, *id))).collect()
        };
        cycles.chunks(25).flat_map(of_block).collect::<Vec<Frame>>()
    };
    let in_order = |range: std::ops::Range<i64>| -> Vec<Frame> {
        range.flat_map(|k| [frame(k, 0x201), frame(k, 0x211)]).collect()
    };
    for form in forms() {
        let form = Form { whole: true, ..form };
        let (found, statistics) = read(&file(form, &blocks(0..100)));
        assert_eq!((found, statistics.bad_lines), (in_order(0..100), 0), "{form:?}");
        let set_back = [in_order(500..600), in_order(0..100)].concat();
        assert_eq!(read(&file(form, &set_back)).0, set_back, "{form:?}");
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
