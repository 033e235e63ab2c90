//! Recordings of any bytes: no panic, and the same frames in one piece and byte by byte.

#![no_main]

use std::io::{self, Cursor, Read};

use libfuzzer_sys::fuzz_target;
use tertius::bus::{Options, Recording, Source, Statistics};
use tertius::frame::Frame;

/// Gives one byte at a time.
struct Drops(Cursor<Vec<u8>>);

impl Read for Drops {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let length = buffer.len().min(1);
        self.0.read(&mut buffer[..length])
    }
}

fn drain(reader: Box<dyn Read + Send>) -> (Vec<Frame>, Statistics) {
    let mut recording = Recording::from_reader("fuzz", reader, Options::default());
    let mut frames = Vec::new();
    while let Some(frame) = recording.next_frame().expect("memory can be opened") {
        frames.push(frame.clone());
    }
    (frames, recording.statistics().clone())
}

fuzz_target!(|data: &[u8]| {
    let whole = drain(Box::new(Cursor::new(data.to_vec())));
    let drops = drain(Box::new(Drops(Cursor::new(data.to_vec()))));
    assert_eq!(whole, drops);
});
