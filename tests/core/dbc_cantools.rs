//! Decoding against cantools, an independent implementation, on random frames.

use std::fmt::Write as _;
use std::io::{Seek, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::dbc_support::{Dice, random_dbc};
use tertius::dbc::{Database, Message};
use tertius::decode::{Decoded, Raw};
use tertius::frame::{Frame, Kind};
use tertius::time::Timestamp;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// What the script answers to `commands`.
fn cantools(commands: &str) -> Vec<String> {
    let found = Command::new(Path::new(ROOT).join("scripts/oracle-python")).output().unwrap();
    assert!(found.status.success(), "{}", String::from_utf8_lossy(&found.stderr));
    let python = String::from_utf8(found.stdout).unwrap();
    let mut input = tempfile::tempfile().unwrap();
    input.write_all(commands.as_bytes()).unwrap();
    input.seek(SeekFrom::Start(0)).unwrap();
    let output = Command::new(python.trim())
        .arg(Path::new(ROOT).join("tests/oracle/dbc_decode.py"))
        .stdin(Stdio::from(input))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect()
}

fn bits(number: f64) -> String {
    if number.is_nan() { "nan".to_owned() } else { format!("{:016x}", number.to_bits()) }
}

/// What we make of a frame, in the script's words.
fn ours(message: &Message, frame: &Frame) -> String {
    let mut signals: Vec<_> = message.signals.iter().collect();
    signals.sort_by(|a, b| a.name.cmp(&b.name));
    let states: Vec<String> = signals
        .iter()
        .map(|signal| match signal.plan.decode(frame) {
            Decoded::Absent => format!("{}=A", signal.name),
            Decoded::Short => format!("{}=S", signal.name),
            Decoded::Value(value) => {
                let raw = match value.raw {
                    Raw::Unsigned(raw) => raw.to_string(),
                    Raw::Signed(raw) => raw.to_string(),
                    Raw::Float(raw) => bits(raw),
                };
                format!("{}=V:{raw}:{}", signal.name, bits(value.physical))
            }
        })
        .collect();
    states.join(" ")
}

/// A frame of random bytes, mostly of the message's length, with rubbish behind its end.
fn random_frame(dice: &mut Dice, message: &Message) -> Frame {
    let length = match dice.below(8) {
        0 => dice.below(message.length as u64 + 1) as usize,
        1 => 64,
        _ => message.length,
    };
    let kind = if length > 8 { Kind::Fd { flags: 0 } } else { Kind::Data };
    let mut frame = Frame::new(Timestamp::default(), message.id, kind, &[]);
    // Bytes of all ones or zeros now and then: extremes, infinities.
    let pattern = dice.below(8);
    for byte in frame.buffer_mut() {
        *byte = match pattern {
            0 if dice.below(4) > 0 => 0,
            1 if dice.below(4) > 0 => 0xFF,
            _ => dice.roll() as u8,
        };
    }
    frame.set_length(length);
    frame
}

#[derive(Default)]
struct Counts {
    frames: usize,
    values: usize,
    absent: usize,
    short: usize,
}

/// Decodes `frames` random frames of every message of every file with both.
fn compare(dice: &mut Dice, files: &[PathBuf], frames: usize) -> Counts {
    let mut commands = String::new();
    let mut expected = Vec::new();
    for file in files {
        let database = Database::parse(&std::fs::read_to_string(file).unwrap()).unwrap();
        assert_eq!(database.findings(), [], "{}", file.display());
        writeln!(commands, "D {}", file.display()).unwrap();
        for message in database.messages() {
            for _ in 0..frames {
                let frame = random_frame(dice, message);
                let hex: String = frame.data().iter().map(|byte| format!("{byte:02x}")).collect();
                writeln!(commands, "F {} {hex}", message.name).unwrap();
                let what = format!("{} {} {hex}", file.display(), message.name);
                expected.push((what, ours(message, &frame)));
            }
        }
    }
    let answers = cantools(&commands);
    assert_eq!(answers.len(), expected.len());
    let mut counts = Counts { frames: answers.len(), ..Counts::default() };
    for ((what, ours), theirs) in expected.iter().zip(&answers) {
        assert_eq!(ours, theirs, "{what}");
        counts.values += theirs.matches("=V").count();
        counts.absent += theirs.matches("=A").count();
        counts.short += theirs.matches("=S").count();
    }
    counts
}

fn own_files() -> Vec<PathBuf> {
    let names =
        ["intel", "motorola", "floats", "multiplexed", "nested", "extended", "fd", "long_names"];
    let files = names.iter().map(|name| format!("tests/dbc/{name}.dbc"));
    files.chain(["dbc/a-type.dbc".to_owned()]).map(|file| Path::new(ROOT).join(file)).collect()
}

#[test]
fn every_feature_decodes_as_in_cantools() {
    let counts = compare(&mut Dice(1), &own_files(), 500);
    assert!(counts.frames >= 14_000, "{}", counts.frames);
    assert!(counts.values > 30_000, "{}", counts.values);
    assert!(counts.absent > 5_000 && counts.short > 1_000, "{} {}", counts.absent, counts.short);
}

#[test]
fn random_databases_decode_as_in_cantools() {
    let directory = tempfile::tempdir().unwrap();
    let mut dice = Dice(20_231_114);
    let files: Vec<PathBuf> = (0..60)
        .map(|number| {
            let file = directory.path().join(format!("{number}.dbc"));
            std::fs::write(&file, random_dbc(&mut dice, 8)).unwrap();
            file
        })
        .collect();
    let counts = compare(&mut dice, &files, 40);
    assert_eq!(counts.frames, 60 * 8 * 40);
    assert!(counts.values > 30_000, "{}", counts.values);
    assert!(counts.absent > 10_000 && counts.short > 3_000, "{} {}", counts.absent, counts.short);
}

#[test]
fn names_limits_units_and_value_tables_are_as_in_cantools() {
    let mut commands = String::new();
    let mut ours = Vec::new();
    for file in own_files() {
        writeln!(commands, "D {}\nI", file.display()).unwrap();
        let database = Database::parse(&std::fs::read_to_string(file).unwrap()).unwrap();
        for message in database.messages() {
            let flag = if message.id.is_extended() { 'x' } else { 's' };
            let (name, id, length) = (&message.name, message.id.value(), message.length);
            ours.push(format!("message {name} {id}{flag} {length}"));
            for signal in &message.signals {
                let limits = signal
                    .range
                    .map_or("-".to_owned(), |[low, high]| format!("{},{}", bits(low), bits(high)));
                let mut values = signal.values.clone();
                values.sort();
                let names: Vec<String> =
                    values.iter().map(|(number, name)| format!("{number}={name}")).collect();
                let (name, unit) = (&signal.name, &signal.unit);
                ours.push(format!("signal {name} {limits} [{unit}] {}", names.join(";")));
            }
        }
        ours.push("end".to_owned());
    }
    // Signals come in the order of their place there.
    let by_message = |lines: Vec<String>| {
        let mut message = String::new();
        let mut lines: Vec<(String, String)> = lines
            .into_iter()
            .map(|line| {
                if !line.starts_with("signal") {
                    message.clone_from(&line);
                }
                (message.clone(), line)
            })
            .collect();
        lines.sort();
        lines
    };
    assert_eq!(by_message(ours), by_message(cantools(&commands)));
}
