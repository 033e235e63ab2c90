//! Transducers by Python's `canopen`, which tell of themselves.

use serde_json::Value;
use std::fs;
use std::process::Command;
use tertius_testing::bench::{Bench, wire};
use tertius_testing::support::replay;
use tertius_testing::{oracle, top};

/// A gateway for one cylinder with CANopen devices, and what it says of `story`: its warnings and notices as
/// lines of JSON, by a replay that was compared with what it sent.
fn told(interface: &'static str, story: &str) -> (Bench, Vec<Value>) {
    let bench = Bench::up(interface);
    let shipped = fs::read_to_string(top().join("config/e-type-canopen.toml")).expect("it ships");
    let second = "[[canopen.device]]\nnode = 2\n";
    let text = shipped.split(second).next().expect("it has a first cylinder");
    let text = text
        .replace("cylinders = 6", "cylinders = 1")
        .replace("\"can0\"", &format!("{interface:?}"))
        .replace("../dbc", top().join("dbc").to_str().expect("plain"))
        .replace("max_age = 0.2", "max_age = 10.0")
        .replace("guard = 0.01", "guard = 0.5")
        // The EDS says that the transducers send none, and the test's nodes are told to.
        .replace("role = \"c1\"\n", "role = \"c1\"\nheartbeat = 0.15\n")
        .replace("role = \"c2\"\n", "role = \"c2\"\nheartbeat = 0.15\n");
    bench.configure(&text);
    let dump = bench.candump();
    let gateway = bench.gateway();
    let sheet = top().join("dbc/encoder.eds");
    let output = Command::new(oracle::python())
        .arg(oracle::top().join("tests/oracle/canopen_devices.py"))
        .args([interface, sheet.to_str().expect("plain"), story])
        .output()
        .expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    bench.stop(gateway);
    drop(dump);
    let sent = bench.name("replayed.log");
    let (log, config) = (bench.name("bus.log"), bench.name("machine.toml"));
    let run = replay(&[&log], &config, &["--warnings", &sent]).ok();
    let replayed = fs::read_to_string(sent).expect("it was written");
    let replayed: Vec<String> = replayed.lines().map(str::to_owned).collect();
    let (live, replayed) = (warnings(&bench.own_lines()), warnings(&replayed));
    // The gateway repeats what stands while nobody sends any more.
    let both = live.len().min(replayed.len());
    assert!(both > 0 && live[..both] == replayed[..both], "{live:?} {replayed:?}");
    assert!(live.len() + 1 >= replayed.len(), "{live:?} {replayed:?}");
    (bench, run.lines())
}

fn warnings(lines: &[String]) -> Vec<String> {
    wire(lines).into_iter().filter(|it| it.starts_with("2D1#")).map(str::to_owned).collect()
}

/// Times of the frames that candump has of `wire`, s.
fn times(bench: &Bench, wire: &str) -> Vec<f64> {
    let log = fs::read_to_string(bench.path("bus.log")).expect("candump wrote");
    let of = log.lines().filter(|line| line.ends_with(wire));
    let stamp = |line: &str| line.split(['(', ')']).nth(1)?.parse().ok();
    of.map(|line| stamp(line).expect("a time stamp")).collect()
}

/// Times, states and further fields of the plausibility warnings of a transducer.
fn plausibility(lines: &[Value], suspect: &str) -> Vec<(f64, String, Value)> {
    let of = |line: &&Value| {
        line["type"] == "warning"
            && line["detector"] == "plausibility"
            && line["suspect"] == suspect
    };
    let told = |line: &Value| {
        let at = line["timestamp"].as_f64().expect("seconds");
        (at, line["state"].as_str().expect("a word").to_owned(), line.clone())
    };
    lines.iter().filter(of).map(told).collect()
}

#[test]
fn transducers_that_speak_are_heard() {
    let (bench, lines) = told("t-spoken", "spoken");
    // The magnet.
    let said = times(&bench, "081#0050810100000000")[0];
    let of_c1 = plausibility(&lines, "c1");
    let (at, state, warning) = &of_c1[0];
    assert_eq!((state.as_str(), &warning["fault"]), ("raised", &"broken_wire".into()));
    assert!((0.0..0.02).contains(&(at - said)), "{} s after it was said", at - said);
    let device = &warning["device"];
    assert_eq!((&device["node"], &device["code"]), (&1.into(), &"0x5000".into()), "{device}");
    assert_eq!(device["words"], "device hardware");
    assert_eq!(
        of_c1.iter().map(|(_, state, _)| state.as_str()).collect::<Vec<_>>(),
        ["raised", "cleared"]
    );
    let words = "node 1 says EMCY 0x5000: device hardware (maker's own), field 0100000000";
    assert_eq!(bench.said(&format!("device=\"{words}\"")), 2, "as it is raised, and as it clears");
    assert_eq!(bench.said(&format!("C1's device: {words}; ")), 1, "in the story of its incident");
    // The heartbeat.
    let of_c2 = plausibility(&lines, "c2");
    let (at, state, warning) = &of_c2[0];
    assert_eq!((state.as_str(), &warning["fault"]), ("raised", &"stale".into()));
    assert_eq!(warning["device"]["reason"], "heartbeat_lost");
    let before = times(&bench, "711#05").into_iter().rfind(|beat| beat < at).expect("it began");
    // 0.15 s are eight cycles, and the machine's cycle may take its time on a busy box.
    assert!((0.15..0.4).contains(&(at - before)), "{} s after the last one", at - before);
    assert_eq!(
        of_c2.iter().map(|(_, state, _)| state.as_str()).collect::<Vec<_>>(),
        ["raised", "cleared"]
    );
    // Pre-operational.
    let states = lines.iter().filter(|line| line["notice"] == "device_state" && line["node"] == 1);
    let states: Vec<&str> = states.filter_map(|line| line["state"].as_str()).collect();
    assert_eq!(states[states.len() - 2..], ["pre-operational", "operational"]);
}

#[test]
fn a_transducer_without_a_heartbeat_is_missed_by_its_readings() {
    let (bench, lines) = told("t-unspoken", "silent");
    assert_eq!(times(&bench, "701#05"), [0.0; 0], "it has none");
    let of_c1 = plausibility(&lines, "c1");
    let [(_, state, warning)] = &of_c1[..] else { panic!("{of_c1:?}") };
    assert_eq!((state.as_str(), &warning["fault"]), ("raised", &"stale".into()));
    assert!(warning.get("device").is_none(), "{warning}");
    assert_eq!(plausibility(&lines, "c2").len(), 0);
}
