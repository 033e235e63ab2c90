//! A format without lines: records of any length, one after the other.

use std::io::Cursor;

use super::*;
use crate::reason::Found;
use tertius_core::frame::{Id, Kind};
use tertius_core::time::Timestamp;

/// Records of a length in three bytes, low byte first, and as many bytes: an identifier of two bytes and
/// the data. An empty record is no frame, and one of a single byte is bad.
static RECORDS: Format = Format {
    name: "records",
    numbered: Numbered::Bytes,
    is_whole: false,
    recognise: |_| Some(false),
    reader: |_| Box::new(Records),
    written: None,
};

struct Records;

const EXPECTED: &str = "an identifier of two bytes";

impl Reader for Records {
    fn read<'a>(&'a mut self, unread: Unread<'a>, frame: &mut Frame) -> Item<'a> {
        let [low, middle, high, rest @ ..] = unread.bytes else { return Item::More };
        let length = u32::from_le_bytes([*low, *middle, *high, 0]) as usize;
        let Some(record) = rest.get(..length) else { return Item::More };
        let taken = 3 + length;
        match record {
            [] => Item::Nothing { taken },
            [_] => {
                let reason = Reason::Expected { found: Found::first(record), expected: EXPECTED };
                Item::Bad { shown: taken, taken, reason }
            }
            [low, high, data @ ..] => {
                let id = Id::standard(u16::from_le_bytes([*low, *high]).into()).expect("11 bits");
                *frame = Frame::new(Timestamp::default(), id, Kind::Data, data);
                Item::Frame { taken, interface: b"can0", absolute: false }
            }
        }
    }
}

fn read(bytes: &[u8]) -> (Vec<u32>, Statistics) {
    let reader = Box::new(Cursor::new(bytes.to_vec()));
    let mut recording = Recording::from_reader("test", reader, Options::default());
    recording.reader = Some((&RECORDS, (RECORDS.reader)(TimeStamps::Auto)));
    let mut ids = Vec::new();
    while let Some(frame) = recording.next_frame().expect("memory opens") {
        ids.push(frame.id.value());
    }
    (ids, recording.statistics().clone())
}

#[test]
fn records_are_counted_and_placed_by_their_bytes() {
    // Line ends mean nothing, and neither does what begins a line of candump.
    let text = b"(1700000000.000516) can0 7FF#0000000000000000\n(1700000000.000516) can0 7FF#00\n";
    let mut bytes = vec![3, 0, 0, 0x81, 1, b'\n', 0, 0, 0, 1, 0, 0, b'\n'];
    bytes.extend([text.len() as u8 + 2 - 20, 0, 0, 0x82, 1]);
    bytes.extend(&text[..text.len() - 20]);
    let (ids, statistics) = read(&bytes);
    assert_eq!(ids, [0x181, 0x182]);
    assert_eq!((statistics.lines, statistics.frames, statistics.bad_lines), (4, 2, 1));
    let bad = statistics.first_bad_lines[0].to_string();
    assert_eq!(bad, format!("test, byte 9: found the byte 0x0A, expected {EXPECTED}: 01 00 00 0A"));
}

#[test]
fn an_incomplete_record_is_bad_and_one_that_is_too_long_never_fills_the_memory() {
    let (ids, statistics) = read(&[2, 0, 0, 0x81, 1, 2, 0, 0, 0x82]);
    assert_eq!((ids, statistics.bad_lines), (vec![0x181], 1));
    let bad = &statistics.first_bad_lines[0];
    assert_eq!((bad.reason, bad.place), (Reason::Incomplete, BadPlace::Byte(5)));
    let mut bytes = vec![0xFF; 3 * MAX_RECORD];
    bytes.extend([2, 0, 0, 0x81, 1]);
    let (_, statistics) = read(&bytes);
    let bad = &statistics.first_bad_lines[0];
    assert_eq!((bad.reason, bad.place), (Reason::RecordTooLong, BadPlace::Byte(0)));
    assert_eq!(bad.text, "FF FF FF FF FF FF FF FF FF FF FF FF FF FF FF FF …");
}
