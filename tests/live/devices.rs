//! CANopen devices that tell of themselves, live: the gateway sends what a replay of the same frames says.

use std::process::Command;
use tertius::frame::Frame;
use tertius_testing::process::{read, top, wire};
use tertius_testing::program;
use tertius_testing::support::changed;

/// A lost magnet, a valve that is too hot, a heartbeat that stops, and a device that is pre-operational.
const FAULTS: [&str; 5] = [
    "broken_wire,cylinder=3,sensor=c1_emergency,at=3,until=4",
    "broken_wire,cylinder=6,sensor=valve_emergency,at=4.5,until=4.6,code=16912",
    "loss,cylinder=2,sensor=c2_heartbeat,at=5,until=7",
    "loss,cylinder=5,sensor=c1,at=9,until=11",
    "out_of_range,cylinder=5,sensor=c1_heartbeat,at=9,until=11",
];

fn tertius(arguments: &[&str]) {
    let output = Command::new(program()).args(arguments).output().expect("it runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
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
    let (config, log) = (path("machine.toml"), path("bus.log"));
    let mut simulate = vec!["simulate", "--config", &config, "--duration", "13", "--seed", "7"];
    simulate.extend(FAULTS.iter().flat_map(|fault| ["--fault", fault]));
    simulate.extend(["--output", &log]);
    tertius(&simulate);
    let beats = read(log.as_ref()).iter().filter(|it| it.id.value() > 0x700).count();
    assert!(beats > 18 * 100, "{beats} heartbeats");
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
