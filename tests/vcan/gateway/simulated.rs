//! The simulated machine on a bus, live.

use std::fs;
use std::process::{Command, Output};
use tertius_testing::bench::{Bench, run, wait_for, wire};
use tertius_testing::program;

/// A bus with the simulated machine's configuration.
fn bench(interface: &'static str) -> Bench {
    let bench = Bench::up(interface);
    let top = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string(top.join("config/e-type-simulated.toml")).expect("it ships");
    let dbc = top.join("dbc/e-type.dbc");
    let text = text
        .replace("\"can0\"", &format!("{interface:?}"))
        .replace("\"../dbc/e-type.dbc\"", &format!("{dbc:?}"))
        // Not even on a busy box is a warning dropped for its age then, or a frame longer on its way
        // into the queue than the guard lasts.
        .replace("max_age = 0.2", "max_age = 10.0")
        .replace("guard = 0.01", "guard = 0.5");
    bench.configure(&text);
    bench
}

fn simulate(bench: &Bench, arguments: &[&str]) -> Output {
    let config = bench.name("machine.toml");
    let output = Command::new(program())
        .args(["simulate", "--config", &config, "--seed", "5"])
        .args(["--fault", "step,cylinder=3,at=2.5,size=0.0025"])
        .args(arguments)
        .output()
        .expect("it runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output
}

fn lines(bench: &Bench, log: &str) -> Vec<String> {
    let text = fs::read_to_string(bench.path(log)).expect("it was written");
    // candump's start is shown by frames of 7FF.
    text.lines().filter(|line| !line.contains("7FF#")).map(str::to_owned).collect()
}

fn seconds(line: &str) -> f64 {
    let (_, stamp) = line.split_once('(').expect("a time stamp");
    let (stamp, _) = stamp.split_once(')').expect("its end");
    stamp.parse().expect("seconds")
}

#[test]
fn on_an_interface_it_sends_what_it_writes_in_its_own_time() {
    let bench = bench("t-simulate");
    let dump = bench.candump();
    let live = ["--duration", "4", "--interface", "t-simulate", "--speed", "2"];
    let output = simulate(&bench, &[&live[..], &["--output", &bench.name("live.log")]].concat());
    simulate(&bench, &["--duration", "4", "--output", &bench.name("file.log")]);
    let sent = lines(&bench, "live.log");
    assert_eq!(sent, lines(&bench, "file.log"), "the same call gives the same bytes");
    assert_eq!(sent.len(), 4 * 50 * 22);
    wait_for("the last frame", || lines(&bench, "bus.log").len() >= sent.len());
    drop(dump);
    let heard = lines(&bench, "bus.log");
    assert!(wire(&heard) == wire(&sent), "{} of {}", heard.len(), sent.len());
    // 4 s less the last cycle's rest, twice as fast; a box without a moment to spare takes longer.
    let took = seconds(&heard[heard.len() - 1]) - seconds(&heard[0]);
    assert!((1.99..6.0).contains(&took), "{took} s");
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(told.contains("4400 frames sent on t-simulate"), "{told}");
    assert!(told.contains("to t-simulate (SocketCAN"), "{told}");
}

#[test]
fn a_simulated_recording_that_canplayer_plays_has_the_warnings_of_its_replay() {
    let bench = bench("t-played");
    simulate(&bench, &["--duration", "5", "--output", &bench.name("machine.log")]);
    let dump = bench.candump();
    let gateway = bench.gateway();
    run("canplayer", &["-I", &bench.name("machine.log")]);
    bench.stop(gateway);
    drop(dump);
    let replay = Command::new(program())
        .args(["replay", &bench.name("bus.log"), "--config", &bench.name("machine.toml")])
        .args(["--format", "jsonl", "--warnings", &bench.name("replayed.log")])
        .output()
        .expect("it runs");
    assert!(replay.status.success(), "{}", String::from_utf8_lossy(&replay.stderr));
    let warnings = |lines: &[String]| -> Vec<String> {
        wire(lines).into_iter().filter(|it| it.starts_with("2D1#")).map(str::to_owned).collect()
    };
    let live = warnings(&bench.own_lines());
    let replayed = warnings(&lines(&bench, "replayed.log"));
    assert!(live.len() >= 2 && live.len() <= replayed.len(), "{} {}", live.len(), replayed.len());
    assert!(live == replayed[..live.len()], "they differ: {live:?} {replayed:?}");
}

#[test]
fn it_ends_on_sigint_and_tells_what_it_sent() {
    let bench = bench("t-stopped");
    let config = bench.name("machine.toml");
    let dump = bench.candump();
    let arguments = ["simulate", "--config", &config, "--interface", "t-stopped"];
    let simulation =
        tertius_testing::bench::Running::start(program(), &arguments, &bench.path("said.log"));
    wait_for("some cycles", || lines(&bench, "bus.log").len() > 100);
    simulation.signal("INT");
    let said = || fs::read_to_string(bench.path("said.log")).unwrap_or_default();
    wait_for("its end", || said().contains("frames sent on t-stopped"));
    drop(dump);
    let nowhere = ["simulate", "--config", &config, "--interface", "t-nothing"];
    let output = Command::new(program()).args(nowhere).output().expect("it runs");
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("there is no interface t-nothing"), "{told}");
}
