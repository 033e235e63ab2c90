//! What is written in each format is read as the frames that were given.

use proptest::prelude::*;
use tertius::bus::{Unsayable, written};
use tertius::frame::{Frame, Id, Kind};
use tertius::time::Timestamp;
use tertius_testing::candump::read;

/// Lengths that a CAN FD frame can have, bytes.
const LENGTHS: [usize; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];

fn id() -> impl Strategy<Value = Id> {
    let standard = (0..0x800_u32).prop_map(|id| Id::standard(id).expect("11 bits"));
    let extended = (0..0x2000_0000_u32).prop_map(|id| Id::extended(id).expect("29 bits"));
    prop_oneof![standard, extended]
}

/// Frames that a bus can carry, at times after one another and before one another.
fn frame() -> impl Strategy<Value = Frame> {
    let bytes = prop::collection::vec(any::<u8>(), 64);
    let kind = prop_oneof![
        4 => (0..=8_usize).prop_map(|length| (Kind::Data, length)),
        2 => (0..4_u8, 0..16_usize).prop_map(|(flags, code)| (Kind::Fd { flags }, LENGTHS[code])),
        1 => (0..=8_u8).prop_map(|length| (Kind::Remote { length }, 0)),
        1 => (0..=8_usize).prop_map(|length| (Kind::Error, length)),
    ];
    let nanos = prop_oneof![
        8 => 1_700_000_000_000_000_000..1_700_000_100_000_000_000_i64,
        1 => Just(0_i64),
        1 => any::<i64>(),
    ];
    (nanos, id(), kind, bytes).prop_map(|(nanos, id, (kind, length), bytes)| {
        // The classes of an error are read as 29 bits.
        let id = if kind == Kind::Error { Id::extended(id.value()).expect("29 bits") } else { id };
        Frame::new(Timestamp::from_nanos(nanos), id, kind, &bytes[..length])
    })
}

/// What a format without kinds of errors keeps of a frame.
fn kept(frame: &Frame, explains: bool) -> Frame {
    if explains || frame.kind != Kind::Error {
        return frame.clone();
    }
    Frame::new(frame.timestamp, Id::extended(0x80).expect("29 bits"), Kind::Error, &[])
}

proptest! {
    #[test]
    fn frames_are_read_as_they_were_given(
        frames in prop::collection::vec((0..3_usize, frame()), 1..40),
    ) {
        for format in written() {
            let (mut encoder, mut bytes) = ((format.encoder)(), Vec::new());
            let mut expected = Vec::new();
            for (interface, frame) in &frames {
                let name = ["can0", "channel2", "bus1"][*interface];
                match encoder.add(name, frame, &mut bytes) {
                    Ok(()) => expected.push(kept(frame, format.explains_errors)),
                    Err(Unsayable::BeforeStart) => {
                        prop_assert!(frame.timestamp < frames[0].1.timestamp);
                    }
                    Err(Unsayable::Before1970) => prop_assert!(frame.timestamp.as_nanos() < 0),
                    Err(why) => prop_assert!(false, "{}", why),
                }
            }
            let head = encoder.finish(&mut bytes);
            let (found, statistics) = read(&bytes);
            prop_assert_eq!(statistics.bad_lines, 0, "{}: {:?}", format.word, statistics);
            prop_assert_eq!(&found, &expected, "{}", format.word);
            if let Some(head) = head {
                bytes[..head.len()].copy_from_slice(&head);
                prop_assert_eq!(read(&bytes).0, expected, "{}", format.word);
            }
        }
    }
}
