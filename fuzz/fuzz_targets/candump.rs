//! Recordings of any bytes: no panic, the same frames and counts however the bytes come in, and
//! every line and frame accounted for.

#![no_main]

use std::io::{self, Cursor, Read};

use libfuzzer_sys::fuzz_target;
use tertius::bus::{Interfaces, Options, Recording, Source, Statistics, TimeStamps};
use tertius::frame::{Frame, Kind};

/// Gives pieces of sizes that vary with the bytes themselves.
struct Pieces(Cursor<Vec<u8>>);

impl Read for Pieces {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let place = self.0.position() as usize;
        let size = 1 + usize::from(self.0.get_ref().get(place).copied().unwrap_or(0) % 61);
        let length = buffer.len().min(size);
        self.0.read(&mut buffer[..length])
    }
}

fn drain(reader: Box<dyn Read + Send>, options: Options) -> (Vec<Frame>, Statistics) {
    let mut recording = Recording::from_reader("fuzz", reader, options);
    let mut frames = Vec::new();
    while let Some(frame) = recording.next_frame().expect("memory can be opened") {
        frames.push(frame.clone());
    }
    (frames, recording.statistics().clone())
}

fn options(data: &[u8]) -> Options {
    let time_stamps = match data.len() % 7 {
        0 => TimeStamps::Absolute,
        1 => TimeStamps::Delta,
        2 => TimeStamps::Zero,
        _ => TimeStamps::Auto,
    };
    let interfaces = match data.len() % 11 {
        0 => Interfaces::Only("can0".to_owned()),
        _ => Interfaces::All,
    };
    Options { time_stamps, interfaces }
}

fuzz_target!(|data: &[u8]| {
    let whole = drain(Box::new(Cursor::new(data.to_vec())), options(data));
    let pieces = drain(Box::new(Pieces(Cursor::new(data.to_vec()))), options(data));
    assert_eq!(whole, pieces);
    let (frames, statistics) = whole;
    assert_eq!(statistics.frames, frames.len() as u64 + statistics.other_interface_frames);
    assert!(statistics.frames + statistics.bad_lines <= statistics.lines);
    for frame in frames {
        let limit = if matches!(frame.kind, Kind::Fd { .. }) { 64 } else { 8 };
        assert!(frame.length() <= limit);
    }
});
