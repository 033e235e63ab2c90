//! Files, compression and damage.

use std::fs;
use std::io::{self, Cursor, Read, Write};
use std::path::PathBuf;

use tempfile::TempDir;
use tertius::bus::{BadPlace, Options, Reason, Recording, Source, SourceError};
use tertius_testing::candump::{drain, read};

/// `count` lines that compress badly enough to be worth several blocks.
fn lines(count: u64) -> Vec<u8> {
    let line = |n: u64| {
        let data = n.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        format!("({}.{:06}) can0 181#{data:016X}\n", 1_700_000_000 + n / 1000, n % 1000 * 1000)
    };
    (0..count).flat_map(|n| line(n).into_bytes()).collect()
}

fn gzip(text: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(text).unwrap();
    encoder.finish().unwrap()
}

/// Files in a directory that goes away with it.
struct Files(TempDir);

impl Files {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, content: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        fs::write(&path, content).unwrap();
        path
    }
}

#[test]
fn compression_is_recognised_by_content_and_not_by_name() {
    let files = Files::new();
    let text = lines(30_000);
    let expected = read(&text);
    let two = text.len() / 2 + 7;
    let zst = zstd::encode_all(&text[..], 3).unwrap();
    // What others put before the data: sixteen magic numbers, a length, and as many bytes.
    let skippable =
        |low: u8| [&[0x50 | low, 0x2A, 0x4D, 0x18, 3, 0, 0, 0, 1, 2, 3], &zst[..]].concat();
    let contents = [
        ("skippable.log", skippable(0x0)),
        ("skippable too", skippable(0xF)),
        ("plain.gz", text.clone()),
        ("gzip.log", gzip(&text)),
        ("members", [gzip(&text[..two]), gzip(&text[two..])].concat()),
        ("zstd.log.gz", zstd::encode_all(&text[..], 3).unwrap()),
        (
            "frames",
            [&text[..two], &text[two..]].map(|half| zstd::encode_all(half, 3).unwrap()).concat(),
        ),
    ];
    for (name, content) in contents {
        let path = files.write(name, &content);
        let mut recording = Recording::open(&[path], Options::default()).unwrap();
        let total = Some(content.len() as u64);
        assert_eq!(
            (recording.progress().consumed, recording.progress().total),
            (0, total),
            "{name}"
        );
        while recording.next_frame().unwrap().is_some() {}
        assert_eq!(recording.statistics(), &expected.1, "{name}");
        assert_eq!(recording.progress().consumed, content.len() as u64, "{name}");
        let again = Recording::open(&[files.0.path().join(name)], Options::default()).unwrap();
        assert_eq!(drain(again), expected, "{name}");
    }
}

#[test]
fn a_truncated_file_gives_what_is_readable_and_the_next_one_follows() {
    let files = Files::new();
    let text = lines(20_000);
    let (gz, zst) = (gzip(&text), zstd::encode_all(&text[..], 3).unwrap());
    let after = files.write("after.log", b"(1800000000.000000) can0 7FF#\nbad\n");
    for (content, kind) in [(&gz, "gzip"), (&zst, "zstd")] {
        let path = files.write("cut", &content[..content.len() * 2 / 3]);
        let (frames, statistics) =
            drain(Recording::open(&[&path, &after], Options::default()).unwrap());
        assert!(frames.len() > 10_000 && frames.len() < 15_000, "{kind}: {}", frames.len());
        assert_eq!(frames[..frames.len() - 1], read(&text).0[..frames.len() - 1]);
        assert_eq!(frames.last().unwrap().id.value(), 0x7FF);
        assert_eq!((statistics.damaged_inputs, statistics.damage.len()), (1, 1));
        let damage = statistics.damage[0].to_string();
        assert!(
            damage.starts_with(&format!("{}: the {kind} data are truncated", path.display())),
            "{damage}"
        );
        // Half a line must not become a frame with half the data.
        let bad: Vec<_> =
            statistics.first_bad_lines.iter().map(|bad| (bad.reason, bad.place)).collect();
        let last = bad.last().unwrap();
        assert_eq!(last.1, BadPlace::Line(2));
        assert_eq!(statistics.first_bad_lines.last().unwrap().text, "bad");
        for (reason, line) in &bad[..bad.len() - 1] {
            assert_eq!((*reason, *line), (Reason::CutOff, BadPlace::Line(frames.len() as u64)));
        }
    }
}

#[test]
fn corrupt_data_are_reported() {
    let text = lines(20_000);
    let mut gz = gzip(&text);
    let middle = gz.len() / 2;
    gz[middle..middle + 100].fill(0xFF);
    let (frames, statistics) = read(&gz);
    assert!(frames.len() > 5_000, "{}", frames.len());
    assert_eq!(statistics.damaged_inputs, 1);
    assert!(statistics.damage[0].reason.starts_with("the gzip data are corrupt"));
    let mut gz = gzip(&text);
    let checksum = gz.len() - 8;
    gz[checksum] ^= 1;
    let (frames, statistics) = read(&gz);
    assert_eq!((frames.len(), statistics.damaged_inputs), (20_000, 1));
}

/// Fails once after its bytes, and then is at its end.
struct Failing {
    bytes: Cursor<Vec<u8>>,
    failed: bool,
}

impl Read for Failing {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.bytes.read(buffer)? {
            0 if !self.failed => {
                self.failed = true;
                Err(io::Error::other("the disk is gone"))
            }
            length => Ok(length),
        }
    }
}

#[test]
fn a_reader_that_fails_is_damage_whatever_it_holds() {
    let text = lines(20_000);
    let gz = gzip(&text);
    let zst = zstd::encode_all(&text[..], 3).unwrap();
    let halves = [&text[..text.len() / 2 - 5], &gz[..gz.len() / 2], &zst[..zst.len() / 2]];
    for half in halves {
        let reader = Failing { bytes: Cursor::new(half.to_vec()), failed: false };
        let recording = Recording::from_reader("disk", Box::new(reader), Options::default());
        let (frames, statistics) = drain(recording);
        assert!(frames.len() > 5_000, "{}", frames.len());
        assert!(statistics.first_bad_lines.iter().all(|bad| bad.reason == Reason::CutOff));
        let damage = statistics.damage[0].to_string();
        assert_eq!(damage, "disk: reading failed: the disk is gone; the rest is lost");
    }
    let reader = Failing { bytes: Cursor::new(b"(1".to_vec()), failed: false };
    let recording = Recording::from_reader("disk", Box::new(reader), Options::default());
    assert_eq!(drain(recording).1.damaged_inputs, 1);
}

#[test]
fn several_files_are_read_in_turn_each_with_its_own_lines_and_zero() {
    let files = Files::new();
    let first =
        files.write("first", b"nonsense\n (0.5)  can0  123   [1]  11\n (0.2)  can0  123   [1]  22");
    let second = files
        .write("second", b" (0.1)  can0  123   [1]  33\nnonsense\n (0.9)  can0  123   [1]  44\n");
    let empty = files.write("empty", b"");
    let paths = [&first, &empty, &second];
    let (frames, statistics) = drain(Recording::open(&paths, Options::default()).unwrap());
    let read: Vec<_> = frames.iter().map(|f| (f.timestamp.as_seconds(), f.data()[0])).collect();
    assert_eq!(read, [(0.5, 0x11), (0.7, 0x22), (0.1, 0x33), (0.9, 0x44)]);
    let bad: Vec<_> =
        statistics.first_bad_lines.iter().map(|bad| (bad.file.clone(), bad.place)).collect();
    assert_eq!(
        bad,
        [
            (first.display().to_string(), BadPlace::Line(1)),
            (second.display().to_string(), BadPlace::Line(2))
        ]
    );
    assert_eq!(statistics.lines, 6);
}

#[test]
fn what_cannot_be_opened_is_named_before_anything_is_read() {
    let files = Files::new();
    let good = files.write("good", b"(1.0) can0 123#11\n");
    let missing = files.0.path().join("missing.log");
    let error = Recording::open(&[&good, &missing], Options::default()).err().unwrap();
    assert!(matches!(error, SourceError::Open { .. }));
    assert!(error.to_string().contains("missing.log"), "{error}");
    let error = Recording::open(&[files.0.path()], Options::default()).err().unwrap();
    assert!(matches!(error, SourceError::Directory { .. }), "{error}");
    let mut recording =
        Recording::open(&[&good, &missing.with_file_name("good")], Options::default()).unwrap();
    fs::remove_file(&good).unwrap();
    assert!(recording.next_frame().is_err());
    let none: [&str; 0] = [];
    assert!(Recording::open(&none, Options::default()).unwrap().next_frame().unwrap().is_none());
}
