//! `tertius demo` without a terminal: it needs nothing but the program, finds what it announces, and
//! what it says stands on its bus.

use std::collections::{BTreeMap, BTreeSet};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use tertius::frame::Frame;
use tertius_testing::process::{self, read};
use tertius_testing::program;
use tertius_testing::support::{self, Scratch};

/// A run in an empty folder.
fn demo(arguments: &[&str]) -> support::Run {
    let folder = tempfile::tempdir().expect("there is room");
    let output = Command::new(program())
        .arg("demo")
        .args(arguments)
        .current_dir(folder.path())
        .stdin(Stdio::null())
        .output()
        .expect("it runs");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    support::Run {
        code: output.status.code(),
        stdout: text(output.stdout),
        stderr: text(output.stderr),
    }
}

#[test]
fn it_finds_every_fault_as_announced_and_says_so() {
    let started = Instant::now();
    let run = demo(&[]).ok();
    assert!(started.elapsed() < Duration::from_secs(20), "{:?}", started.elapsed());
    assert_eq!(run.stderr, "");
    for (fault, suspect, named) in [
        ("C1 of cylinder 3 jumps by 2 mm", "C1", "abrupt"),
        ("C2 of cylinder 5 gets noise of 1.7 mm", "C2", "noise"),
        ("C1 of cylinder 2 drifts by 1 mm/s", "C1 or C2", "incipient"),
        ("C2 of cylinder 6 freezes", "C2", "frozen"),
        ("the wire of C1 of cylinder 4 breaks", "C1", "broken wire"),
    ] {
        let announced = run.stdout.find(&format!("now: {fault}\n")).expect(fault);
        let row = run.stdout[announced..].lines().find(|line| line.starts_with(fault));
        let row = row.expect("a row of the table");
        let words: Vec<&str> = row[fault.len()..].split("  ").filter(|it| !it.is_empty()).collect();
        let words: Vec<&str> = words.into_iter().map(str::trim).collect();
        assert_eq!(words[1..], [named, &format!("{suspect}, right")], "{row}");
        let after: f64 = words[0].trim_end_matches(" s").parse().expect("seconds");
        // A drift of 1 mm/s has to grow to 1.5 mm first.
        let most = if suspect == "C1 or C2" { 2.5 } else { 0.3 };
        assert!(after > 0.0 && after < most, "{row}");
    }
    assert!(run.stdout.contains("5 of 5 as announced, 0 warnings without a fault."));
    let states = ["safe", "settled", "neutral", "engaged"]
        .map(|state| run.stdout.find(&format!("the platform is {state}")).expect("it comes up"));
    assert!(states.is_sorted());
    assert!(!run.stdout.contains('\u{1b}'), "nothing for a terminal");
    let longest = run.stdout.lines().map(|line| line.chars().count()).max();
    assert!(longest.is_some_and(|longest| longest <= 80), "{longest:?}");
}

/// The bus has the frames of devices, and the broken wire is an emergency message.
#[test]
fn with_canopen_devices_it_finds_the_same() {
    let scratch = Scratch::new();
    let log = scratch.path("bus.log");
    let run = demo(&["--canopen", "--record", &log]).ok();
    assert!(
        run.stdout.contains("5 of 5 as announced, 0 warnings without a fault."),
        "{}",
        run.stdout
    );
    let frames = read(log.as_ref());
    let said: Vec<&[u8]> =
        frames.iter().filter(|it| it.id.value() == 0x084).map(Frame::data).collect();
    assert_eq!(said, [&[0x00, 0x50, 0, 0, 0, 0, 0, 0], &[0; 8]]);
    let set_points = frames.iter().filter(|it| it.id.value() == 0x521).count();
    assert_eq!(set_points, 60 * 50);
}

#[test]
fn the_same_seed_says_the_same_and_another_finds_the_faults_on_another_sea() {
    let first = demo(&["--seed", "7"]).ok();
    assert_eq!(first, demo(&["--seed", "7", "--speed", "max"]).ok());
    assert_ne!(first, demo(&["--seed", "8"]).ok());
}

/// What is shown of a frame is a frame of the bus; the gateway sends Fd_Status and Fd_Warning and no
/// other, the machine its own, and a replay of the bus says what the gateway said.
#[test]
fn what_it_shows_stands_on_its_bus() {
    let scratch = Scratch::new();
    let (log, replayed) = (scratch.path("bus.log"), scratch.path("replayed.log"));
    let run = demo(&["--record", &log]).ok();
    let recorded = scratch.read("bus.log");
    let lines: BTreeSet<&str> = recorded.lines().collect();
    let shown: Vec<&str> =
        run.stdout.lines().map(str::trim).filter(|it| it.contains('#')).collect();
    assert!(shown.len() > 30, "{}", shown.len());
    assert!(shown.iter().all(|line| lines.contains(line)));

    let frames = read(log.as_ref());
    let mut count: BTreeMap<u32, usize> = BTreeMap::new();
    for frame in &frames {
        *count.entry(frame.id.value()).or_default() += 1;
    }
    let mut expected = BTreeSet::from([0x080, 0x1B1, 0x2B1, 0x1C1, 0x1D1, 0x2D1]);
    expected.extend((1..=6).flat_map(|n| [0x180 + n, 0x190 + n, 0x1A0 + n]));
    assert_eq!(count.keys().copied().collect::<BTreeSet<u32>>(), expected);
    assert_eq!(count[&0x080], 60 * 50);
    let sent = format!("sent {} Fd_Status and {} Fd_Warning", count[&0x1D1], count[&0x2D1]);
    assert!(run.stdout.contains(&sent), "{sent}");

    support::replay(&[&log], "config/e-type-simulated.toml", &["--warnings", &replayed]).ok();
    let of_gateway = |frame: &&Frame| [0x1D1, 0x2D1].contains(&frame.id.value());
    let live: Vec<Frame> = frames.iter().filter(of_gateway).cloned().collect();
    let (live, replayed) = (process::wire(&live), process::wire(&read(replayed.as_ref())));
    // Its stopping status, and at most what fell due after the last frame.
    assert!(live.len() > replayed.len() && live.len() <= replayed.len() + 2);
    assert_eq!(live[..replayed.len()], replayed);
}

/// SIGINT in the middle ends it, with what has happened until then, and it is no failure.
#[test]
fn it_can_be_stopped() {
    let folder = tempfile::tempdir().expect("there is room");
    let out = folder.path().join("out.txt");
    let mut running = process::Running::start(program(), &["demo", "--speed", "2"], &out);
    process::wait_for("the platform", || process::said(&out, "the platform is settled"));
    running.signal("INT");
    assert!(running.end().success());
    assert!(process::said(&out, "0 of 0 as announced"));
}

#[test]
fn a_wrong_call_ends_with_2() {
    demo(&["--speed", "0"]).failed(2, &["expected a number from 0.001 to 1000000, or max"]);
    demo(&["--record", "no/such/folder.log"]).failed(2, &["cannot be created"]);
}
