//! `tertius convert`: what is written is what was read, to this program and to others.

use std::fs;
use std::os::unix::fs::symlink;

use serde_json::{Value, json};
use tertius_testing::oracle;
use tertius_testing::support::{E_TYPE, Run, Scratch, between, recorded, replay, tertius};

/// Every kind of frame on two interfaces, one of them a little earlier than the first.
const EVERY: &str = "\
(1700000000.250000) can0 181#E02D
(1700000000.250001) can1 18FEF100#01
(1700000000.250002003) can0 100#R3
(1700000000.250003) can0 181##1000102030405060708090A0B
(1700000000.250004) can1 181##209
(1700000000.250005) can0 7FF#0001020304050607
(1700000000.250006) can0 20000080#0000000000000000
(1700000000.249999) can1 080#
(1700000001.250008) can1 18FEF100##3000102030405060708090A0B0C0D0E0F101112131415161718191A1B1C1D1E1F
(1700000001.250009) can1 100#R
";
const FORMATS: [&str; 4] = ["log", "asc", "blf", "pcapng"];

/// What is left of a candump log in a format without names of interfaces and kinds of errors.
fn numbered(log: &str) -> String {
    let numbered = log.replace(" can0 ", " channel1 ").replace(" can1 ", " channel2 ");
    numbered.replace("20000080#0000000000000000", "20000080#")
}

fn convert(files: &[&str], options: &[&str]) -> Run {
    tertius(&[&["convert"], files, options].concat(), b"")
}

/// `log` by way of a file called `name`, and what was said.
fn by_way_of(scratch: &Scratch, name: &str, log: &str) -> (String, String) {
    let (way, back) = (scratch.path(name), scratch.path("back.log"));
    let said = convert(&[log, &way], &["--force"]).ok().stderr;
    convert(&[&way, &back], &["--force"]).ok();
    (scratch.read("back.log"), said)
}

#[test]
fn a_log_by_way_of_each_format_is_the_same_to_the_byte() {
    let scratch = Scratch::new();
    let log = scratch.write("every.log", EVERY);
    for name in ["way.log", "way.log.gz", "way.log.zst", "way.pcapng", "way.pcapng.gz", "WAY.LOG"] {
        let (back, said) = by_way_of(&scratch, name, &log);
        assert_eq!(back, EVERY, "{name}");
        let told = "10 frames read, 10 written\nthe time stamps go back once, ";
        assert!(said.starts_with(told) && said.lines().count() == 2, "{name}: {said}");
    }
    for name in ["way.asc", "way.asc.zst", "way.blf"] {
        let (back, said) = by_way_of(&scratch, name, &log);
        assert_eq!(back, numbered(EVERY), "{name}");
        for told in [
            "10 frames read, 10 written\n",
            "1 error frame written without the kind of error",
            "can0 is channel 1, can1 is channel 2\n",
        ] {
            assert!(said.contains(told), "{name}: {said}");
        }
    }
}

#[test]
fn a_whole_machine_by_way_of_each_format_is_the_same_to_the_byte() {
    let scratch = Scratch::new();
    let text = between(&recorded("e-type-faults.log.zst"), 57.0, 64.5);
    assert!(text.lines().count() > 5000);
    let log = scratch.write("machine.log", &text);
    for format in FORMATS {
        let (back, _) = by_way_of(&scratch, &format!("way.{format}"), &log);
        let expected = if matches!(format, "asc" | "blf") { numbered(&text) } else { text.clone() };
        assert!(back == expected, "{format}");
    }
}

/// Frames of [`EVERY`] as the scripts print them: time in µs, identifier, extended, remote, error, CAN FD, bit rate
/// switch, error state, channel, data.
fn every() -> Vec<Value> {
    let fd: String = (0..12).map(|byte| format!("{byte:02x}")).collect();
    let long: String = (0..32).map(|byte| format!("{byte:02x}")).collect();
    let frame =
        |micros: i64, id: u32, extended: bool, flags: [bool; 5], channel: u8, data: &str| {
            let [remote, error, fd, switch, state] = flags;
            let micros = 1_700_000_000_250_000 + micros;
            json!([micros, id, extended, remote, error, fd, switch, state, channel, data])
        };
    let none = [false; 5];
    let remote = [true, false, false, false, false];
    vec![
        frame(0, 0x181, false, none, 1, "e02d"),
        frame(1, 0x18FE_F100, true, none, 2, "01"),
        frame(2, 0x100, false, remote, 1, ""),
        frame(3, 0x181, false, [false, false, true, true, false], 1, &fd),
        frame(4, 0x181, false, [false, false, true, false, true], 2, "09"),
        frame(5, 0x7FF, false, none, 1, "0001020304050607"),
        frame(6, 0x80, false, [false, true, false, false, false], 1, ""),
        frame(-1, 0x80, false, none, 2, ""),
        frame(1_000_008, 0x18FE_F100, true, [false, false, true, true, true], 2, &long),
        frame(1_000_009, 0x100, false, remote, 2, ""),
    ]
}

#[test]
fn python_can_reads_the_frames_that_were_written() {
    let scratch = Scratch::new();
    let log = scratch.write("every.log", EVERY);
    for format in ["asc", "blf"] {
        let file = scratch.path(&format!("every.{format}"));
        convert(&[&log, &file], &[]).ok();
        let read = oracle::run(&format!("{format}.py"), &["read", &file], "");
        let mut read: Vec<Vec<Value>> = serde_json::from_str(&read).expect("JSON");
        let (read, mut expected) = (&mut read[0], every());
        assert_eq!(read.len(), expected.len(), "{format}");
        for (one, other) in read.iter_mut().zip(&mut expected) {
            // python-can has its own identifier for an error frame of each format.
            if other[4] == true {
                for frame in [&mut *one, &mut *other] {
                    frame[1] = Value::Null;
                    frame[2] = Value::Null;
                }
            }
            assert_eq!(one, other, "{format}");
        }
    }
}

/// So many frames fill several containers of a BLF.
#[test]
fn python_can_reads_all_frames_of_a_whole_machine() {
    let scratch = Scratch::new();
    let text = between(&recorded("e-type-faults.log.zst"), 57.0, 64.5);
    let log = scratch.write("machine.log", &text);
    let none = [false; 6];
    let expected: Vec<Value> = text
        .lines()
        .map(|line| {
            let (stamp, rest) = line.split_at("(1700000000.000000)".len());
            let micros: i64 = stamp.replace(['(', ')', '.'], "").parse().expect("a time in µs");
            let (id, data) = rest.trim_start_matches(" can0 ").split_once('#').expect("a frame");
            let id = u32::from_str_radix(id, 16).expect("an identifier");
            let [extended, remote, error, fd, switch, state] = none;
            let data = data.to_lowercase();
            json!([micros, id, extended, remote, error, fd, switch, state, 1, data])
        })
        .collect();
    for format in ["asc", "blf"] {
        let file = scratch.path(&format!("machine.{format}"));
        convert(&[&log, &file], &[]).ok();
        let read = oracle::run(&format!("{format}.py"), &["read", &file], "");
        let read: Vec<Vec<Value>> = serde_json::from_str(&read).expect("JSON");
        assert!(read[0] == expected, "{format}: {} of {}", read[0].len(), expected.len());
    }
}

#[test]
fn another_reader_of_pcapng_reads_the_frames_that_were_written() {
    let scratch = Scratch::new();
    let log = scratch.write("every.log", EVERY);
    let file = scratch.path("every.pcapng");
    convert(&[&log, &file], &[]).ok();
    let read = oracle::run("pcapng.py", &[&file], "");
    let read: Vec<Vec<Value>> = serde_json::from_str(&read).expect("JSON");
    let expected = every();
    assert_eq!(read.len(), expected.len());
    for (n, (read, expected)) in read.iter().zip(&expected).enumerate() {
        let nanos = read[0].as_i64().expect("ns");
        assert_eq!(nanos.div_euclid(1000), expected[0].as_i64().expect("µs"));
        let interface = if expected[8] == 1 { "can0" } else { "can1" };
        assert_eq!(read[1], interface);
        let announced = [2, 1, 3, 12, 1, 8, 8, 0, 32, 0][n];
        assert_eq!(read[9], announced, "{read:?}");
        assert_eq!(json!(read[2..9]), json!(expected.as_array().expect("a list")[1..8]));
        let data =
            if expected[4] == true { json!("0000000000000000") } else { expected[9].clone() };
        assert_eq!(read[10], data);
    }
    assert_eq!(read[2][0], 1_700_000_000_250_002_003_i64, "to the nanosecond");
}

#[test]
fn a_blf_tells_its_size_its_frames_and_its_time_at_its_beginning() {
    let scratch = Scratch::new();
    let log = scratch.write("every.log", EVERY);
    let file = scratch.path("every.blf");
    convert(&[&log, &file], &[]).ok();
    let blf = fs::read(&file).expect("it was written");
    let number = |at: usize, bytes: usize| {
        blf[at..at + bytes].iter().rev().fold(0_u64, |sum, byte| sum << 8 | u64::from(*byte))
    };
    assert_eq!(number(16, 8), blf.len() as u64);
    // 144 bytes of head and 32 of the container, 48 for each of six classic frames, 116 of CAN FD, 64 of the error.
    assert_eq!(number(24, 8), 144 + 32 + 6 * 48 + 3 * 116 + 64);
    assert_eq!(number(32, 4), 10);
    let date = |at: usize| (0..8).map(|word| number(at + 2 * word, 2)).collect::<Vec<_>>();
    assert_eq!(date(40), [2023, 11, 2, 14, 22, 13, 20, 0], "a Tuesday");
    assert_eq!(date(56), [2023, 11, 2, 14, 22, 13, 21, 250]);
    // A pipe has no beginning to go back to, and the log is read all the same.
    let call = ["-c", "\"$0\" convert \"$1\" - --format blf | \"$0\" convert - - --format log"];
    let shell = std::process::Command::new("sh")
        .args(call)
        .args([env!("CARGO_BIN_EXE_tertius"), &log])
        .output()
        .expect("a shell");
    assert_eq!(String::from_utf8_lossy(&shell.stdout), numbered(EVERY));
}

#[test]
fn what_is_left_out_is_told() {
    let scratch = Scratch::new();
    let text = "(1700000000.250000) can0 181#E02D\nno frame\n(1699999999.999999) can1 182#\n\
                (-0000000001.000000) can1 183#\n";
    let log = scratch.write("some.log", text);
    let said = convert(&[&log, &scratch.path("some.asc")], &[]).ok().stderr;
    assert!(said.starts_with("3 frames read, 1 written\n1 line was not a frame and is left out\n"));
    assert!(said.contains("some.log:2: found “n”"), "{said}");
    assert!(said.contains("2 frames left out: earlier than the recording's start"), "{said}");
    let said = convert(&[&log, &scratch.path("some.pcapng")], &[]).ok().stderr;
    assert!(said.contains("3 frames read, 2 written"), "{said}");
    assert!(said.contains("1 frame left out: earlier than 1970"), "{said}");
    let said = convert(&[&log, "-"], &["--format", "log", "--interface", "can1"]).ok();
    assert!(said.stdout.lines().all(|line| line.contains(" can1 ")) && !said.stdout.is_empty());
    assert!(said.stderr.contains("1 of 3 frames are of other interfaces"), "{}", said.stderr);
    // A file that ends early is converted up to there, and that is a failure.
    let packed = scratch.path("whole.log.gz");
    let log = scratch.write("whole.log", EVERY.repeat(200));
    convert(&[&log, &packed], &[]).ok();
    let bytes = fs::read(&packed).expect("it was written");
    let cut = scratch.write("cut.log.gz", &bytes[..bytes.len() / 2]);
    let out = scratch.path("cut.pcapng");
    convert(&[&cut, &out], &[]).failed(1, &["the gzip data are truncated"]);
    assert!(fs::metadata(&out).expect("what could be read is there").len() > 1000);
}

#[test]
fn a_wrong_call_says_what_was_expected_and_writes_nothing() {
    let scratch = Scratch::new();
    let log = scratch.write("every.log", EVERY);
    let there = scratch.write("there.asc", "mine");
    for (out, options, words) in [
        ("out.txt", &[][..], &["expected one that ends in .log, .asc, .pcapng, .blf"][..]),
        ("out.gz", &[], &["or --format"]),
        ("-", &[], &["or --format"]),
        ("out.blf.gz", &[], &["blf is compressed by itself", "without .gz"]),
        ("there.asc", &[], &["it exists", "--force"]),
        ("every.log", &["--force"], &["would be written over the input"]),
        ("out.log", &["--format", "trc"], &["log", "asc", "blf", "pcapng"]),
    ] {
        let path = if out == "-" { out.to_owned() } else { scratch.path(out) };
        convert(&[&log, &path], options).failed(2, words);
        assert!(["every.log", "there.asc", "-"].contains(&out) || fs::metadata(&path).is_err());
    }
    assert_eq!(
        (scratch.read("every.log").as_str(), fs::read(&there).expect("it is there")),
        (EVERY, b"mine".to_vec())
    );
    // Under other names, and as the second of two, an input is one all the same.
    let (linked, hard) = (scratch.path("linked.asc"), scratch.path("hard.pcapng"));
    symlink(&log, &linked).expect("a link");
    fs::hard_link(&log, &hard).expect("another name");
    let later = scratch.write("later.log", "(1800000000.000000) can0 181#\n");
    for out in [&linked, &hard, &later] {
        convert(&[&log, &later, out], &["--force"]).failed(2, &["over the input"]);
    }
    assert_eq!(scratch.read("every.log"), EVERY);
    convert(&[&later, &log, &scratch.path("out.asc")], &[])
        .failed(2, &["not in the order of time"]);
    let out = scratch.path("out.asc");
    let words = ["no frame is from can7; the recording has can0 (5 frames), can1 (5 frames)"];
    convert(&[&log, &out], &["--interface", "can7"]).failed(1, &words);
    let empty = scratch.write("empty.log", "");
    convert(&[&empty, &out], &[]).failed(1, &["nothing was written", "it is empty"]);
    assert!(fs::metadata(&out).is_err());
    // What was there stays where nothing takes its place.
    convert(&[&empty, &there], &["--force"]).failed(1, &["nothing was written"]);
    assert_eq!(scratch.read("there.asc"), "mine");
}

#[test]
fn an_interface_is_chosen_by_name_or_number_in_every_format() {
    let scratch = Scratch::new();
    let machine = between(&recorded("e-type-faults.log.zst"), 58.0, 62.0);
    // The other machine is silent but for one reading, on the interface that comes first.
    let other = machine.lines().find(|line| line.contains(" 181#")).expect("a reading");
    let both = format!("{}\n{}", other.replace(" can0 ", " can9 "), machine);
    let (alone, both) = (scratch.write("alone.log", &machine), scratch.write("both.log", both));
    let of = |recording: &str, options: &[&str]| {
        let run = replay(&[recording], E_TYPE, options).ok();
        let summary = run.summary();
        (run.warnings(), summary["cycles"].clone())
    };
    let expected = of(&alone, &[]);
    assert!(!expected.0.is_empty());
    assert_eq!(of(&both, &["--channel", "can0"]), expected);
    for (format, names) in
        [("asc", ["2", "channel2"]), ("blf", ["2", "channel2"]), ("pcapng", ["can0", "can0"])]
    {
        let file = scratch.path(&format!("both.{format}"));
        convert(&[&both, &file], &[]).ok();
        for name in names {
            assert_eq!(of(&file, &["--channel", name]), expected, "{format} {name}");
            let run = convert(&[&file, "-"], &["--format", "log", "--channel", name]).ok();
            assert_eq!(run.stdout.lines().count(), machine.lines().count(), "{format} {name}");
        }
        let call = ["replay", &file, "--config", E_TYPE, "--channel", "7"];
        tertius(&call, b"").failed(1, &["no frame is from 7; the recording has"]);
    }
}
