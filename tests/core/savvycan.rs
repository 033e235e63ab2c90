//! Tables of SavvyCAN: read and written by Python's csv module, and by hand.

use std::fs;

use proptest::prelude::*;
use proptest::sample::Index;
use serde_json::{Value, json};
use tertius::bus::{BadPlace, Options, Reason, Recording, SourceError, in_order};
use tertius::frame::{Frame, Id, Kind};
use tertius::time::Timestamp;
use tertius_testing::candump::{drain, read, read_in_pieces};
use tertius_testing::oracle;

/// 2023-11-14 22:13:20 UTC in µs.
const START: i64 = 1_700_000_000_000_000;
const HEAD: &str = "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8\n";
const OLD_HEAD: &str = "Time Stamp,ID,Extended,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8\n";

fn data(micros: i64, id: Id, kind: Kind, data: &[u8]) -> Frame {
    Frame::new(Timestamp::from_nanos(1000 * micros), id, kind, data)
}

fn standard(id: u32) -> Id {
    Id::standard(id).expect("11 bits")
}

fn extended(id: u32) -> Id {
    Id::extended(id).expect("29 bits")
}

/// Tables as different versions and devices write them, with the same three frames after `start`, µs.
fn tables() -> [(&'static str, i64, String); 4] {
    let new = format!(
        "{HEAD}1700000000010000,00000181,false,Rx,0,2,E0,2D,00,00,00,00,00,00,\n\
         1700000000020000,18FEF100,true,Tx,0,1,01,00,00,00,00,00,00,00,\n\
         1700000000030000,00000100,false,Rx,0,0,00,00,00,00,00,00,00,00,\n"
    );
    let empty = format!(
        "{HEAD}10000,00000181,false,Rx,0,2,E0,2D,,,,,,,\r\n\
         20000,18FEF100,true,Rx,0,1,01,,,,,,,,\r\n\
         30000,00000100,false,Rx,0,0,,,,,,,,,"
    );
    let old = format!(
        "{OLD_HEAD}1700000000010000,00000181,false,0,2,E0,2D,00,00,00,00,00,00,\n\
         1700000000020000,18FEF100,true,0,1,01,00,00,00,00,00,00,00,\n\
         1700000000030000,00000100,false,0,0,00,00,00,00,00,00,00,00,\n"
    );
    let sheet = "\u{FEFF}time stamp,id,extended,dir,bus,len,d1,d2\n\n\
         10000,0x181,0,RX,0,2,e0,2d\n\
         20000,0x18FEF100,1,tx,0,1,1\n\
         30000,100,FALSE,rx,0,0\n"
        .to_owned();
    [("new", START, new), ("empty", 0, empty), ("old", START, old), ("sheet", 0, sheet)]
}

/// A frame as the script prints it.
fn printed(frame: &Frame) -> Value {
    let hex: String = frame.data().iter().map(|byte| format!("{byte:02x}")).collect();
    let micros = frame.timestamp.as_nanos() / 1000;
    json!([micros, frame.id.value(), frame.id.is_extended(), 0, hex])
}

#[test]
fn tables_of_every_kind_are_read_as_pythons_csv_reads_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut paths, mut ours) = (Vec::new(), Vec::new());
    for (name, start, table) in tables() {
        let (frames, statistics) = read(table.as_bytes());
        let expected = [
            data(start + 10_000, standard(0x181), Kind::Data, &[0xE0, 0x2D]),
            data(start + 20_000, extended(0x18FE_F100), Kind::Data, &[1]),
            data(start + 30_000, standard(0x100), Kind::Data, &[]),
        ];
        assert_eq!(statistics.bad_lines, 0, "{name}: {:?}", statistics.first_bad_lines);
        assert_eq!(frames, expected, "{name}");
        assert_eq!(statistics.interfaces_found(), "bus0 (3 frames)", "{name}");
        for sizes in [&[1][..], &[7, 0, 64]] {
            let pieces = read_in_pieces(table.as_bytes(), sizes, Options::default());
            assert_eq!(pieces, (frames.clone(), statistics.clone()), "{name}");
        }
        // The script knows the columns by SavvyCAN's names.
        if name != "sheet" {
            let path = folder.path().join(name);
            fs::write(&path, &table).expect("it can be written");
            paths.push(path.display().to_string());
            ours.push(frames.iter().map(printed).collect::<Vec<_>>());
        }
    }
    let call: Vec<&str> = std::iter::once("read").chain(paths.iter().map(String::as_str)).collect();
    let theirs: Vec<Vec<Value>> =
        serde_json::from_str(&oracle::run("savvycan.py", &call, "")).expect("JSON");
    assert_eq!(ours, theirs);
}

#[test]
fn what_the_script_writes_is_the_candump_that_it_was_made_from() {
    let folder = tempfile::tempdir().expect("a folder");
    let log = "tests/oracle/e-type-excerpt.log";
    let (frames, _) = read(&fs::read(oracle::top().join(log)).expect("the excerpt"));
    assert!(frames.len() > 40);
    for columns in ["dir", "old"] {
        let path = folder.path().join("table.csv");
        let table = path.display().to_string();
        oracle::run("savvycan.py", &["write", columns, log, &table], "");
        let (written, statistics) =
            drain(Recording::open(&[&path], Options::default()).expect("it opens"));
        assert_eq!((written, statistics.bad_lines), (frames.clone(), 0), "{columns}");
    }
}

#[test]
fn buses_and_can_fd_are_told_apart() {
    let fd: String = (0..12).map(|n| format!("{n:02X},")).collect();
    let text = format!("{HEAD}1,123,false,Rx,1,12,{fd}\n2,123,false,Rx,12,8,{fd}\n");
    let (frames, statistics) = read(text.as_bytes());
    assert_eq!(statistics.bad_lines, 0, "{:?}", statistics.first_bad_lines);
    let found: Vec<_> = frames.iter().map(|frame| (frame.kind, frame.data().len())).collect();
    assert_eq!(found, [(Kind::Fd { flags: 0 }, 12), (Kind::Data, 8)]);
    assert_eq!(frames[0].data(), [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]);
    assert_eq!(statistics.interfaces_found(), "bus1 (1 frame), bus12 (1 frame)");
}

#[test]
fn a_bad_line_says_what_was_expected_and_changes_nothing_else() {
    let good = "10000,00000181,false,Rx,0,2,E0,2D,\n";
    for (line, reason) in [
        ("x,181,false,Rx,0,1,00,", "found “x”, expected a time in whole microseconds"),
        ("1.5,181,false,Rx,0,1,00,", "found “1”, expected a time in whole microseconds"),
        ("1,1G1,false,Rx,0,1,00,", "found “G” in the identifier, expected a hexadecimal digit"),
        ("1,,false,Rx,0,1,00,", "found the end of the line, expected an identifier"),
        ("1,800,false,Rx,0,1,00,", "the identifier 800 is out of range, expected at most 7FF"),
        ("1,FFFFFFFF,true,Rx,0,1,00,", "the identifier FFFFFFFF is out of range"),
        ("1,181,maybe,Rx,0,1,00,", "found “m”, expected true or false"),
        ("1,181,false,0,1,00,", "found “0”, expected Rx or Tx"),
        ("1,181,false,Rx,,1,00,", "found the end of the line, expected the number of a bus"),
        ("1,181,false,Rx,0,-,00,", "found “-”, expected the number of bytes of data"),
        ("1,181,false,Rx,0,9,00,", "9 bytes of data, but a CAN FD frame has"),
        ("1,181,false,Rx,0,65,00,", "more than 64 bytes of data"),
        ("1,181,false,Rx,0,2,00,,", "the line announces 2 bytes, but 1 follow"),
        ("1,181,false,Rx,0,1,0x,", "found “x” in the data, expected a hexadecimal digit"),
        ("1,181,false,Rx,0,1,0E0,", "found “0” in the data, expected a hexadecimal digit"),
        ("1,181,false", "found the end of the line, expected Rx or Tx"),
    ] {
        let (frames, statistics) = read(format!("{HEAD}{good}{line}\n{good}").as_bytes());
        assert_eq!((frames.len(), statistics.bad_lines), (2, 1), "{line}");
        let bad = &statistics.first_bad_lines[0];
        assert!(bad.reason.to_string().starts_with(reason), "{line}: {bad}");
        assert_eq!((bad.place, bad.text.as_str()), (BadPlace::Line(3), line));
    }
    let late = format!("{HEAD}999999999999999999,181,false,Rx,0,1,00,\n");
    let (_, statistics) = read(late.as_bytes());
    assert_eq!(statistics.first_bad_lines[0].reason, Reason::StampRange);
    let other = "Time Stamp,ID,Extended,Length,Data\n1,181,false,1,00\n";
    let (frames, statistics) = read(other.as_bytes());
    assert_eq!((frames.len(), statistics.bad_lines), (0, 2));
    let reason = statistics.first_bad_lines[0].reason.to_string();
    assert!(reason.contains("expected the columns Dir,Bus,LEN,D1 or Bus,LEN,D1"), "{reason}");
}

#[test]
fn tables_behind_one_another_are_read_and_put_in_order_where_their_times_are_absolute() {
    let [(_, _, new), _, (_, _, old), _] = tables();
    let (frames, statistics) = read(format!("{new}{old}").as_bytes());
    assert_eq!((frames.len(), statistics.bad_lines), (6, 0));
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).expect("it can be written");
        path
    };
    let (table, before) = (write("table", &new), write("a", "(1699999999.000000) bus0 7FF#\n"));
    let wrong = Recording::open(&[&table, &before], Options::default()).err();
    assert!(matches!(wrong, Some(SourceError::Order { .. })));
    let sorted = in_order(&[table.clone(), before.clone()], &Options::default().interfaces);
    assert_eq!(sorted, [before, table]);
    // Times since a device started say nothing of the order of two tables.
    let first = write("first", &format!("{HEAD}20000,181,false,Rx,0,0,\n"));
    let second = write("second", &format!("{HEAD}10000,181,false,Rx,0,0,\n"));
    assert!(Recording::open(&[&first, &second], Options::default()).is_ok());
}

proptest! {
    /// Whatever becomes of some bytes, nothing breaks, every line is accounted for, and the sizes of the
    /// reads make no difference.
    #[test]
    fn damaged_tables_do_no_harm(
        kind in 0..4_usize,
        damage in prop::collection::vec((any::<Index>(), any::<u8>()), 0..12),
        sizes in prop::collection::vec(1..200_usize, 1..4),
    ) {
        let mut text = tables()[kind].2.repeat(3).into_bytes();
        for (place, byte) in &damage {
            // Digits do the most harm.
            let byte = if byte % 2 == 0 { b'0' + byte % 10 } else { *byte };
            let place = place.index(text.len() - 30) + 30;
            text[place] = byte;
        }
        let (frames, statistics) = read(&text);
        prop_assert!(statistics.frames + statistics.bad_lines <= statistics.lines);
        prop_assert_eq!(statistics.frames, frames.len() as u64);
        let pieces = read_in_pieces(&text, &sizes, Options::default());
        prop_assert_eq!(pieces, (frames, statistics));
    }
}
