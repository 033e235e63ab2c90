//! `tertius doctor` on a bus where a machine plays.

use std::fs;
use std::process::Command;
use tertius::bus::UnrestrictedPort;
use tertius::bus::append_log_line;
use tertius::frame::{Frame, Id, Kind};
use tertius::time::Timestamp;
use tertius_testing::bench::{Bench, excerpt, wait_for};
use tertius_testing::program;

/// Starts a machine that plays on, without the messages of those identifiers, and looks.
fn look(bench: &Bench, without: &[u32]) -> (Option<i32>, String) {
    let mut log = Vec::new();
    let frames = excerpt(20.0, 30.0);
    for frame in frames.iter().filter(|frame| !without.contains(&frame.id.value())) {
        append_log_line(&mut log, bench.interface, frame);
    }
    fs::write(bench.path("machine.log"), log).expect("the folder is ours");
    let dump = bench.candump();
    let log = bench.name("machine.log");
    let played = bench.path("player.log");
    let _player =
        tertius_testing::bench::Running::start("canplayer", &["-l", "i", "-I", &log], &played);
    wait_for("the machine", || {
        fs::read_to_string(bench.path("bus.log")).is_ok_and(|log| log.contains("1C1#"))
    });
    drop(dump);
    let doctor = Command::new(program())
        .args(["doctor", "--config", &bench.name("machine.toml")])
        .output()
        .expect("it runs");
    (doctor.status.code(), String::from_utf8(doctor.stdout).expect("UTF-8"))
}

/// Whether `said` has `before`, a number of seconds that is at least `least`, and `after`. A box without a
/// moment to spare listens longer than it was to.
fn listened(said: &str, before: &str, least: f64, after: &str) -> bool {
    said.split(before).skip(1).any(|rest| {
        let seconds = rest.split(' ').next().and_then(|word| word.parse::<f64>().ok());
        seconds.is_some_and(|seconds| seconds >= least)
            && rest.split_once(' ').is_some_and(|(_, rest)| rest.starts_with(after))
    })
}

#[test]
fn a_machine_that_plays_is_heard_whole() {
    let bench = Bench::up("t-doctor");
    let (code, said) = look(&bench, &[]);
    assert_eq!(code, Some(0), "{said}");
    for words in [
        "ok    can            this kernel has CAN sockets",
        "ok    interface      t-doctor (virtual CAN) is up",
        "  cycle          Sync each ",
        "ok    error frames   none",
        "ok    node           no other device sends as node 81",
    ] {
        assert!(said.contains(words), "{words:?} is not in\n{said}");
    }
    assert!(listened(&said, "ok    frames         all 20 messages came in ", 2.0, "s"), "{said}");
}

#[test]
fn what_does_not_come_is_named() {
    let bench = Bench::up("t-doctor");
    let (code, said) = look(&bench, &[0x183, 0x193, 0x1A3]);
    assert_eq!(code, Some(1), "{said}");
    let missing = "s: Cyl3_C1 (183), Cyl3_C2 (193), Cyl3_Valve";
    assert!(listened(&said, "3 of 20 messages did not come in ", 2.0, missing), "{said}");
}

#[test]
fn a_second_gateway_with_the_same_node_is_told_from_the_one_that_runs_here() {
    let bench = Bench::up("t-doctor");
    let gateway = bench.gateway();
    let (_, said) = look(&bench, &[]);
    let node =
        said.lines().find(|line| line.contains("one sender, the gateway that is running here"));
    assert!(node.is_some_and(|line| line.starts_with("ok")), "{said}");
    drop(gateway);
    // Another's status, now and again.
    let mut other = bench.machine();
    let id = Id::standard(0x1D1).expect("eleven bits");
    let frame = Frame::new(Timestamp::default(), id, Kind::Data, &[0; 8]);
    let (sent, stop) = std::sync::mpsc::channel::<()>();
    std::thread::scope(|scope| {
        scope.spawn(move || {
            let pause = std::time::Duration::from_millis(100);
            while stop.recv_timeout(pause) == Err(std::sync::mpsc::RecvTimeoutError::Timeout) {
                other.send_unrestricted(&frame).expect("it is up");
            }
        });
        let (code, said) = look(&bench, &[]);
        drop(sent);
        assert_eq!(code, Some(1), "{said}");
        assert!(said.contains("FAIL  node"), "{said}");
    });
}

#[test]
fn a_bus_that_is_silent_or_down_fails() {
    let bench = Bench::new("t-doctor");
    bench.create();
    let doctor = || {
        let arguments = ["doctor", "--listen", "0.2", "--config", &bench.name("machine.toml")];
        let doctor = Command::new(program()).args(arguments).output().expect("it runs");
        (doctor.status.code(), String::from_utf8(doctor.stdout).expect("UTF-8"))
    };
    let (code, said) = doctor();
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("FAIL  interface      t-doctor (virtual CAN) is down"), "{said}");
    tertius_testing::bench::ip(&["link", "set", "up", "t-doctor"]);
    let (code, said) = doctor();
    assert_eq!(code, Some(1), "{said}");
    let nothing = listened(&said, "FAIL  frames         none in ", 0.2, "s, of the 20 messages");
    assert!(nothing, "{said}");
}
