//! `tertius eds`: the data sheet of the gateway as a CANopen node.

use serde_json::{Value, json};
use tertius_testing::oracle;
use tertius_testing::support::{Scratch, recording, replay, tertius};

const NODE: (&str, &str) =
    ("[plausibility]", "[canopen]\nnode = true\nheartbeat = 0.5\n\n[plausibility]");

/// What Python's `canopen` reads in a sheet.
fn read(sheet: &str) -> Value {
    let read = oracle::run("canopen_sheet.py", &[sheet, "81"], "");
    serde_json::from_str(&read).expect("JSON")
}

#[test]
fn pythons_canopen_reads_the_sheets_and_both_say_the_same() {
    let scratch = Scratch::new();
    let config = scratch.config(&[NODE]);
    let (eds, dcf) = (scratch.path("gateway.eds"), scratch.path("gateway.dcf"));
    tertius(&["eds", "--config", &config, "--output", &eds], b"").ok();
    tertius(&["eds", "--config", &config, "--dcf", "--output", &dcf], b"").ok();
    let [device, configured] = [&eds, &dcf].map(|sheet| read(sheet));
    assert_eq!((&configured[0], &configured[1]), (&json!(81), &json!(500_000)));
    assert_eq!((&device[0], &device[1]), (&Value::Null, &Value::Null));
    assert_eq!(device[2], configured[2]);
    assert_eq!(device[3], configured[3]);

    // COB-IDs without remote frames; the estimates are not sent. Each PDO is full.
    let pdos = device[2].as_array().expect("a list");
    let cob_ids: Vec<u64> = pdos.iter().filter_map(|pdo| pdo[0].as_u64()).collect();
    assert_eq!(cob_ids, [0x4000_01D1, 0x4000_02D1, 0xC000_03D1]);
    for pdo in pdos {
        let bits = pdo[1].as_array().expect("a list").iter().filter_map(|part| part[1].as_u64());
        assert_eq!(bits.sum::<u64>(), 64, "{pdo}");
    }
    let objects = &device[3];
    for (place, expected) in [
        ("1008:0", json!(["Manufacturer device name", 9, "const"])),
        ("1017:0", json!(["Producer heartbeat time", 6, "rw", 500])),
        ("1200:1", json!(["SDO server parameter.COB-ID client to server", 7, "const", 0x651])),
        ("2000:1", json!(["Machine.Name", 9, "const", "Ampelmann E-type, simulated"])),
        ("2106:3", json!(["Cylinder 6.R1, m", 8, "ro", null])),
        ("2201:4", json!(["Thresholds of cylinder 1.R3 raises above, m", 8, "const", 0.0015])),
    ] {
        let expected = expected.as_array().expect("a list");
        let found = objects[place].as_array().unwrap_or_else(|| panic!("{place}: {objects}"));
        assert_eq!(found[..expected.len()], expected[..], "{place}");
    }
    // Nothing of the monitor can be written.
    let all = objects.as_object().expect("objects");
    let writable = all.iter().filter(|(_, it)| it[2] != "const" && it[2] != "ro");
    let writable: Vec<&str> = writable.map(|(place, _)| place.as_str()).collect();
    assert_eq!(writable, ["1003:0", "1017:0"]);
    assert!(all.len() > 150, "{}", all.len());
}

#[test]
fn a_sheet_is_written_again_and_nothing_else_is_overwritten() {
    let scratch = Scratch::new();
    let config = scratch.config(&[NODE]);
    let eds = scratch.path("gateway.eds");
    let call = ["eds", "--config", &config, "--output", &eds];
    tertius(&call, b"").ok();
    let first = scratch.read("gateway.eds");
    tertius(&call, b"").ok();
    assert_eq!(scratch.read("gateway.eds"), first, "the same configuration gives the same bytes");
    let printed = tertius(&["eds", "--config", &config], b"").ok().stdout;
    assert_eq!(printed, first.replace("FileName=gateway.eds", "FileName=tertius.eds"));
    let foreign = scratch.write("foreign.eds", "[FileInfo]\r\nCreatedBy=somebody\r\n");
    let call = ["eds", "--config", &config, "--output", &foreign];
    tertius(&call, b"").failed(2, &["foreign.eds"]);
    tertius(&["eds", "--config", &config, "--output", &config], b"").failed(2, &["over the input"]);
}

#[test]
fn without_a_node_there_is_no_sheet() {
    let scratch = Scratch::new();
    let words = ["the gateway is no CANopen node", "`node = true` in [canopen]"];
    let config = scratch.config(&[]);
    tertius(&["eds", "--config", &config], b"").failed(2, &words);
    let config = scratch.config(&[("[plausibility]", "[canopen]\nnode = false\n\n[plausibility]")]);
    tertius(&["eds", "--config", &config], b"").failed(2, &words);
}

/// The examples of the help, word for word but for where they write.
#[test]
fn the_examples_of_the_help_write_sheets() {
    let scratch = Scratch::new();
    let help = tertius(&["eds", "--help"], b"").ok().stdout;
    let examples = help.lines().filter_map(|line| line.trim().strip_prefix("tertius eds "));
    let mut written = 0;
    for example in examples.filter(|it| it.starts_with("--config")) {
        let words: Vec<&str> = example.split(' ').collect();
        let [call @ .., name] = &words[..] else { panic!("{example}") };
        let sheet = scratch.path(name);
        tertius(&[&["eds"], call, &[&*sheet]].concat(), b"").ok();
        assert!(scratch.read(name).contains("CreatedBy=tertius eds"), "{example}");
        written += 1;
    }
    assert_eq!(written, 2, "{help}");
}

/// A whole recording: every part of every PDO by the sheet and by the DBC.
#[test]
fn pdos_by_the_sheet_are_those_by_the_dbc() {
    let scratch = Scratch::new();
    let sent = "[canopen]\nnode = true\n[estimate]\nsend = true\n[gateway]\nbus_share = 0.15\n\n[plausibility]";
    let config = scratch.config(&[("[plausibility]", sent)]);
    let (eds, frames) = (scratch.path("gateway.eds"), scratch.path("frames.log"));
    tertius(&["eds", "--config", &config, "--output", &eds], b"").ok();
    let log = recording("e-type-faults.log.zst");
    replay(&[&log], &config, &["--warnings", &frames]).ok();
    let compared = oracle::run("canopen_pdos.py", &[&eds, "81", "dbc/e-type.dbc", &frames], "");
    let compared: Value = serde_json::from_str(&compared).expect("JSON");
    let of = |id: &str| compared[id].as_u64().unwrap_or(0);
    assert!(of("1D1") > 1000 && of("2D1") > 50 && of("3D1") > 10_000, "{compared}");
}
