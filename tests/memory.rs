//! How much memory a recording may take. In a binary of its own, as it measures the resident memory of
//! its process: beside tests that load whole recordings it would measure those.

use std::fs;
use std::io::{self, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use tertius::bus::{Options, Reason, Recording};
use tertius_testing::candump::drain;

/// Gives `left` bytes of one kind and remembers the largest piece that it was asked for.
struct Endless {
    left: u64,
    largest: Arc<AtomicU64>,
}

impl Read for Endless {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.largest.fetch_max(buffer.len() as u64, Ordering::Relaxed);
        let length = self.left.min(buffer.len() as u64);
        buffer[..length as usize].fill(b'(');
        self.left -= length;
        Ok(length as usize)
    }
}

#[test]
fn a_hundred_megabytes_without_a_newline_are_one_bad_line_in_bounded_memory() {
    let largest = Arc::new(AtomicU64::new(0));
    let endless = Endless { left: 100_000_000, largest: Arc::clone(&largest) };
    let reader = Box::new(endless.chain(&b"\n(1.0) can0 123#11\n"[..]));
    let before = resident();
    let (frames, statistics) = drain(Recording::from_reader("endless", reader, Options::default()));
    assert_eq!((frames.len(), statistics.lines, statistics.bad_lines), (1, 2, 1));
    assert_eq!(statistics.first_bad_lines[0].reason, Reason::LineTooLong);
    assert!(largest.load(Ordering::Relaxed) <= 256 * 1024);
    // A buffer that grew would take 100 MB.
    assert!(resident() < before + 50_000_000, "{} B became {} B", before, resident());
}

/// Resident memory of this process in bytes.
fn resident() -> u64 {
    let statm = fs::read_to_string("/proc/self/statm").unwrap();
    statm.split(' ').nth(1).unwrap().parse::<u64>().unwrap() * 4096
}
