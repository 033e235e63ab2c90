//! Bus logging in MDF 4: as recordings of any bytes, with the head that files of the format have.

#![no_main]

use std::io::Cursor;

use libfuzzer_sys::fuzz_target;
use tertius::bus::{Options, Recording, Source};
use tertius::frame::Kind;

fuzz_target!(|data: &[u8]| {
    let mut bytes = data.to_vec();
    if bytes.len() >= 16 {
        let head: &[u8; 9] = if bytes[0] == b'U' { b"UnFinMF 4" } else { b"MDF     4" };
        bytes[..9].copy_from_slice(head);
    }
    let reader = Box::new(Cursor::new(bytes));
    let mut recording = Recording::from_reader("fuzz", reader, Options::default());
    let mut frames = 0;
    while let Some(frame) = recording.next_frame().expect("memory can be opened") {
        let limit = if matches!(frame.kind, Kind::Fd { .. }) { 64 } else { 8 };
        assert!(frame.length() <= limit);
        frames += 1;
    }
    let statistics = recording.statistics();
    assert_eq!(statistics.frames, frames);
    assert!(statistics.frames + statistics.bad_lines <= statistics.lines);
});
