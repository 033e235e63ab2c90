//! CANopen devices that tell of themselves, live: the gateway sends what a replay of the same frames says.

use std::process::Command;
use tertius::frame::{Frame, Id, Kind};
use tertius::time::{Span, Timestamp};
use tertius_testing::process::{read, top, wire, write};
use tertius_testing::program;
use tertius_testing::support::changed;

/// Readings of node 5 between these times are missing, since it is pre-operational, s.
const PRE_OPERATIONAL: std::ops::Range<f64> = 9.0..11.0;
/// Node 18 has no heartbeat between these, s.
const LOST: std::ops::Range<f64> = 5.0..7.0;

fn tertius(arguments: &[&str]) {
    let output = Command::new(program()).args(arguments).output().expect("it runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn frame(at: Timestamp, id: u32, data: &[u8]) -> Frame {
    Frame::new(at, Id::standard(id).expect("11 bits"), Kind::Data, data)
}

/// A simulated machine, whose devices have a heartbeat of 100 ms beside it, and what befalls three of them.
fn with_devices(machine: &[Frame]) -> Vec<Frame> {
    let first = machine[0].timestamp;
    let t = |at: Timestamp| at.since(first).as_seconds();
    let silent =
        |it: &&Frame| it.id.value() != 0x185 || !PRE_OPERATIONAL.contains(&t(it.timestamp));
    let mut frames: Vec<Frame> = machine.iter().filter(silent).cloned().collect();
    for beat in 0..130_i64 {
        let at = first.after(Span::from_nanos(beat * 100_000_000 + 9_000_000));
        for node in (1..=6).chain(17..=22).chain(33..=38) {
            let state = if node == 5 && PRE_OPERATIONAL.contains(&t(at)) { 127 } else { 5 };
            if node != 18 || !LOST.contains(&t(at)) {
                frames.push(frame(
                    at.after(Span::from_nanos(i64::from(node) * 250_000)),
                    0x700 + node,
                    &[state],
                ));
            }
        }
    }
    for (seconds, id, data) in [
        (3.005, 0x083, [0x00, 0x50, 0x81, 0, 0, 0, 0, 0]),
        (4.005, 0x083, [0; 8]),
        (4.505, 0x0A6, [0x10, 0x42, 0x09, 0, 0, 0, 0, 0]),
        (4.605, 0x0A6, [0x30, 0x81, 0x11, 0, 0, 0, 0, 0]),
    ] {
        frames.push(frame(first.after(Span::from_seconds(seconds)), id, &data));
    }
    frames.sort_by_key(|frame| frame.timestamp);
    frames
}

#[test]
fn live_says_of_devices_what_a_replay_says() {
    let folder = tempfile::tempdir().expect("there is room");
    let path = |name: &str| folder.path().join(name).to_str().expect("plain").to_owned();
    let shipped = |name: &str| std::fs::read_to_string(top().join(name)).expect("it ships");
    let put = |name: &str, text: String| std::fs::write(path(name), text).expect("ours");
    put("e-type-canopen.dbc", shipped("dbc/e-type-canopen.dbc"));
    for sheet in ["encoder.eds", "valve.eds"] {
        let beats = "AccessType=rw\nPDOMapping=0\nDefaultValue=";
        let named = |value: &str| {
            format!("heartbeat time\nObjectType=0x7\nDataType=0x0006\n{beats}{value}\n")
        };
        let (none, some) = (named("0"), named("100"));
        put(sheet, changed(&shipped(&format!("dbc/{sheet}")), &[(&none, &some)]));
    }
    let text = shipped("config/e-type-canopen.toml").replace("../dbc/", "");
    // Calibrated, so that nothing but the devices' own warnings is told.
    let corrected = shipped("config/e-type-simulated.toml");
    let corrections = corrected.find("[[cylinder]]").expect("it has them");
    let text = text.replace("\"can0\"", "\"virtual\"") + &corrected[corrections..];
    put("machine.toml", text);
    let (config, simulated, log) = (path("machine.toml"), path("simulated.log"), path("bus.log"));
    tertius(&[
        "simulate",
        "--config",
        &config,
        "--duration",
        "13",
        "--seed",
        "7",
        "--output",
        &simulated,
    ]);
    write(log.as_ref(), "can0", &with_devices(&read(simulated.as_ref())));
    let (live, replayed) = (path("live.log"), path("replayed.log"));
    tertius(&["run", "--config", &config, "--play", &log, "--speed", "max", "--record", &live]);
    tertius(&["replay", &log, "--config", &config, "--warnings", &replayed]);
    let (live, replayed) = (read(live.as_ref()), read(replayed.as_ref()));
    let warned = |cylinder: u8, suspect: u8| {
        let of = |it: &&Frame| {
            let data = it.data();
            it.id.value() == 0x2D1 && data[3] & 7 == cylinder && data[4] >> 1 & 3 == suspect
        };
        replayed.iter().filter(of).count()
    };
    assert!(warned(3, 1) >= 2, "the magnet");
    assert!(warned(6, 3) >= 2, "the valve");
    assert!(warned(2, 2) >= 2, "the heartbeat");
    assert_eq!(warned(5, 1), 0, "who is not operational is not to blame");
    // The stopping status, which no recording knows, and at most what fell due after the last frame.
    let (live, replayed) = (wire(&live), wire(&replayed));
    let differ = replayed.iter().zip(&live).position(|(replayed, live)| replayed != live);
    assert_eq!(differ, None, "of {} and {}", live.len(), replayed.len());
    assert!((1..=2).contains(&(live.len() - replayed.len())), "{:?}", &live[replayed.len()..]);
}
