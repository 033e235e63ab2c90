//! Every form of line that candump writes, and every way in which a line can be bad.

use tertius::bus::{BadPlace, Found, Interfaces, Options, Reason, Source, Statistics, TimeStamps};
use tertius::frame::{Frame, Id, Kind};
use tertius::time::Timestamp;
use tertius_testing::candump::{frames_of, read, read_in_pieces, read_with};

const SECOND: i64 = 1_000_000_000;
const START: i64 = 1_700_000_000 * SECOND;

fn frame(nanos: i64, id: Id, kind: Kind, data: &[u8]) -> Frame {
    Frame::new(Timestamp::from_nanos(nanos), id, kind, data)
}

fn standard(id: u32) -> Id {
    Id::standard(id).unwrap()
}

fn extended(id: u32) -> Id {
    Id::extended(id).unwrap()
}

/// The only frame of the line; a line before it makes the reader know second and interface.
fn only(line: &str) -> Frame {
    let (frames, statistics) = read(format!("{line}\n").as_bytes());
    assert_eq!(statistics.bad_lines, 0, "{line}: {:?}", statistics.first_bad_lines);
    assert_eq!(frames.len(), 1, "{line}");
    let padding = "(1700000000.000000) can0 7FF#0000000000000000\n";
    let (padded, _) = read(format!("{padding}{line}\n{padding}{padding}").as_bytes());
    assert_eq!(padded.len(), 4, "{line}");
    assert_eq!(padded[1], frames[0], "in a row: {line}");
    frames.into_iter().next().unwrap()
}

#[test]
fn the_log_form_is_read() {
    let at = START + 516_000;
    let data = |id, data: &[u8]| frame(at, id, Kind::Data, data);
    let fd = |id, flags, data: &[u8]| frame(at, id, Kind::Fd { flags }, data);
    let remote = |length| frame(at, standard(0x123), Kind::Remote { length }, &[]);
    let bytes = [0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88];
    let table = [
        ("181#E02D", data(standard(0x181), &[0xE0, 0x2D])),
        ("080#", data(standard(0x80), &[])),
        ("7ff#00", data(standard(0x7FF), &[0])),
        ("000#aBcD", data(standard(0), &[0xAB, 0xCD])),
        ("123#1122334455667788", data(standard(0x123), &bytes)),
        ("1FFFFFFF#1122334455667788", data(extended(0x1FFF_FFFF), &bytes)),
        ("00000123#01", data(extended(0x123), &[1])),
        ("123#11.22.33.44.55.66.77.88", data(standard(0x123), &bytes)),
        ("123#11.2233.44556677.88", data(standard(0x123), &bytes)),
        ("123#.11.22.", data(standard(0x123), &bytes[..2])),
        ("123#1122334455667788_E", data(standard(0x123), &bytes)),
        ("123#1122334455667788_9", data(standard(0x123), &bytes)),
        ("123##0", fd(standard(0x123), 0, &[])),
        ("123##3112233", fd(standard(0x123), 3, &bytes[..3])),
        ("12345678##5.11.22", fd(extended(0x1234_5678), 5, &bytes[..2])),
        (
            "123##F112233445566778811223344",
            fd(standard(0x123), 15, &[&bytes[..], &bytes[..4]].concat()),
        ),
        ("123#R", remote(0)),
        ("123#r0", remote(0)),
        ("123#R8", remote(8)),
        ("123#R8_A", remote(8)),
        (
            "20000004#0001000000000000",
            frame(at, extended(4), Kind::Error, &[0, 1, 0, 0, 0, 0, 0, 0]),
        ),
        ("3FFFFFFF#", frame(at, extended(0x1FFF_FFFF), Kind::Error, &[])),
    ];
    for (text, expected) in &table {
        let endings = ["", " T", " R", "\r", " R\r", " \t", "\tT"];
        for ending in endings {
            assert_eq!(
                only(&format!("(1700000000.000516) can0 {text}{ending}")),
                *expected,
                "{text:?} {ending:?}"
            );
        }
        assert_eq!(only(&format!("  (1700000000.000516)\t  can0  {text}")), *expected, "{text}");
        assert_eq!(only(&format!("(1700000000.000516) a-longer-name {text}")), *expected, "{text}");
    }
    let long = "AB".repeat(64);
    let read = only(&format!("(1700000000.000516) can0 123##1{long}"));
    assert_eq!(read, fd(standard(0x123), 1, &[0xAB; 64]));
}

#[test]
fn time_stamps_of_all_forms_are_read() {
    let table = [
        ("1700000000.000516", START + 516_000),
        ("1700000000.000516789", START + 516_789),
        ("1700000000.999999", START + 999_999_000),
        ("1700000000.5", START + SECOND / 2),
        ("1700000000.", START),
        ("1700000000", START),
        ("0000000001.000000", SECOND),
        ("-0000000001.500000", -3 * SECOND / 2),
        ("-0.000000001", -1),
        ("9223372036.854775807", i64::MAX),
        ("-9223372036.854775808", i64::MIN),
        ("000.000001", 1_000),
        ("2023-11-14 22:13:20.000516", START + 516_000),
        ("2023-11-14 22:13:20", START),
        ("1970-01-01 00:00:00.000000", 0),
        ("1969-12-31 23:59:59.000000", -SECOND),
        ("2000-02-29 00:00:00.000000", 951_782_400 * SECOND),
        ("2016-12-31 23:59:60.000000", 1_483_228_800 * SECOND),
        ("2262-04-11 23:47:16.854775807", i64::MAX),
    ];
    for (text, nanos) in table {
        for line in [format!("({text}) can0 123#11"), format!(" ({text})  can0  123   [1]  11")] {
            let (frames, statistics) = read(line.as_bytes());
            assert_eq!(statistics.bad_lines, 0, "{:?}", statistics.first_bad_lines);
            assert_eq!(frames[0].timestamp.as_nanos(), nanos, "{line}");
        }
    }
}

#[test]
fn the_console_form_is_read() {
    let bytes = [0x11, 0x22, 0x33, 0x27, 0x41, 0x20, 0x77, 0x88];
    let data = |id, data: &[u8]| frame(START, id, Kind::Data, data);
    let fd = |flags, data: &[u8]| frame(START, standard(0x123), Kind::Fd { flags }, data);
    let remote = |length| frame(START, standard(0x123), Kind::Remote { length }, &[]);
    let error = frame(START, extended(4), Kind::Error, &[0, 1, 0, 0, 0, 0, 0, 0]);
    let table = [
        ("123   [8]  11 22 33 27 41 20 77 88", data(standard(0x123), &bytes)),
        ("123   [8]  11 22 33 27 41 20 77 88   '.\"3'A w.'", data(standard(0x123), &bytes)),
        ("123   [2]  11 22                     '..'", data(standard(0x123), &bytes[..2])),
        ("123   [0] ", data(standard(0x123), &[])),
        ("123   [0]                            ''", data(standard(0x123), &[])),
        ("     123   [1]  11", data(standard(0x123), &bytes[..1])),
        ("1FFFFFFF   [2]  11 22", data(extended(0x1FFF_FFFF), &bytes[..2])),
        ("123   {B}  11 22 33 27 41 20 77 88", data(standard(0x123), &bytes)),
        ("123   {2}  11 22", data(standard(0x123), &bytes[..2])),
        ("123  [08]  11 22 33 27 41 20 77 88", fd(0, &bytes)),
        ("123  [00] ", fd(0, &[])),
        ("RX - -  123  [02]  11 22", fd(0, &bytes[..2])),
        ("TX B -  123  [02]  11 22", fd(1, &bytes[..2])),
        ("RX - E  123  [02]  11 22", fd(2, &bytes[..2])),
        ("RX B E  123  [02]  11 22", fd(3, &bytes[..2])),
        ("TX - -  123   [2]  11 22", data(standard(0x123), &bytes[..2])),
        ("123   [0]  remote request", remote(0)),
        ("123   [8]  remote request", remote(8)),
        ("20000004   [8]  00 01 00 00 00 00 00 00   ERRORFRAME", error),
    ];
    for (text, expected) in &table {
        for (before, after) in [("  ", ""), (" ", "  \r"), ("\t", "\t")] {
            let line = format!("{before}(1700000000.000000)  can0  {text}{after}");
            assert_eq!(only(&line), *expected, "{line}");
        }
    }
    let long = " AB".repeat(64);
    assert_eq!(only(&format!(" (1700000000.000000)  can0  123  [64] {long}")), fd(0, &[0xAB; 64]));
}

#[test]
fn a_line_that_says_nothing_is_not_bad() {
    let text = "\n\r\n   \t\n\tcontroller-problem{rx-overflow}\n\u{FEFF}(1.0) can0 123#11\n";
    let (frames, statistics) = read(text.as_bytes());
    assert_eq!((frames.len(), statistics.bad_lines, statistics.lines), (1, 0, 5));
}

#[test]
fn a_bad_line_is_counted_with_its_reason() {
    let byte = |byte: u8| Found(Some(byte));
    let end = Found(None);
    let log = "(1700000000.000516) can0 ";
    let console = " (1700000000.000516)  can0  ";
    let table = [
        ("can0 123#11", "", Reason::NoStamp(byte(b'c'))),
        ("  can0  123   [1]  11", "", Reason::NoStamp(byte(b'c'))),
        ("DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)", "", Reason::DropCount),
        ("(1700000000.000516 can0 123#11", "", Reason::OpenStamp),
        ("() can0 123#11", "", Reason::Stamp),
        ("(1.0000000001) can0 123#11", "", Reason::Stamp),
        ("(1.00a) can0 123#11", "", Reason::Stamp),
        ("(.5) can0 123#11", "", Reason::Stamp),
        ("(170000000O.000516) can0 123#11", "", Reason::Stamp),
        ("(17000000-1.000516) can0 123#11", "", Reason::Stamp),
        ("(2023-13-14 22:13:20.0) can0 123#11", "", Reason::Stamp),
        ("(2023-02-29 22:13:20.0) can0 123#11", "", Reason::Stamp),
        ("(2100-02-29 22:13:20.0) can0 123#11", "", Reason::Stamp),
        ("(2023-02-28 24:13:20.0) can0 123#11", "", Reason::Stamp),
        ("(2023-02-28T22:13:20.0) can0 123#11", "", Reason::Stamp),
        ("(2023-02-28 22:13) can0 123#11", "", Reason::Stamp),
        ("(9223372036.854775808) can0 123#11", "", Reason::StampRange),
        ("(9999999999.000000) can0 123#11", "", Reason::StampRange),
        ("(99999999999999999999.0) can0 123#11", "", Reason::StampRange),
        ("(9999-01-01 00:00:00.0) can0 123#11", "", Reason::StampRange),
        ("(1700000000.000516)", "", Reason::Interface(end)),
        ("(1700000000.000516) 123#11", "", Reason::Interface(byte(b'#'))),
        ("(1700000000.000516) c\u{1}n0 123#11", "", Reason::Interface(byte(1))),
        ("(1700000000.000516) can0", "", Reason::NoFrame),
        (log, "12#11", Reason::IdentifierLength(2)),
        (log, "#11", Reason::IdentifierLength(0)),
        (log, "1234567#11", Reason::IdentifierLength(7)),
        (log, "12G#11", Reason::IdentifierDigit(byte(b'G'))),
        (log, "1234567x#11", Reason::IdentifierDigit(byte(b'x'))),
        (log, "800#11", Reason::StandardRange(0x800)),
        (log, "FFF#11", Reason::StandardRange(0xFFF)),
        (log, "40000000#11", Reason::ExtendedRange(0x4000_0000)),
        (log, "80000123#11", Reason::ExtendedRange(0x8000_0123)),
        (log, "45123#81:00:12345678#11223344.556677", Reason::Xl),
        (log, "123#1", Reason::HalfByte),
        (log, "123#112", Reason::HalfByte),
        (log, "123#1.12", Reason::HalfByte),
        (log, "123#11x2", Reason::DataDigit(byte(b'x'))),
        (log, "123#1x", Reason::DataDigit(byte(b'x'))),
        (log, "123#11..22", Reason::DataDigit(byte(b'.'))),
        (log, "123#11\u{0}", Reason::DataDigit(byte(0))),
        (log, "123#112233445566778899", Reason::ClassicLength),
        (log, "123#11223344556677889", Reason::ClassicLength),
        (log, "123#11_9", Reason::RawLength(byte(b'_'))),
        (log, "123#1122334455667788_8", Reason::RawLength(byte(b'8'))),
        (log, "123#1122334455667788_", Reason::RawLength(end)),
        (log, "123#1122334455667788_99", Reason::Trailing(byte(b'9'))),
        (log, "123##", Reason::FdFlags(end)),
        (log, "123##G", Reason::FdFlags(byte(b'G'))),
        (log, "123##0112233445566778899", Reason::FdLength(9)),
        (log, "123##01", Reason::HalfByte),
        (log, "123#R9", Reason::RemoteLength(byte(b'9'))),
        (log, "123#Rx", Reason::RemoteLength(byte(b'x'))),
        (log, "123#R11", Reason::Trailing(byte(b'1'))),
        (log, "123#R8_7", Reason::RawLength(byte(b'7'))),
        (log, "20000004#R", Reason::ErrorKind),
        (log, "20000004##011", Reason::ErrorKind),
        (log, "123#11 X", Reason::Trailing(byte(b'X'))),
        (log, "123#11 22", Reason::Trailing(byte(b'2'))),
        (log, "123#11 T R", Reason::Trailing(byte(b'R'))),
        (console, "123", Reason::Length(end)),
        (console, "123  11 22", Reason::Length(byte(b'1'))),
        (console, "1234   [1]  11", Reason::IdentifierLength(4)),
        (console, "8FF   [1]  11", Reason::StandardRange(0x8FF)),
        (console, "123   [9]  11", Reason::ClassicLength),
        (console, "123   [x]  11", Reason::Length(byte(b'['))),
        (console, "123   {x}  11", Reason::Length(byte(b'x'))),
        (console, "123  [09]  11", Reason::FdLength(9)),
        (console, "123 [0003] (45|81:00:12345678) 11 22 33", Reason::Xl),
        (console, "123   [2]  11", Reason::LengthMismatch { announced: 2, found: 1 }),
        (console, "123   [2]  11 '.'", Reason::LengthMismatch { announced: 2, found: 1 }),
        (console, "123   [1]  11 22 33", Reason::LengthMismatch { announced: 1, found: 3 }),
        (console, "123   [2]  11 2", Reason::HalfByte),
        (console, "123   [2]  11 2g", Reason::DataDigit(byte(b'g'))),
        (console, "123   [1]  10101010", Reason::DataWord(8)),
        (console, "123   [2]  22`11", Reason::DataWord(5)),
        (console, "123   [1]  11  ERRORFRAME", Reason::Trailing(byte(b'E'))),
        (console, "123   [1]  11  '..'", Reason::Trailing(byte(b'\''))),
        (console, "123   [0]  remote", Reason::Trailing(end)),
        (console, "123   [0]  remote request 1", Reason::Trailing(byte(b'1'))),
        (console, "123  [00]  remote request", Reason::ErrorKind),
        (console, "RX - X  123   [1]  11", Reason::Trailing(byte(b'X'))),
    ];
    for (head, tail, reason) in table {
        // Alone, and between good lines that the reader knows how to expect.
        let line = format!("{head}{tail}");
        let good = "(1700000000.000515) can0 7FF#0000000000000000";
        let text = format!("{good}\n{line}\n{good}\n{good}\n");
        for (text, frames, number) in [(line.as_str(), 0, 1), (text.as_str(), 3, 2)] {
            let (read, statistics) = read(text.as_bytes());
            assert_eq!(statistics.bad_lines, 1, "{text}");
            assert_eq!(statistics.first_bad_lines[0].reason, reason, "{text}");
            assert_eq!(statistics.first_bad_lines[0].place, BadPlace::Line(number), "{text}");
            assert_eq!(read.len(), frames, "{text}");
        }
    }
    let name = "n".repeat(65);
    let (_, statistics) = read(format!("(1.0) {name} 123#11").as_bytes());
    assert_eq!(statistics.first_bad_lines[0].reason, Reason::InterfaceTooLong(65));
    let (_, statistics) = read(format!("(1.0) can0 123##0{}", "11".repeat(65)).as_bytes());
    assert_eq!(statistics.first_bad_lines[0].reason, Reason::FdTooLong);
}

#[test]
fn a_report_names_place_reason_and_text_without_touching_the_terminal() {
    let (_, statistics) = read(b"(1.0) can0 123#11\n(1.0) can0 123#1\x1B[2J\xFF\x00\xE2\x80\xAE\n");
    let report = statistics.first_bad_lines[0].to_string();
    assert_eq!(
        report,
        "test:2: found the byte 0x1B in the data, expected a hexadecimal digit: \
         (1.0) can0 123#1\\u001b[2J\u{FFFD}\\u0000\\u202e"
    );
    let (_, statistics) = read("x".repeat(500).as_bytes());
    assert_eq!(statistics.first_bad_lines[0].text, format!("{}…", "x".repeat(80)));
}

#[test]
fn only_the_first_bad_lines_are_kept() {
    let (_, statistics) = read("nonsense\n".repeat(1000).as_bytes());
    assert_eq!((statistics.bad_lines, statistics.lines), (1000, 1000));
    let lines: Vec<BadPlace> = statistics.first_bad_lines.iter().map(|bad| bad.place).collect();
    assert_eq!(lines, [1, 2, 3, 4, 5].map(BadPlace::Line));
}

#[test]
fn a_line_has_at_most_1024_bytes() {
    let blanks =
        |count: usize| format!("(1700000000.000516) can0 123#11{}\n", " ".repeat(count - 31));
    let (frames, statistics) = read(blanks(1024).as_bytes());
    assert_eq!((frames.len(), statistics.bad_lines), (1, 0));
    let good = "(1700000000.000516) can0 7FF#22\n";
    for length in [1025, 5000, 1_000_000] {
        let (frames, statistics) = read(format!("{good}{}{good}", blanks(length)).as_bytes());
        assert_eq!((frames.len(), statistics.lines, statistics.bad_lines), (2, 3, 1));
        assert_eq!(statistics.first_bad_lines[0].reason, Reason::LineTooLong);
        let (frames, statistics) =
            read(format!("{good}{}", blanks(length).trim_end_matches('\n')).as_bytes());
        assert_eq!((frames.len(), statistics.lines, statistics.bad_lines), (1, 2, 1));
    }
}

#[test]
fn the_end_of_a_long_line_is_no_line_wherever_the_pieces_part() {
    let line = |id: &str| format!("(1700000000.000516) can0 {id}#1122334455667788\n");
    let good = line("7FF").repeat(3);
    let text = format!("{good}{}{}{good}", "x".repeat(2000), line("001"));
    // Somewhere among them a piece ends where the frame begins within the long line.
    for size in good.len() + 1980..good.len() + 2010 {
        let (frames, statistics) = read_in_pieces(text.as_bytes(), &[size], Options::default());
        assert!(frames.iter().all(|frame| frame.id == standard(0x7FF)), "pieces of {size}");
        assert_eq!((frames.len(), statistics.lines, statistics.bad_lines), (6, 7, 1));
    }
}

fn nanos(frames: &[Frame]) -> Vec<i64> {
    frames.iter().map(|frame| frame.timestamp.as_nanos() / 1_000_000).collect()
}

fn console(millis: &[i64]) -> String {
    let line = |ms: &i64| format!(" ({:03}.{:03}000)  can0  123   [1]  11\n", ms / 1000, ms % 1000);
    millis.iter().map(line).collect()
}

#[test]
fn deltas_are_told_from_times_since_the_start() {
    let deltas = console(&[0, 20, 20, 10, 30]);
    let zero = console(&[0, 20, 20, 40, 3000]);
    assert_eq!(nanos(&read(deltas.as_bytes()).0), [0, 20, 40, 50, 80]);
    assert_eq!(nanos(&read(zero.as_bytes()).0), [0, 20, 20, 40, 3000]);
    let with = |text: &str, time_stamps| {
        let options = Options { time_stamps, ..Options::default() };
        nanos(&read_with(text.as_bytes(), options).0)
    };
    assert_eq!(with(&deltas, TimeStamps::Zero), [0, 20, 20, 10, 30]);
    assert_eq!(with(&deltas, TimeStamps::Absolute), [0, 20, 20, 10, 30]);
    assert_eq!(with(&zero, TimeStamps::Delta), [0, 20, 40, 80, 3080]);
}

#[test]
fn only_the_first_64_lines_are_looked_at() {
    let mut times: Vec<i64> = (0..64).collect();
    times.push(0);
    assert_eq!(nanos(&read(console(&times).as_bytes()).0)[64], 0);
    times.remove(0);
    let read = nanos(&read(console(&times).as_bytes()).0);
    assert_eq!(read[63], (1..64).sum::<i64>());
}

#[test]
fn long_time_stamps_and_the_log_form_have_no_say() {
    let text = "(1700000000.000000) can0 123#11\n\
                (0.5) can0 123#11\n (0.1) can0 123#11\n\
                (0.7) can0 12x   [1]  11\n";
    let zero = format!("{text}{}", console(&[100, 200]));
    assert_eq!(nanos(&read(zero.as_bytes()).0), [1_700_000_000_000, 500, 100, 100, 200]);
    let delta = format!("{text}{}(0.9) can0 123#11\n", console(&[100, 20]));
    assert_eq!(nanos(&read(delta.as_bytes()).0), [1_700_000_000_000, 500, 100, 100, 120, 900]);
}

#[test]
fn a_bad_frame_still_moves_the_deltas() {
    let text =
        format!("{} (000.500000)  can0  123   [2]  11\n{}", console(&[10, 5]), console(&[1]));
    let (frames, statistics) = read(text.as_bytes());
    assert_eq!(statistics.bad_lines, 1);
    assert_eq!(nanos(&frames), [10, 15, 516]);
}

#[test]
fn deltas_beyond_the_range_are_bad_lines() {
    let text = " (0.5)  can0  123   [1]  11\n (0.1)  can0  123   [1]  11\n";
    let far = " (99999999.0)  can0  123   [1]  11\n".repeat(100);
    let (frames, statistics) = read(format!("{text}{far}").as_bytes());
    assert_eq!(frames.len(), 94);
    assert!(statistics.first_bad_lines.iter().all(|bad| bad.reason == Reason::StampRange));
}

#[test]
fn other_interfaces_are_counted_and_not_given_out() {
    let text = "(1700000000.000001) can0 123#11\n(1700000000.000002) can1 123#22\n\
                (1700000000.000003) vcan0 123#R\n(1700000000.000004) can1 20000001#\n"
        .repeat(50);
    let options = Options { interfaces: Interfaces::Only("can1".to_owned()), ..Options::default() };
    let (frames, statistics) = read_with(text.as_bytes(), options);
    assert_eq!(frames.len(), 100);
    assert!(frames.iter().all(|frame| frame.data() == [0x22] || frame.kind == Kind::Error));
    assert_eq!((statistics.frames, statistics.other_interface_frames), (200, 100));
    assert_eq!((statistics.remote_frames, statistics.error_frames), (50, 50));
    assert_eq!(interfaces(&statistics), [("can0", 50), ("can1", 100), ("vcan0", 50)]);
}

fn interfaces(statistics: &Statistics) -> Vec<(&str, u64)> {
    statistics.interfaces.iter().map(|seen| (seen.name.as_str(), seen.frames)).collect()
}

#[test]
fn interfaces_are_listed_up_to_a_bound() {
    let text: String = (0..40).map(|n| format!("(1700000000.000001) can{n} 123#11\n")).collect();
    let (frames, statistics) = read(text.repeat(3).as_bytes());
    assert_eq!(frames.len(), 120);
    assert_eq!((statistics.interfaces.len(), statistics.unlisted_interface_frames), (16, 72));
    assert!(statistics.interfaces.iter().all(|seen| seen.frames == 3));
}

#[test]
fn after_the_end_there_is_nothing() {
    let mut recording = frames_of(b"(1.0) can0 123#11");
    assert!(recording.next_frame().unwrap().is_some());
    assert!(recording.next_frame().unwrap().is_none());
    assert!(recording.next_frame().unwrap().is_none());
}

/// asc2log of can-utils lets microseconds add up to a million.
#[test]
fn a_million_microseconds_are_the_next_second() {
    let log = "(1614188635.980000) can0 201#01\n(1614188635.1000000) can0 201#02\n\
               (1614188636.020000) can0 201#03\n(1614188636.1000000) can0 201#04\n";
    let (frames, statistics) = read(log.as_bytes());
    assert_eq!(statistics.bad_lines, 0, "{:?}", statistics.first_bad_lines);
    let times: Vec<i64> =
        frames.iter().map(|it| it.timestamp.as_nanos() / 10_000_000 - 161_418_863_500).collect();
    assert_eq!(times, [98, 100, 102, 200]);
    // Where other time stamps have seven decimals, too, they are tenths of a microsecond.
    let log = "(1614188635.0990000) can0 201#01\n(1614188635.1000000) can0 201#02\n";
    let (frames, _) = read(log.as_bytes());
    assert_eq!(frames[1].timestamp.as_nanos(), 1_614_188_635_100_000_000);
}
