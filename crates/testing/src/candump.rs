//! Reading recordings from memory, in any pieces.

use std::collections::VecDeque;
use std::io::{self, Cursor, Read};

use tertius::bus::{Options, Recording, Source, Statistics};
use tertius::frame::Frame;

pub fn frames_of(text: &[u8]) -> Recording {
    let reader = Box::new(Cursor::new(text.to_vec()));
    Recording::from_reader("test", reader, Options::default())
}

pub fn read(text: &[u8]) -> (Vec<Frame>, Statistics) {
    read_with(text, Options::default())
}

pub fn read_with(text: &[u8], options: Options) -> (Vec<Frame>, Statistics) {
    let reader = Box::new(Cursor::new(text.to_vec()));
    drain(Recording::from_reader("test", reader, options))
}

pub fn drain(mut recording: Recording) -> (Vec<Frame>, Statistics) {
    let mut frames = Vec::new();
    while let Some(frame) = recording.next_frame().expect("the input opens") {
        frames.push(frame.clone());
    }
    (frames, recording.statistics().clone())
}

/// As [`read_with`], the bytes coming in pieces of these sizes over and over; 0 is an
/// interruption.
pub fn read_in_pieces(text: &[u8], sizes: &[usize], options: Options) -> (Vec<Frame>, Statistics) {
    let reader = Pieces { text: text.to_vec().into(), sizes: sizes.to_vec(), next: 0 };
    drain(Recording::from_reader("test", Box::new(reader), options))
}

struct Pieces {
    text: VecDeque<u8>,
    sizes: Vec<usize>,
    next: usize,
}

impl Read for Pieces {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let size = self.sizes.get(self.next % self.sizes.len().max(1)).copied().unwrap_or(1);
        self.next += 1;
        if size == 0 && self.sizes.iter().any(|&size| size > 0) {
            return Err(io::ErrorKind::Interrupted.into());
        }
        let size = size.max(1).min(buffer.len());
        self.text.read(&mut buffer[..size])
    }
}
