//! Vector logs in ASC: written and read by python-can, and by hand as Vector's tools write them.

use std::fs;

use proptest::prelude::*;
use proptest::sample::Index;
use serde_json::{Value, json};
use tertius::bus::{BadPlace, Interfaces, Options, Recording, SourceError, in_order};
use tertius::frame::{Frame, Kind};
use tertius_testing::candump::{drain, read, read_in_pieces};
use tertius_testing::oracle;

/// 2017-09-30 15:06:13.191 UTC, µs.
const START: i64 = 1_506_783_973_191_000;

/// Logs that python-can reads, too: hexadecimal and decimal, of classic CAN and CAN FD.
const LOGS: [&str; 4] = [
    "date Sat Sep 30 15:06:13.191 2017\n\
     base hex  timestamps absolute\n\
     internal events logged\n\
     // version 9.0.0\n\
     Begin Triggerblock Sat Sep 30 15:06:13.191 2017\n\
        0.000000 Start of measurement\n\
        0.015991 CAN 1 Status:chip status error active\n\
        0.015991 1  Statistic: D 0 R 0 XD 0 XR 0 E 0 O 0 B 0.00%\n\
        2.501000 1  ErrorFrame\n\
        3.098426 1  4D   Tx  d 8 00 01 02 03 04 05 06 07  Length = 244000 BitCount = 125 ID = 198\n\
        3.148421 2  18FEF100x Rx   d 1 A1\n\
        3.158421 1  181             Rx   d 0\n\
        3.248421 1  100             Rx   r 3\n\
        3.348421 1  100             Rx   r\n\
     End TriggerBlock\n",
    "date Sat Sep 30 03:06:13.191 pm 2017\n\
     base dec  timestamps absolute\n\
     no internal events logged\n\
        2.5010 1  385 Rx d 2 224 45\n\
        2.6010 1  419360000x Rx d 1 255\n",
    "date Sat Sep 30 15:06:13.191 2017\n\
     base hex  timestamps absolute\n\
     internal events logged\n\
        1.0 CANFD   1 Rx        181  Position                 1 0 9 12 01 02 03 04 05 06 07 08 09 0A 0B 0C   0    0     3000        0        0        0        0        0\n\
        2.0 CANFD   2 Tx   18FEF100x                          0 1 1  1 FF   0    0     3000        0        0        0        0        0\n\
        3.0 CANFD   1 Rx ErrorFrame   \n",
    "date Fri May 18 3:7:1 pm 2012\n\
     base hex  timestamps absolute\n\
     no internal events logged\n\
        1.5 1  181 Rx d 1 01\n",
];

/// A frame as the script prints it.
fn printed(frame: &Frame, channel: u64) -> Value {
    let hex: String = frame.data().iter().map(|byte| format!("{byte:02x}")).collect();
    let micros = frame.timestamp.as_nanos() / 1000;
    let error = frame.kind == Kind::Error;
    let id = if error { json!(0) } else { json!(frame.id.value()) };
    let is = |kind: fn(&Kind) -> bool| kind(&frame.kind);
    let flags = if let Kind::Fd { flags } = frame.kind { flags } else { 0 };
    json!([
        micros,
        id,
        frame.id.is_extended(),
        is(|kind| matches!(kind, Kind::Remote { .. })),
        error,
        is(|kind| matches!(kind, Kind::Fd { .. })),
        flags & 1 != 0,
        flags & 2 != 0,
        channel,
        hex
    ])
}

/// The frames of each log, with their channels.
fn ours(log: &str) -> Vec<Value> {
    let frames = |channel: u64| {
        let options = Options {
            interfaces: tertius::bus::Interfaces::Only(format!("channel{channel}")),
            ..Options::default()
        };
        let (frames, statistics) = tertius_testing::candump::read_with(log.as_bytes(), options);
        assert_eq!(statistics.bad_lines, 0, "{:?}", statistics.first_bad_lines);
        frames.into_iter().map(move |frame| (frame.timestamp, printed(&frame, channel)))
    };
    let mut all: Vec<_> = frames(1).chain(frames(2)).collect();
    all.sort_by_key(|(at, _)| *at);
    all.into_iter().map(|(_, frame)| frame).collect()
}

#[test]
fn logs_are_read_as_python_can_reads_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |(n, log): (usize, &&str)| {
        let path = folder.path().join(format!("{n}.asc"));
        fs::write(&path, log).expect("it can be written");
        path.display().to_string()
    };
    let paths: Vec<String> = LOGS.iter().enumerate().map(write).collect();
    let call: Vec<&str> = std::iter::once("read").chain(paths.iter().map(String::as_str)).collect();
    let theirs: Vec<Vec<Value>> =
        serde_json::from_str(&oracle::run("asc.py", &call, "")).expect("JSON");
    for (log, theirs) in LOGS.iter().zip(theirs) {
        let comparable = |frame: &Value| {
            let mut frame = frame.as_array().expect("a list").clone();
            if frame[4] == json!(true) {
                // python-can gives error frames an extended identifier of 0, and tells those of CAN FD apart.
                (frame[1], frame[2], frame[5]) = (json!(0), json!(true), json!(false));
            }
            frame
        };
        let ours: Vec<_> = ours(log).iter().map(comparable).collect();
        assert_eq!(ours, theirs.iter().map(comparable).collect::<Vec<_>>(), "{log}");
    }
    let (frames, _) = read(LOGS[0].as_bytes());
    assert_eq!(frames[0].timestamp.as_nanos(), 1000 * (START + 2_501_000));
}

#[test]
fn what_python_can_writes_is_the_candump_that_it_was_made_from() {
    let folder = tempfile::tempdir().expect("a folder");
    let log = "tests/oracle/e-type-excerpt.log";
    let (frames, _) = read(&fs::read(oracle::top().join(log)).expect("the excerpt"));
    let path = folder.path().join("written.asc");
    oracle::run("asc.py", &["write", log, &path.display().to_string()], "");
    let (written, statistics) =
        drain(Recording::open(&[&path], Options::default()).expect("it opens"));
    assert_eq!((written.len(), statistics.bad_lines), (frames.len(), 0));
    assert_eq!(statistics.interfaces_found(), format!("channel1 ({} frames)", frames.len()));
    for (one, other) in written.iter().zip(&frames) {
        assert_eq!((one.id, one.kind, one.data()), (other.id, other.kind, other.data()));
        // The date has milliseconds.
        let apart = one.timestamp.as_nanos() - other.timestamp.as_nanos();
        assert!(apart.abs() <= 1_001_000, "{apart} ns");
    }
}

#[test]
fn times_may_count_from_the_event_before() {
    let log = "base hex timestamps relative\n\
               0.5 1 181 Rx d 1 01\n\
               0.25 CAN 1 Status:chip status error active\n\
               0.25 1 181 Rx d 1 02\n";
    let (frames, _) = read(log.as_bytes());
    let times: Vec<i64> = frames.iter().map(|frame| frame.timestamp.as_nanos()).collect();
    assert_eq!(times, [500_000_000, 1_000_000_000]);
}

/// Of 2012-05-18.
const MIDNIGHT: i64 = 1_337_299_200;

/// The times of the frames of a log that begins so, s and µs since the midnight of its date.
fn times_of_day(head: &str, times: &[&str]) -> Vec<(i64, i64)> {
    let lines: String = times.iter().map(|time| format!("{time} 1 181 Rx d 1 01\n")).collect();
    let (frames, statistics) = read(format!("{head}\n{lines}").as_bytes());
    assert_eq!(statistics.bad_lines, 0, "{head}: {:?}", statistics.first_bad_lines);
    let micros = |frame: &Frame| frame.timestamp.as_nanos() / 1000 - MIDNIGHT * 1_000_000;
    frames.iter().map(micros).map(|micros| (micros / 1_000_000, micros % 1_000_000)).collect()
}

#[test]
fn times_of_day_count_from_midnight_and_others_from_the_date() {
    let absolute = "base dec timestamps absolute";
    let (noon, afternoon) = (12 * 3600 + 37 * 60 + 1, 15 * 3600 + 7 * 60 + 1);
    for date in [
        // As it should be, with one digit, and with the halves of the day mistaken.
        "date Fri May 18 12:37:01 pm 2012",
        "date Fri May 18 12:37:1 pm 2012",
        "date Fri May 18 12:37:01.000 am 2012",
        "date Fri May 18 0:37:1 pm 2012",
        "date Fri May 18 12:37:01 2012",
    ] {
        let head = format!("{date}\n{absolute}");
        let of_day = times_of_day(&head, &["45421.360200", "45421.380200"]);
        assert_eq!(of_day, [(noon, 360_200), (noon, 380_200)], "{date}");
    }
    let head = format!("date Fri May 18 3:7:1 pm 2012\n{absolute}");
    assert_eq!(times_of_day(&head, &["54421.5"]), [(afternoon, 500_000)]);
    assert_eq!(times_of_day(&head, &["0.5", "54421.5"])[1], (2 * afternoon, 500_000));
    assert_eq!(times_of_day(&head, &["45421.5"]), [(afternoon + 45_421, 500_000)]);
    let relative = "date Fri May 18 3:7:1 pm 2012\nbase hex timestamps relative";
    assert_eq!(times_of_day(relative, &["54421.5"]), [(2 * afternoon, 500_000)]);
    // A log that goes on after midnight.
    let head = format!("date Fri May 18 11:59:59 pm 2012\n{absolute}");
    let times = times_of_day(&head, &["86399.5", "0.5", "1.5"]);
    assert_eq!(times, [(86_399, 500_000), (86_400, 500_000), (86_401, 500_000)]);
}

#[test]
fn a_frame_with_a_name_has_its_identifier_at_the_end() {
    let head = "base hex timestamps absolute\n";
    let lines = "0.1 1  Rig_Transducers                Rx   d 4 05 32 05 3A  Length = 160000 BitCount = 84 ID = 513\n\
                 0.2 1  Engine                         Tx   d 1 A1  Length = 1 BitCount = 2 ID = 419361024x\n\
                 0.3 1  Valve  Rx   r 2  Length = 1 BitCount = 2 ID = 529\n\
                 0.4 1  4D  Rx   d 1 A1  Length = 1 BitCount = 2 ID = 77\n";
    let (frames, statistics) = read(format!("{head}{lines}").as_bytes());
    assert_eq!(statistics.bad_lines, 0, "{:?}", statistics.first_bad_lines);
    let ids: Vec<_> = frames.iter().map(|it| (it.id.value(), it.id.is_extended())).collect();
    assert_eq!(ids, [(0x201, false), (0x18FE_F100, true), (0x211, false), (0x4D, false)]);
    assert_eq!(frames[0].data(), [5, 0x32, 5, 0x3A]);
    for line in
        ["0.1 1 Rig Rx d 1 A1\n", "0.1 1 Rig Rx d 1 A1 ID = x\n", "0.1 1 Rig Rx d 1 A1 ID = 2048\n"]
    {
        let (frames, statistics) = read(format!("{head}{line}").as_bytes());
        assert_eq!((frames.len(), statistics.bad_lines), (0, 1), "{line}");
    }
}

#[test]
fn a_bad_line_says_what_was_expected_and_changes_nothing_else() {
    let good = "0.1 1 181 Rx d 2 E0 2D\n";
    let head = "date Sat Sep 30 15:06:13.191 2017\nbase hex  timestamps absolute\n";
    for (line, reason) in [
        ("0.x 1 181 Rx d 1 00", "found “0”, expected the time of an event in seconds"),
        ("0.2 1 1G1 Rx d 1 00", "found “1”, expected an identifier in the base of the log"),
        ("0.2 1 C4D Rx d 1 00", "the identifier C4D is out of range, expected at most 7FF"),
        ("0.2 1 FFFFFFFFx Rx d 1 00", "the identifier FFFFFFFF is out of range"),
        ("0.2 1 181 Rx q 1 00", "found “q”, expected d for a data frame, or r for a remote one"),
        ("0.2 1 181 Rx d 2 00", "the line announces 2 bytes, but 1 follow"),
        ("0.2 1 181 Rx d 1 1FF", "found “1”, expected a byte of data in the base of the log"),
        ("0.2 1 181 Rx d x 00", "found “x”, expected a data length code of 0 to 15"),
        ("0.2 CANFD 1 Rx 181 1 0 9 9 00", "9 bytes of data, but a CAN FD frame has"),
        ("0.2 CANFD x Rx 181 1 0 1 1 00", "found “x”, expected the number of a channel"),
        ("0.2 CANFD 1 Rx 181 a 2 0 1 1 00", "found “2”, expected 0 or 1"),
        ("x0.2 1 181 Rx d 1 00", "found “x”, expected an event that begins with its time"),
        ("date yesterday", "found “y”, expected a date such as Sat Sep 30 15:06:13.191 2017"),
        ("date Sat Sep 31 15:06:13.191 2017", "found “S”, expected a date"),
        ("date Sat Sep 30 15:06:13.191 pm 2017", "found “S”, expected a date"),
        ("base oct", "found “o”, expected hex or dec as the base"),
    ] {
        let (frames, statistics) = read(format!("{head}{good}{line}\n{good}").as_bytes());
        assert_eq!((frames.len(), statistics.bad_lines), (2, 1), "{line}");
        let bad = &statistics.first_bad_lines[0];
        assert!(bad.reason.to_string().starts_with(reason), "{line}: {bad}");
        assert_eq!((bad.place, bad.text.as_str()), (BadPlace::Line(4), line));
    }
}

#[test]
fn dates_of_other_languages_are_understood() {
    for date in [
        "Sam Sep 30 15:06:13.191 2017",
        "Sam Sept 30 15:06:13.191 2017",
        "Sat SEP 30 03:06:13.191 PM 2017",
    ] {
        let log = format!("date {date}\nbase hex\n0.0 1 181 Rx d 0\n");
        let (frames, statistics) = read(log.as_bytes());
        assert_eq!(statistics.bad_lines, 0, "{date}: {:?}", statistics.first_bad_lines);
        assert_eq!(frames[0].timestamp.as_nanos(), 1000 * START, "{date}");
    }
}

#[test]
fn logs_are_put_in_order_by_the_chosen_channel() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, events: &str| {
        let path = folder.path().join(name);
        let head = "date Sat Sep 30 15:06:13.191 2017\nbase hex  timestamps absolute\n";
        fs::write(&path, format!("{head}{events}")).expect("it can be written");
        path
    };
    let one = write("one", "1.0 1 181 Rx d 0\n5.0 2 181 Rx d 0\n");
    let other = write("other", "2.0 1 181 Rx d 0\n3.0 2 181 Rx d 0\n");
    let (first, second) = (vec![one.clone(), other.clone()], vec![other, one]);
    for (interfaces, right, wrong) in [
        (Interfaces::All, &first, &second),
        (Interfaces::Only("1".to_owned()), &first, &second),
        (Interfaces::Only("2".to_owned()), &second, &first),
        (Interfaces::Only("channel2".to_owned()), &second, &first),
    ] {
        let options = Options { interfaces: interfaces.clone(), ..Options::default() };
        let (frames, _) = drain(Recording::open(right, options.clone()).expect("in order"));
        assert_eq!(frames.len(), if interfaces == Interfaces::All { 4 } else { 2 });
        let refused = Recording::open(wrong, options).err();
        assert!(matches!(refused, Some(SourceError::Order { .. })), "{interfaces:?}");
        assert_eq!(&in_order(wrong, &interfaces), right);
    }
}

proptest! {
    /// Whatever becomes of some bytes, nothing breaks, every line is accounted for, and the sizes of the
    /// reads make no difference.
    #[test]
    fn damaged_logs_do_no_harm(
        which in 0..LOGS.len(),
        damage in prop::collection::vec((any::<Index>(), any::<u8>()), 0..12),
        sizes in prop::collection::vec(1..200_usize, 1..4),
    ) {
        let mut text = LOGS[which].repeat(3).into_bytes();
        for (place, byte) in &damage {
            // Digits do the most harm.
            let byte = if byte % 2 == 0 { b'0' + byte % 10 } else { *byte };
            let place = place.index(text.len());
            text[place] = byte;
        }
        let (frames, statistics) = read(&text);
        prop_assert!(statistics.frames + statistics.bad_lines <= statistics.lines);
        prop_assert!(frames.len() as u64 <= statistics.frames);
        let pieces = read_in_pieces(&text, &sizes, Options::default());
        prop_assert_eq!(pieces, (frames, statistics));
    }
}
