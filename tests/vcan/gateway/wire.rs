//! What stands on the bus, as others see it.

use serde_json::Value;
use std::fs;
use std::process::Command;
use tertius_testing::bench::{Bench, excerpt, run, wait_for, wire};
use tertius_testing::oracle;
use tertius_testing::program;

/// Plays an excerpt to a gateway and stops it; its frames as candump saw them.
fn record(bench: &Bench, from: f64, to: f64) -> Vec<String> {
    let dump = bench.candump();
    let gateway = bench.gateway();
    bench.play(&excerpt(from, to));
    bench.stop(gateway);
    drop(dump);
    bench.own_lines()
}

#[test]
fn what_it_sends_live_is_what_a_replay_of_the_simultaneous_candump_says() {
    let bench = Bench::up("t-same");
    // Not even on a busy box is a warning dropped for its age then, or a frame longer on its way into
    // the queue than the guard lasts.
    let patient = "\n[gateway]\nmax_age = 10.0\nguard = 0.5\n";
    bench.configure(&(bench.configuration() + patient));
    // Cylinder 1 steps by 2.5 mm from 60 s to 65 s.
    let live = record(&bench, 57.0, 66.5);
    let replay = Command::new(program())
        .args(["replay", &bench.name("bus.log"), "--config", &bench.name("machine.toml")])
        .args(["--format", "jsonl", "--warnings", &bench.name("replayed.log")])
        .output()
        .expect("it runs");
    assert!(replay.status.success(), "{}", String::from_utf8_lossy(&replay.stderr));
    let replayed = fs::read_to_string(bench.path("replayed.log")).expect("replay wrote it");
    let replayed: Vec<String> = replayed.lines().map(str::to_owned).collect();

    // A box without a moment to spare lets a newer status take the place of one that still waits;
    // warnings are all there.
    let warnings = |lines: &[String]| -> Vec<String> {
        wire(lines).into_iter().filter(|it| it.starts_with("2D1#")).map(str::to_owned).collect()
    };
    let (live, replayed) = (warnings(&live), warnings(&replayed));
    assert!(live.len() >= 4 && live.len() <= replayed.len(), "{} {}", live.len(), replayed.len());
    assert!(live == replayed[..live.len()], "live and replay differ: {live:?} {replayed:?}");
}

#[test]
fn a_fault_played_to_it_stands_on_the_bus_as_cantools_reads_it() {
    let bench = Bench::up("t-decode");
    let lines = record(&bench, 58.5, 74.0);
    fs::write(bench.path("own.log"), lines.join("\n") + "\n").expect("the folder is ours");
    let frames = oracle::run("gateway.py", &["dbc/e-type.dbc", &bench.name("own.log")], "");
    let frames: Vec<(i64, u64, String, bool, Value)> = serde_json::from_str(&frames).expect("JSON");
    assert!(frames.iter().all(|(.., whole, _)| *whole), "E2E holds in each");
    let warnings: Vec<&Value> =
        frames.iter().filter(|frame| frame.1 == 0x2D1).map(|frame| &frame.4).collect();
    let is = |warning: &&&Value, wanted: &[(&str, i64)]| {
        wanted.iter().all(|&(signal, value)| warning[signal].as_i64() == Some(value))
    };
    // C1 of cylinder 1 steps. FDE3 needs no model, so that it does not mind a player without a
    // moment to spare; what the observers make of such a machine is the other test's matter.
    let fde3 = [("Cylinder", 1), ("Detector", 3)];
    let of_fde3: Vec<&&Value> = warnings.iter().filter(|warning| is(warning, &fde3)).collect();
    let raised = |warning: &&Value| warning["Raised"].as_i64() == Some(1);
    assert!(of_fde3.first().is_some_and(|first| raised(first)), "{of_fde3:?}");
    assert!(of_fde3.last().is_some_and(|last| !raised(last)), "it has cleared: {of_fde3:?}");
    let counters: Vec<i64> = frames
        .iter()
        .filter(|frame| frame.1 == 0x1D1)
        .map(|frame| frame.4["Counter"].as_i64().expect("it has one"))
        .collect();
    // A status that gave way to a newer one, on a box without a moment to spare, leaves a gap that a
    // receiver is to see; none comes twice.
    let steps = counters.windows(2).map(|pair| (pair[1] - pair[0]).rem_euclid(256));
    assert!(steps.clone().all(|step| (1..=5).contains(&step)), "{counters:?}");
    assert!(steps.filter(|&step| step == 1).count() > counters.len() / 2, "{counters:?}");
}

/// Its own frames, which it does not receive, are none of another device's.
#[test]
fn a_frame_of_another_device_with_its_own_identifier_is_told() {
    let bench = Bench::up("t-forged");
    bench.configure(&bench.configuration());
    let _dump = bench.candump();
    let gateway = bench.gateway();
    bench.play(&excerpt(57.0, 58.0));
    assert_eq!(bench.said("another device sends frames 0x1D1"), 0);
    run("cansend", &["t-forged", "1D1#5555555555555555"]);
    wait_for("the line", || bench.said("another device sends frames 0x1D1") == 1);
    bench.stop(gateway);
}
