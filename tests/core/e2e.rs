//! AUTOSAR E2E profile 5, both directions against cantools.

use std::fmt::Write;

use tertius::alarm::e2e::{self, E2eError};
use tertius_testing::oracle;

/// SplitMix64: the same frames in every run, and no more than this test needs.
struct Seeded(u64);

impl Seeded {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn bytes(&mut self, length: usize) -> Vec<u8> {
        (0..length).map(|_| self.next() as u8).collect()
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// What cantools says to each `(data ID, frame)`: valid as it stands, and the frame protected.
fn cantools(frames: &[(u16, Vec<u8>)]) -> Vec<(bool, String)> {
    let input: String =
        frames.iter().map(|(data_id, frame)| format!("{data_id:x} {}\n", hex(frame))).collect();
    let output = oracle::run("e2e.py", &[], &input);
    let answers: Vec<_> = output
        .lines()
        .map(|line| line.split_once(' ').expect("two fields"))
        .map(|(valid, protected)| (valid == "1", protected.to_owned()))
        .collect();
    assert_eq!(answers.len(), frames.len());
    answers
}

/// 2000 frames of 8 bytes and 2000 of the other lengths that CAN and CAN FD have. cantools refuses
/// frames without payload, so the shortest are of 4.
fn frames() -> Vec<(u16, Vec<u8>)> {
    let mut seeded = Seeded(5);
    let lengths = [4, 5, 6, 7, 12, 16, 20, 24, 32, 48, 64];
    (0..4000)
        .map(|i| {
            let length = if i % 2 == 0 { 8 } else { lengths[i / 2 % lengths.len()] };
            (seeded.next() as u16, seeded.bytes(length))
        })
        .collect()
}

#[test]
fn what_we_protect_is_what_cantools_protects() {
    let frames = frames();
    for ((data_id, frame), (_, theirs)) in frames.iter().zip(cantools(&frames)) {
        let mut ours = frame.clone();
        e2e::protect(&mut ours, *data_id, frame[2]);
        assert_eq!(hex(&ours), theirs, "data ID {data_id:#x}");
        assert_eq!(e2e::check(&ours, *data_id), Ok(frame[2]));
    }
}

/// Protected frames, of which two thirds are then damaged in one byte or checked under another
/// data ID.
#[test]
fn what_we_believe_is_what_cantools_believes() {
    let mut seeded = Seeded(55);
    let mut frames = frames();
    for (i, (data_id, frame)) in frames.iter_mut().enumerate() {
        let counter = frame[2];
        e2e::protect(frame, *data_id, counter);
        match i % 3 {
            0 => {}
            1 => {
                let place = seeded.next() as usize % frame.len();
                frame[place] ^= 1 << (seeded.next() % 8);
            }
            _ => *data_id ^= 1 << (seeded.next() % 16),
        }
    }
    let mut believed = 0;
    for ((data_id, frame), (valid, _)) in frames.iter().zip(cantools(&frames)) {
        let ours = e2e::check(frame, *data_id);
        assert_eq!(ours.is_ok(), valid, "data ID {data_id:#x}, frame {}: {ours:?}", hex(frame));
        believed += usize::from(valid);
    }
    assert_eq!(believed, 4000_usize.div_ceil(3), "every damaged frame is refused");
}

#[test]
fn a_frame_without_room_for_crc_and_counter_is_too_short() {
    for length in 0..e2e::HEADER {
        assert_eq!(e2e::check(&vec![0; length], 0x1D1), Err(E2eError::TooShort { length }));
    }
    // The shortest that has room: no payload at all.
    let mut header = [0; e2e::HEADER];
    e2e::protect(&mut header, 0x1D1, 255);
    assert_eq!(e2e::check(&header, 0x1D1), Ok(255));
}

#[test]
fn the_error_shows_both_checksums() {
    let mut frame = [0, 0, 7, 1, 2, 3, 4, 5];
    e2e::protect(&mut frame, 0x2D1, 7);
    let right = u16::from_le_bytes([frame[0], frame[1]]);
    frame[0] ^= 0xFF;
    let wrong = right ^ 0xFF;
    assert_eq!(e2e::check(&frame, 0x2D1), Err(E2eError::Crc { found: wrong, expected: right }));
    let message = e2e::check(&frame, 0x2D1).unwrap_err().to_string();
    assert!(message.contains(&format!("0x{wrong:04X}")), "{message}");
    assert!(message.contains(&format!("0x{right:04X}")), "{message}");
}
