//! PEAK traces: written and read by python-can, and by hand as PEAK specifies them.

use std::fs;

use proptest::prelude::*;
use proptest::sample::Index;
use serde_json::{Value, json};
use tertius::bus::{BadPlace, Options, Reason, Recording, SourceError, in_order};
use tertius::error_frame::ErrorFrame;
use tertius::frame::{Frame, Id, Kind};
use tertius::time::Timestamp;
use tertius_testing::candump::{drain, read, read_in_pieces};
use tertius_testing::oracle;

/// 2023-11-14 22:13:20 UTC in µs, and as days since 1899-12-30.
const START: i64 = 1_700_000_000_000_000;
const DAYS: &str = "45244.92592592593";

fn data(micros: i64, id: Id, kind: Kind, data: &[u8]) -> Frame {
    Frame::new(Timestamp::from_nanos(1000 * micros), id, kind, data)
}

fn standard(id: u32) -> Id {
    Id::standard(id).expect("11 bits")
}

fn extended(id: u32) -> Id {
    Id::extended(id).expect("29 bits")
}

/// A trace of each version with a data frame, an extended one, a remote one, and what is no frame.
fn traces() -> Vec<(&'static str, String)> {
    let start = format!(";$STARTTIME={DAYS}");
    let versions: [(&str, &[&str]); 6] = [
        (
            "1.0",
            &[
                ";##########",
                ";   Start time: 14.11.2023 22:13:20.000",
                "     1)      10  0181  2  E0 2D ",
                "     2)      20  18FEF100  1  01 ",
                "     3)      20  FFFFFFFF  4  00 00 00 04  ------BUSLIGHT",
                "     4)      30  0100  3  RTR",
            ],
        ),
        (
            "1.1",
            &[
                ";$FILEVERSION=1.1",
                &start,
                "     1)      10.0  Rx         0181  2  E0 2D ",
                "     2)      20.0  Tx     18FEF100  1  01 ",
                "     3)      20.0  Warng  FFFFFFFF  4  00 00 00 08  BUSHEAVY",
                "     4)      30.0  Rx         0100  3  RTR",
            ],
        ),
        (
            "1.2",
            &[
                ";$FILEVERSION=1.2",
                &start,
                "     1)      10.000 1  Rx         0181  2  E0 2D ",
                "     2)      20.000 1  Tx     18FEF100  1  01 ",
                "     3)      20.000 1  Warng  FFFFFFFF  4  00 00 00 08  BUSHEAVY",
                "     4)      30.000 1  Rx         0100  3  RTR",
            ],
        ),
        (
            "1.3",
            &[
                ";$FILEVERSION=1.3",
                &start,
                "     1)      10.000 1  Rx        0181 -  2    E0 2D ",
                "     2)      20.000 1  Tx    18FEF100 -  1    01 ",
                "     3)      20.000 1  Warng FFFFFFFF -  4    00 00 00 04 BUSLIGHT",
                "     4)      30.000 1  Rx        0100 -  3    RTR",
            ],
        ),
        (
            "2.0",
            &[
                ";$FILEVERSION=2.0",
                &start,
                ";$COLUMNS=N,O,T,I,d,l,D",
                "      1        10.000 DT     0181 Rx 2  E0 2D ",
                "      2        20.000 DT 18FEF100 Tx 1  01 ",
                "      3        20.000 ST          Rx    00 00 00 08",
                "      4        20.000 EC          Rx    02 02",
                "      5        30.000 RR     0100 Rx 3",
            ],
        ),
        (
            "2.1",
            &[
                ";$FILEVERSION=2.1",
                &start,
                ";$COLUMNS=N,O,T,B,I,d,R,L,D",
                "      1        10.000 DT 1      0181 Rx -  2    E0 2D ",
                "      2        20.000 DT 1  18FEF100 Tx -  1    01 ",
                "      3        20.000 ST 1      -    Rx -  4    00 00 00 08",
                "      4        20.000 EC 1      -    Rx -  2    02 02",
                "      5        30.000 RR 1      0100 Rx -  3",
            ],
        ),
    ];
    let joined = |(version, lines): (_, &[&str])| (version, lines.join("\r\n") + "\r\n");
    versions.map(joined).to_vec()
}

/// A frame as the script prints it.
fn printed(frame: &Frame) -> Value {
    let hex: String = frame.data().iter().map(|byte| format!("{byte:02x}")).collect();
    let remote = matches!(frame.kind, Kind::Remote { .. });
    let (id, micros) = (frame.id, frame.timestamp.as_nanos() / 1000);
    json!([micros, id.value(), id.is_extended(), remote, false, false, false, 1, hex])
}

#[test]
fn every_version_is_read_as_it_is_specified_and_as_python_can_reads_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut paths, mut ours) = (Vec::new(), Vec::new());
    for (version, trace) in traces() {
        let (frames, statistics) = read(trace.as_bytes());
        let start = if version == "1.0" { 0 } else { START };
        let expected = [
            data(start + 10_000, standard(0x181), Kind::Data, &[0xE0, 0x2D]),
            data(start + 20_000, extended(0x18FE_F100), Kind::Data, &[1]),
            data(start + 30_000, standard(0x100), Kind::Remote { length: 3 }, &[]),
        ];
        assert_eq!(frames, expected, "{version}: {:?}", statistics.first_bad_lines);
        assert_eq!(statistics.bad_lines, 0, "{version}: {:?}", statistics.first_bad_lines);
        assert_eq!(statistics.interfaces_found(), "bus1 (3 frames)", "{version}");
        for sizes in [&[1][..], &[7, 0, 64]] {
            let pieces = read_in_pieces(trace.as_bytes(), sizes, Options::default());
            assert_eq!(pieces, (frames.clone(), statistics.clone()), "{version}");
        }
        // python-can does not read version 1.2.
        if version != "1.2" {
            let path = folder.path().join(format!("{version}.trc"));
            fs::write(&path, &trace).expect("it can be written");
            paths.push(path.display().to_string());
            ours.push(frames.iter().map(printed).collect::<Vec<_>>());
        }
    }
    let call: Vec<&str> = std::iter::once("read").chain(paths.iter().map(String::as_str)).collect();
    let theirs: Vec<Vec<Value>> =
        serde_json::from_str(&oracle::run("trc.py", &call, "")).expect("JSON");
    assert_eq!(ours.len(), theirs.len());
    for ((path, ours), theirs) in paths.iter().zip(&ours).zip(&theirs) {
        assert_eq!(ours.len(), theirs.len(), "{path}");
        for (one, other) in ours.iter().zip(theirs) {
            let [one, other] = [one, other].map(|it| it.as_array().expect("a list"));
            assert_eq!(one[1..], other[1..], "{path}");
            // A double has steps of 0.24 µs there, and days have steps of 0.6 µs.
            let apart = one[0].as_i64().expect("µs") - other[0].as_i64().expect("µs");
            assert!(apart.abs() <= 1, "{path}: {one:?} {other:?}");
        }
    }
}

#[test]
fn what_python_can_writes_is_the_candump_that_it_was_made_from() {
    let folder = tempfile::tempdir().expect("a folder");
    let log = "tests/oracle/e-type-excerpt.log";
    let (frames, _) = read(&fs::read(oracle::top().join(log)).expect("the excerpt"));
    assert!(frames.len() > 40);
    // Version 1.0 counts whole milliseconds, from zero.
    let begin = frames[0].timestamp.as_nanos();
    for (version, zero, tolerance) in [("1.0", begin, 500_001), ("2.1", 0, 2_000)] {
        let path = folder.path().join("written.trc");
        let trace = path.display().to_string();
        oracle::run("trc.py", &["write", version, log, &trace], "");
        let (written, statistics) =
            drain(Recording::open(&[&path], Options::default()).expect("it opens"));
        assert_eq!((written.len(), statistics.bad_lines), (frames.len(), 0), "{version}");
        for (one, other) in written.iter().zip(&frames) {
            assert_eq!((one.id, one.kind, one.data()), (other.id, other.kind, other.data()));
            let apart = one.timestamp.as_nanos() - (other.timestamp.as_nanos() - zero);
            assert!(apart.abs() <= tolerance, "{version}: {apart} ns");
        }
    }
}

#[test]
fn can_fd_buses_and_error_frames_are_told_apart() {
    let text = format!(
        ";$FILEVERSION=2.1\n;$STARTTIME={DAYS}\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n\
         1 1.0 FD 1 0123 Rx - 9 01 02 03 04 05 06 07 08 09 0A 0B 0C\n\
         2 2.0 FB 2 0123 Rx - 1 01\n\
         3 3.0 BI 2 0123 Rx - 0\n\
         4 4.0 FE 2 0123 Rx - 1 01\n\
         5 5.0 ER 2 - Rx - 5 04 00 02 00 00\n\
         6 6.0 ST 2 - Rx - 4 00 00 00 10\n"
    );
    let (frames, statistics) = read(text.as_bytes());
    assert_eq!(statistics.bad_lines, 0, "{:?}", statistics.first_bad_lines);
    let found: Vec<_> = frames.iter().map(|frame| (frame.id.value(), frame.kind)).collect();
    let fd = |flags| (0x123, Kind::Fd { flags });
    assert_eq!(found, [fd(0), fd(1), fd(2), fd(3), (0x80, Kind::Error), (0x40, Kind::Error)]);
    assert_eq!(frames[0].data(), [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]);
    assert_eq!(statistics.interfaces_found(), "bus1 (1 frame), bus2 (5 frames)");
    assert!(ErrorFrame::read(&frames[5]).is_some_and(|error| error.is_bus_off()));
}

#[test]
fn a_bad_line_says_what_was_expected_and_changes_nothing_else() {
    let good = "1 10.000 DT 0181 Rx 2 E0 2D\n";
    let head = format!(";$FILEVERSION=2.0\n;$STARTTIME={DAYS}\n;$COLUMNS=N,O,T,I,d,l,D\n");
    for (line, reason) in [
        ("2 x DT 0181 Rx 1 00", "found “x”, expected the time since the start in milliseconds"),
        ("2 1.0 XX 0181 Rx 1 00", "found “X”, expected the type of a message, such as Rx, Tx, DT"),
        ("2 1.0 DT 0G81 Rx 1 00", "found “G” in the identifier, expected a hexadecimal digit"),
        ("2 1.0 DT 0800 Rx 1 00", "the identifier 800 is out of range, expected at most 7FF"),
        ("2 1.0 DT FFFFFFFF Rx 1 00", "the identifier FFFFFFFF is out of range"),
        ("2 1.0 DT 0181 Rx 2 00", "the line announces 2 bytes, but 1 follow"),
        ("2 1.0 DT 0181 Rx 1 00 11", "found “1” after the frame, expected the end of the line"),
        ("2 1.0 DT 0181 Rx 1 0x", "found “x” in the data, expected a hexadecimal digit"),
        ("2 1.0 DT 0181 Rx 9 00", "more than 8 bytes of data in a classic frame"),
        ("2 1.0 FD 0181 Rx 9 00", "9 bytes of data, but a CAN FD frame has"),
        ("2 1.0 DT 0181 Rx - 00", "found “-”, expected the number of bytes of data"),
        ("2 1.0 DT", "found the end of the line, expected"),
        ("2 9999999999999 DT 0181 Rx 1 00", "found “9”, expected the time since the start"),
    ] {
        let (frames, statistics) = read(format!("{head}{good}{line}\n{good}").as_bytes());
        assert_eq!((frames.len(), statistics.bad_lines), (2, 1), "{line}");
        let bad = &statistics.first_bad_lines[0];
        assert!(bad.reason.to_string().starts_with(reason), "{line}: {bad}");
        assert_eq!((bad.place, bad.text.as_str()), (BadPlace::Line(5), line));
    }
    let (frames, statistics) = read(format!(";$FILEVERSION=3.0\n{good}").as_bytes());
    assert_eq!((frames.len(), statistics.bad_lines), (0, 1));
    let reason = statistics.first_bad_lines[0].reason.to_string();
    assert!(reason.contains("version 1.0 to 1.3, 2.0 or 2.1"), "{reason}");
    let (_, statistics) = read(b";$STARTTIME=today\n");
    assert_eq!(statistics.bad_lines, 1);
    let late = ";$FILEVERSION=2.0\n;$STARTTIME=999999999999.999999999999\n";
    let (_, statistics) = read(format!("{late}{good}").as_bytes());
    assert_eq!(statistics.first_bad_lines[0].reason, Reason::StampRange);
}

#[test]
fn formats_may_follow_one_another_and_are_put_in_order_by_their_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).expect("it can be written");
        path
    };
    let traces = traces();
    let (_, newest) = traces.last().expect("there are six");
    let (before, trace) = (write("a", "(1699999999.000000) bus1 7FF#\n"), write("trace", newest));
    let after = write("b", &"(1700000001.000000) bus1 7FE#\n".repeat(4));
    let paths = [&before, &trace, &after];
    let (frames, statistics) =
        drain(Recording::open(&paths, Options::default()).expect("they open"));
    let ids: Vec<u32> = frames.iter().map(|frame| frame.id.value()).collect();
    assert_eq!(ids, [0x7FF, 0x181, 0x18FE_F100, 0x100, 0x7FE, 0x7FE, 0x7FE, 0x7FE]);
    assert_eq!(statistics.interfaces_found(), "bus1 (8 frames)");
    let wrong = Recording::open(&[&trace, &before], Options::default()).err();
    assert!(matches!(wrong, Some(SourceError::Order { .. })));
    let sorted =
        in_order(&[after.clone(), trace.clone(), before.clone()], &Options::default().interfaces);
    assert_eq!(sorted, [before, trace, after]);
}

proptest! {
    /// Whatever becomes of some bytes, nothing breaks, every line is accounted for, and the sizes of the
    /// reads make no difference.
    #[test]
    fn damaged_traces_do_no_harm(
        version in 0..6_usize,
        damage in prop::collection::vec((any::<Index>(), any::<u8>()), 0..12),
        sizes in prop::collection::vec(1..200_usize, 1..4),
    ) {
        let mut text = traces().swap_remove(version).1.repeat(3).into_bytes();
        for (place, byte) in &damage {
            // Digits do the most harm.
            let byte = if byte % 2 == 0 { b'0' + byte % 10 } else { *byte };
            let place = place.index(text.len() - 1) + 1;
            text[place] = byte;
        }
        let (frames, statistics) = read(&text);
        prop_assert!(statistics.frames + statistics.bad_lines <= statistics.lines);
        prop_assert_eq!(statistics.frames, frames.len() as u64);
        let pieces = read_in_pieces(&text, &sizes, Options::default());
        prop_assert_eq!(pieces, (frames, statistics));
    }
}
