//! Recordings whose frames a logger wrote late, with the right time stamps.

use std::fs;

use proptest::prelude::*;
use tertius::bus::{Lateness, Options, Recording, Statistics, append_log_line};
use tertius::frame::{Frame, Id, Kind};
use tertius::time::{Span, Timestamp};
use tertius_testing::candump::{drain, read, read_in_pieces};
use tertius_testing::machine::MS;

const START: i64 = 1_700_000_000_000 * MS;

/// A frame of `id` at a time, ms.
fn frame(at: i64, id: u32) -> Frame {
    let id = Id::standard(id).expect("11 bits");
    let at_ns = Timestamp::from_nanos(START + at * MS);
    Frame::new(at_ns, id, Kind::Data, &(at as u32).to_le_bytes())
}

/// Frames of four identifiers, one each 5 ms, in the order of time.
fn in_order(seconds: i64) -> Vec<Frame> {
    (0..seconds * 200).map(|n| frame(5 * n, 0x100 + n as u32 % 4)).collect()
}

/// The same, those of identifier 103 written every `period` ms.
fn written_late(frames: &[Frame], period: i64) -> Vec<Frame> {
    let is_late = |it: &Frame| it.id.value() == 0x103;
    let at = |it: &Frame| (it.timestamp.as_nanos() - START) / MS;
    let mut written = frames.to_vec();
    // Stable: what is written at the same time remains in order.
    written.sort_by_key(|it| if is_late(it) { (at(it) / period + 1) * period } else { at(it) });
    written
}

fn log(frames: &[Frame]) -> Vec<u8> {
    let mut text = Vec::new();
    frames.iter().for_each(|it| append_log_line(&mut text, "can0", it));
    text
}

/// Reads a log from a file.
fn read_file(log: &[u8]) -> (Vec<Frame>, Statistics) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("unsorted.log");
    fs::write(&path, log).expect("it can be written");
    drain(Recording::open(&[path], Options::default()).expect("it opens"))
}

#[test]
fn frames_that_were_written_late_come_in_the_order_of_time() {
    let frames = in_order(40);
    for period in [100, 400, 3000, 9000] {
        let written = written_late(&frames, period);
        assert_ne!(written, frames, "{period}");
        let (found, statistics) = read_file(&log(&written));
        assert_eq!(found, frames, "{period}");
        assert_eq!((statistics.bad_lines, statistics.frames), (0, frames.len() as u64));
        assert_eq!(statistics.interfaces_found(), format!("can0 ({} frames)", frames.len()));
        let Lateness { sorted, most, lost } = statistics.lateness;
        // The first ones are known by those that follow.
        assert!((1500..=2000).contains(&sorted) && lost == 0, "{period}: {sorted} {lost}");
        assert!(most.as_nanos() <= period * MS && most.as_nanos() > (period - 40) * MS, "{period}");
    }
}

/// A pipe has its first frames held back.
#[test]
fn a_pipe_is_sorted_as_a_file_is() {
    let frames = in_order(40);
    let written = log(&written_late(&frames, 400));
    let (found, statistics) = read(&written);
    assert!(found == frames);
    for sizes in [&[1][..], &[7, 0, 4096]] {
        let pieces = read_in_pieces(&written, sizes, Options::default());
        assert_eq!(pieces, (found.clone(), statistics.clone()));
    }
}

/// A logger that is late only once the recording has gone on for long.
#[test]
fn a_file_that_is_out_of_order_later_on_is_sorted_from_there() {
    let frames = in_order(200);
    let (first, rest) = frames.split_at(100 * 200);
    let written = [first.to_vec(), written_late(rest, 1000)].concat();
    let (found, _) = read_file(&log(&written));
    assert_eq!(found.len(), frames.len());
    let until = found.windows(2).rposition(|pair| pair[1].timestamp < pair[0].timestamp);
    let until = (found[until.expect("the first late frames")].timestamp.as_nanos() - START) / MS;
    assert!((100_000..104_000).contains(&until), "{until} ms");
}

#[test]
fn a_clock_that_was_set_back_is_left_as_it_is() {
    for back in [50, 400, 900, 5000, 50_000] {
        let before = in_order(60);
        let after = in_order(120).split_off(60 * 200);
        let set = |it: Frame| {
            let at = it.timestamp.after(Span::from_nanos(-back * MS));
            Frame::new(at, it.id, it.kind, it.data())
        };
        let written: Vec<Frame> = before.into_iter().chain(after.into_iter().map(set)).collect();
        let (found, statistics) = read_file(&log(&written));
        assert!(found == written, "{back} ms");
        assert_eq!(statistics.lateness, Lateness::default());
        // Nor is it sorted across where a logger is late, too.
        let (first, second) = written.split_at(60 * 200);
        let late = |frames: &[Frame]| written_late(frames, 400);
        let (found, _) = read_file(&log(&[late(first), late(second)].concat()));
        let steps = found.windows(2).filter(|pair| pair[1].timestamp < pair[0].timestamp).count();
        assert!((1..=4).contains(&steps), "{back} ms: {steps} steps back");
    }
}

#[test]
fn what_is_too_late_to_be_sorted_is_counted() {
    let frames = in_order(60);
    let (found, statistics) = read_file(&log(&written_late(&frames, 25_000)));
    assert_eq!(found.len(), frames.len(), "nothing is lost");
    assert!(statistics.lateness.lost > 500, "{:?}", statistics.lateness);
}

#[test]
fn each_frame_keeps_its_interface() {
    let frames = in_order(10);
    let mut text = Vec::new();
    for it in written_late(&frames, 400) {
        let interface = if it.id.value() == 0x103 { "can1" } else { "can0" };
        append_log_line(&mut text, interface, &it);
    }
    for (only, expected) in [("can0", 1500), ("can1", 500)] {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("two.log");
        fs::write(&path, &text).expect("it can be written");
        let interfaces = tertius::bus::Interfaces::Only(only.to_owned());
        let options = Options { interfaces, ..Options::default() };
        let (found, statistics) = drain(Recording::open(&[path], options).expect("it opens"));
        assert_eq!(found.len(), expected, "{only}");
        assert!(found.iter().all(|it| (it.id.value() == 0x103) == (only == "can1")));
        assert_eq!(statistics.interfaces_found(), "can0 (1500 frames), can1 (500 frames)");
    }
}

proptest! {
    /// Whatever the order, no frame is lost, and the sizes of the reads make no difference.
    #[test]
    fn any_order_has_all_frames(
        steps in prop::collection::vec((-15_000..15_000_i64, 0..4_u32), 0..400),
        sizes in prop::collection::vec(1..200_usize, 1..4),
    ) {
        let mut at = 100_000;
        let frames: Vec<Frame> = steps
            .iter()
            .map(|(step, id)| {
                at += if step % 3 == 0 { *step } else { step.rem_euclid(10) };
                frame(at, 0x100 + id)
            })
            .collect();
        let text = log(&frames);
        let (found, statistics) = read(&text);
        prop_assert_eq!(statistics.frames, frames.len() as u64);
        let pieces = read_in_pieces(&text, &sizes, Options::default());
        prop_assert_eq!(&pieces.0, &found);
        let sorted = |mut frames: Vec<Frame>| {
            frames.sort_by_key(|it| (it.timestamp, it.id.value()));
            frames
        };
        let from_file = read_file(&text).0;
        prop_assert_eq!(&sorted(from_file), &sorted(frames.clone()));
        prop_assert_eq!(sorted(found), sorted(frames));
    }
}
