//! Vector logs in BLF: written and read by python-can, and damaged.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use proptest::prelude::*;
use proptest::sample::Index;
use serde_json::{Value, json};
use tertius::bus::{Interfaces, Options};
use tertius::frame::{Frame, Kind};
use tertius_testing::candump::{read, read_in_pieces, read_with};
use tertius_testing::oracle;

const LOG: &str = "tests/oracle/e-type-excerpt.log";

fn written(call: &[&str], folder: &Path) -> Vec<u8> {
    let path = folder.join("written.blf");
    let name = path.display().to_string();
    let call: Vec<&str> =
        call.iter().map(|word| if *word == "BLF" { &name } else { *word }).collect();
    oracle::run("blf.py", &call, "");
    fs::read(path).expect("it was written")
}

/// A frame as the script prints it.
fn printed(frame: &Frame, channel: u64) -> Value {
    let hex: String = frame.data().iter().map(|byte| format!("{byte:02x}")).collect();
    let (error, flags) = match frame.kind {
        Kind::Error => (true, 0),
        Kind::Fd { flags } => (false, flags),
        _ => (false, 0),
    };
    let remote = matches!(frame.kind, Kind::Remote { .. });
    let fd = matches!(frame.kind, Kind::Fd { .. });
    let (id, extended) = (frame.id.value(), frame.id.is_extended());
    let micros = frame.timestamp.as_nanos() / 1000;
    json!([micros, id, extended, remote, error, fd, flags & 1 != 0, flags & 2 != 0, channel, hex])
}

#[test]
fn every_kind_of_frame_is_read_as_python_can_reads_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let blf = written(&["made", "BLF"], folder.path());
    let path = folder.path().join("written.blf").display().to_string();
    let [theirs]: [Vec<Value>; 1] =
        serde_json::from_str(&oracle::run("blf.py", &["read", &path], "")).expect("JSON");
    let of = |channel: u64| {
        let interfaces = Interfaces::Only(format!("channel{channel}"));
        let (frames, statistics) = read_with(&blf, Options { interfaces, ..Options::default() });
        assert_eq!(statistics.bad_lines, 0, "{:?}", statistics.first_bad_lines);
        frames.into_iter().map(move |frame| printed(&frame, channel))
    };
    let mut ours: Vec<Value> = of(1).chain(of(2)).collect();
    ours.sort_by_key(|frame| frame[0].as_i64());
    assert_eq!(ours.len(), 7);
    for (ours, theirs) in ours.iter().zip(&theirs) {
        if theirs[4] == json!(true) {
            assert_eq!((&ours[0], &ours[4], &ours[8]), (&theirs[0], &theirs[4], &theirs[8]));
        } else {
            assert_eq!(ours, theirs);
        }
    }
}

/// A log with one object of type 101, a CAN FD frame of 64 bytes of which so many are stored, with so many bytes behind
/// them, which its head tells apart.
fn log_of_fd_64(stored: u8, behind: u8) -> Vec<u8> {
    let extra = if behind > 0 { 32 + 40 + stored } else { 0 };
    let mut object = [&b"LOBJ"[..], &[32, 0, 1, 0]].concat();
    object.extend((72 + u32::from(stored) + u32::from(behind)).to_le_bytes());
    object.extend([[101, 0, 0, 0], [2, 0, 0, 0], [0; 4]].concat());
    object.extend(1_000_000_u64.to_le_bytes());
    object.extend([1, 15, 64, 0, 1, 2, 0, 0, 0, 0, 0, 0, 0, 0x10, 0, 0]);
    object.extend([0; 19]);
    object.extend([extra, 0, 0, 0, 0]);
    object.extend(1..=stored);
    object.extend(vec![0xEE; behind.into()]);
    object.resize(object.len().next_multiple_of(4), 0);
    let length = 32 + object.len() as u32;
    let mut container =
        [&b"LOBJ"[..], &[16, 0, 1, 0], &length.to_le_bytes(), &[10, 0, 0, 0]].concat();
    container.extend([0; 8]);
    container.extend((object.len() as u32).to_le_bytes());
    container.extend([0; 4]);
    let size = u64::from(144 + length);
    let mut blf = [&b"LOGG"[..], &[144, 0, 0, 0], &[5, 0, 0, 0], &[4, 7, 8, 0]].concat();
    blf.extend([size, size].map(u64::to_le_bytes).concat());
    blf.extend([2_u32, 0].map(u32::to_le_bytes).concat());
    let date: [u16; 8] = [2023, 11, 2, 14, 22, 13, 20, 0];
    blf.extend([date, date].concat().into_iter().flat_map(u16::to_le_bytes));
    blf.resize(144, 0);
    [blf, container, object].concat()
}

#[test]
fn what_a_can_fd_frame_lacks_of_its_length_is_zeros() {
    let folder = tempfile::tempdir().expect("a folder");
    for (stored, behind) in [(64, 0), (48, 0), (48, 8), (5, 0), (0, 0)] {
        let blf = log_of_fd_64(stored, behind);
        let (frames, statistics) = read(&blf);
        assert_eq!((frames.len(), statistics.bad_lines), (1, 0), "{stored} {behind}");
        let mut data: Vec<u8> = (1..=stored).collect();
        data.resize(64, 0);
        assert_eq!(frames[0].data(), data, "{stored} {behind}");
        let path = folder.path().join("short.blf");
        fs::write(&path, blf).expect("it can be written");
        let path = path.display().to_string();
        let [theirs]: [Vec<Value>; 1] =
            serde_json::from_str(&oracle::run("blf.py", &["read", &path], "")).expect("JSON");
        assert_eq!(theirs, [printed(&frames[0], 1)], "{stored} {behind}");
    }
}

#[test]
fn what_python_can_writes_is_the_candump_that_it_was_made_from() {
    let folder = tempfile::tempdir().expect("a folder");
    let (frames, _) = read(&fs::read(oracle::top().join(LOG)).expect("the excerpt"));
    // Objects end within a container or in the next one.
    for (size, level) in [("131072", "-1"), ("131072", "0"), ("1000", "-1"), ("200", "0")] {
        let blf = written(&["write", LOG, "BLF", size, level], folder.path());
        let (found, statistics) = read(&blf);
        assert_eq!((found.len(), statistics.bad_lines), (frames.len(), 0), "{size} {level}");
        assert_eq!(statistics.interfaces_found(), format!("channel1 ({} frames)", frames.len()));
        for (one, other) in found.iter().zip(&frames) {
            assert_eq!((one.id, one.kind, one.data()), (other.id, other.kind, other.data()));
            // The start has milliseconds, and time stamps come by way of a double.
            let apart = one.timestamp.as_nanos() - other.timestamp.as_nanos();
            assert!(apart.abs() <= 501_000, "{apart} ns");
        }
        for sizes in [&[1][..], &[7, 0, 64]] {
            let pieces = read_in_pieces(&blf, sizes, Options::default());
            assert_eq!(pieces, (found.clone(), statistics.clone()), "{size} {level}");
        }
    }
}

/// The frames that the written logs are of.
fn frames_of_log() -> Vec<Frame> {
    read(&fs::read(oracle::top().join(LOG)).expect("the excerpt")).0
}

/// Places of the containers of a log.
fn containers(blf: &[u8]) -> Vec<usize> {
    let (mut at, mut places) = (144, Vec::new());
    while at < blf.len() {
        places.push(at);
        let length = blf[at + 8..at + 12].try_into().expect("four bytes");
        let length = u32::from_le_bytes(length) as usize;
        at += length + length % 4;
    }
    places
}

/// Whether all of `found` are among `frames` in their order, with at most one gap.
fn are_but_for_a_gap(found: &[Frame], frames: &[Frame]) -> bool {
    let is_same =
        |(one, other): &(&Frame, &Frame)| one.id == other.id && one.data() == other.data();
    let ahead = found.iter().zip(frames).take_while(is_same).count();
    let behind = found[ahead..].iter().rev().zip(frames.iter().rev()).take_while(is_same).count();
    ahead + behind == found.len()
}

#[test]
fn a_log_that_was_never_finished_has_what_is_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let frames = frames_of_log();
    let blf = written(&["write", LOG, "BLF", "1000", "0"], folder.path());
    let (found, statistics) = read(&blf[..blf.len() / 2]);
    assert!((frames.len() / 3..frames.len()).contains(&found.len()), "{}", found.len());
    assert!(found.iter().zip(&frames).all(|(one, other)| one.data() == other.data()));
    assert_eq!(statistics.damaged_inputs, 1, "it says so");
}

#[test]
fn a_log_that_is_cut_anywhere_has_its_whole_containers_and_is_damaged() {
    let folder = tempfile::tempdir().expect("a folder");
    let frames = frames_of_log();
    for level in ["0", "-1"] {
        let blf = written(&["write", LOG, "BLF", "1000", level], folder.path());
        let whole = containers(&blf);
        // One byte less may be of the padding behind the last container.
        let cuts = (144..blf.len() - 3).step_by(37).chain(whole.iter().copied());
        for cut in cuts {
            let (found, statistics) = read(&blf[..cut]);
            let told = (statistics.damaged_inputs, statistics.damage.len());
            assert_eq!(told, (1, 1), "{cut} of {}", blf.len());
            assert_eq!(statistics.bad_lines, 1, "{:?}", statistics.first_bad_lines);
            let is_sound = |(one, other): (&Frame, &Frame)| one.data() == other.data();
            assert!(found.iter().zip(&frames).all(is_sound), "{cut}");
            let containers = whole.iter().filter(|place| **place <= cut).count() - 1;
            assert!(found.len() + 1 >= containers * 1000 / 48, "{} at {cut}", found.len());
            let said = statistics.damage[0].to_string();
            assert!(said.contains("frames are missing; at byte "), "{said}");
            assert!(said.contains("found the end of the file, expected "), "{said}");
        }
        let (found, statistics) = read(&blf);
        assert_eq!((found.len(), statistics.damaged_inputs), (frames.len(), 0));
    }
}

#[test]
fn an_object_that_its_last_container_cuts_off_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut blf = written(&["write", LOG, "BLF", "131072", "0"], folder.path());
    let (frames, short) = (frames_of_log().len(), blf.len() - 8);
    let length = (short - 144) as u32;
    blf.truncate(short);
    blf[144 + 8..144 + 12].copy_from_slice(&length.to_le_bytes());
    blf[16..24].copy_from_slice(&(short as u64).to_le_bytes());
    let (found, statistics) = read(&blf);
    assert_eq!((found.len(), statistics.damaged_inputs), (frames - 1, 1));
    let said = statistics.damage[0].to_string();
    assert!(said.contains("expected the rest of the last object"), "{said}");
}

#[test]
fn an_object_without_a_length_ends_and_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let blf = written(&["write", LOG, "BLF", "131072", "0"], folder.path());
    let container = 144;
    assert_eq!(&blf[container..container + 4], b"LOBJ");
    for (at, told) in [
        // The container's own length, and that of the second object in it.
        (container + 8, "an object, which begins with LOBJ and its length"),
        (container + 32 + 48 + 8, "the length of an object, 16 or more"),
    ] {
        let mut damaged = blf.clone();
        damaged[at..at + 4].fill(0);
        let (_, statistics) = read(&damaged);
        let said = statistics.first_bad_lines[0].reason.to_string();
        assert!(said.contains(told), "{said}");
    }
    let mut unknown = blf.clone();
    unknown[container + 16] = 9;
    let (found, statistics) = read(&unknown);
    assert_eq!((found.len(), statistics.bad_lines), (0, 1));
    let said = statistics.first_bad_lines[0].reason.to_string();
    assert!(said.contains("a container that is compressed by zlib, or not at all"), "{said}");
}

#[test]
fn a_container_of_which_a_bit_is_wrong_is_left_out_and_those_behind_it_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let frames = frames_of_log();
    let blf = written(&["write", LOG, "BLF", "1000", "-1"], folder.path());
    let places = containers(&blf);
    let (begin, end) = (places[1] + 32, places[2] - 3);
    for bit in (begin * 8..end * 8).step_by(5) {
        let mut damaged = blf.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        let (found, statistics) = read(&damaged);
        // The objects that begin before it or end behind it are lost with it.
        let missing = frames.len() - found.len();
        assert!((1000 / 48..=1000 / 48 + 2).contains(&missing), "{missing} at {bit}");
        assert!(are_but_for_a_gap(&found, &frames), "only what was sent, at {bit}");
        assert_eq!((statistics.damaged_inputs, statistics.bad_lines), (1, 1), "{bit}");
        let said = statistics.damage[0].to_string();
        let place = format!("frames are missing; at byte {}: the data of a container", places[1]);
        assert!(said.contains(&place) && said.contains("checksum"), "{said}");
    }
}

/// Logs with and without compression, in containers of which objects stick out.
static LOGS: LazyLock<[Vec<u8>; 3]> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("a folder");
    let of = |size, level| written(&["write", LOG, "BLF", size, level], folder.path());
    [of("500", "0"), of("1000", "-1"), written(&["made", "BLF"], folder.path())]
});

proptest! {
    /// Whatever becomes of some bytes, nothing breaks, every record is accounted for, and the sizes of the
    /// reads make no difference.
    #[test]
    fn damaged_binary_logs_do_no_harm(
        which in 0..3_usize,
        damage in prop::collection::vec((any::<Index>(), any::<u8>()), 0..8),
        sizes in prop::collection::vec(1..200_usize, 1..4),
    ) {
        let mut bytes = LOGS[which].clone();
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
