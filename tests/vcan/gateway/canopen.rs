//! The gateway as a CANopen node, with Python's `canopen` as master.

use serde_json::Value;
use std::fs;
use std::process::{Command, Stdio};
use tertius::bus::append_log_line;
use tertius_testing::bench::{Bench, Running, excerpt, wait_for};
use tertius_testing::{oracle, program};

/// Writes the sheet of the node that the configuration asks for.
fn sheet(bench: &Bench) -> String {
    let name = bench.name("tertius.eds");
    let arguments = ["eds", "--config", &bench.name("machine.toml"), "--output", &name];
    let output = Command::new(program()).args(arguments).output().expect("it runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    name
}

#[test]
fn a_master_reads_every_object_sees_emergencies_and_commands_the_node() {
    let bench = Bench::up("t-node");
    let node =
        "\n[gateway]\nmax_age = 10.0\nguard = 0.5\n[canopen]\nnode = true\nheartbeat = 1.0\n";
    bench.configure(&(bench.configuration() + node));
    let (said, told) = (bench.path("master.log"), bench.path("master.json"));
    let mut master = Command::new(oracle::python())
        .arg(oracle::top().join("tests/oracle/canopen_master.py"))
        .args([bench.interface, &sheet(&bench), "81"])
        .stdin(Stdio::null())
        .stdout(fs::File::create(&told).expect("the folder is ours"))
        .stderr(fs::File::create(&said).expect("the folder is ours"))
        .spawn()
        .expect("it starts");
    let master_said = |word: &str| {
        let said = fs::read_to_string(&said).unwrap_or_default();
        assert!(!said.contains("Traceback"), "{said}");
        said.contains(word)
    };
    wait_for("the master", || master_said("ready"));
    let mut gateway = bench.gateway();
    // Cylinder 1 steps by 2.5 mm from 60 s to 65 s.
    let mut log = Vec::new();
    for frame in &excerpt(58.0, 200.0) {
        append_log_line(&mut log, bench.interface, frame);
    }
    fs::write(bench.path("machine.log"), log).expect("the folder is ours");
    let play = ["-I", &bench.name("machine.log")];
    let player = Running::start("canplayer", &play, &bench.path("player.log"));
    // A box without a moment to spare takes its time, but always gets on.
    let objects = ["object 1003", "object 1200", "object 1A00", "object 2002", "object 2010"];
    let cylinders = ["object 2101", "object 2104", "object 2201", "object 2206", "the objects"];
    let commands = ["silent PRE-OPERATIONAL", "silent STOPPED", "operational", "done"];
    let parts = [&objects[..], &cylinders, &["the emergencies", "the heartbeats"], &commands];
    for part in parts.concat() {
        wait_for(part, || master_said(part));
    }
    drop(player);
    // The log has a writer of its own, and who is killed writes no more.
    wait_for("the log", || bench.said("an NMT master commands") == 3);
    gateway.kill();
    wait_for("the master to miss the heartbeat", || master_said("lost"));
    assert!(master.wait().expect("it ends").success());

    let text = fs::read_to_string(&told).expect("it was written");
    let told: Value = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}"));
    let number = |name: &str| told[name].as_u64().unwrap_or_else(|| panic!("{name}: {told}"));
    assert!(number("constants") > 60 && number("live") > 40, "{told}");
    assert!(number("segmented") > 13, "the counts and the texts");
    assert_eq!(told["values"]["2000:1"].as_str(), Some("Ampelmann E-type, simulated"));
    assert!(told["values"]["2002:4"].as_u64().is_some_and(|cycles| cycles > 10), "{told}");
    let codes: Vec<u64> = [0x0602_0000, 0x0609_0011, 0x0601_0002, 0x0601_0002].into();
    assert_eq!(told["refused"], serde_json::json!(codes));
    let emergencies = told["emergencies"].as_array().expect("a list");
    let raised = |code: u64| emergencies.iter().any(|it| it[0].as_u64() == Some(code));
    assert!(emergencies.iter().any(|it| it[0].as_u64().is_some_and(|code| code >> 8 == 0xFF)));
    assert!(raised(0), "and cleared: {told}");
    let warnings = told["warnings"].as_array().expect("a list");
    for emergency in emergencies {
        assert!(warnings.contains(&emergency[2]), "{emergency} is no Fd_Warning: {told}");
    }
    let [kept, newest, left] = [0, 1, 2].map(|at| told["history"][at].as_u64().expect("a number"));
    assert!(kept > 0 && newest >> 8 == 0xFF && left == 0, "{told}");
    let period = told["period"].as_f64().expect("seconds");
    assert!((0.19..0.4).contains(&period), "{period} s");
    for command in ["PRE-OPERATIONAL", "STOPPED"] {
        assert_eq!(told["silent"][command].as_u64(), Some(0), "{told}");
    }
    assert_eq!((number("boots"), number("heartbeat_after")), (2, 1000));
    for (words, times) in [
        ("an NMT master has silenced the gateway's PDOs", 2),
        ("command=\"stop\" to=\"this node\"", 1),
        ("an NMT master commands", 3),
    ] {
        assert_eq!(bench.said(words), times, "{words}");
    }
}
