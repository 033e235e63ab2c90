//! `tertius run` on the embedded bus: a recording played onto it at any speed gives what a replay
//! of it gives.

use std::path::Path;
use std::process::{Command, Output};
use tertius::frame::Frame;
use tertius::time::Span;
use tertius_testing::process::{configuration, excerpt, read, top, wire, write};
use tertius_testing::program;

fn tertius(arguments: &[&str]) -> Output {
    Command::new(program()).args(arguments).output().expect("it runs")
}

fn plain(path: &Path) -> &str {
    path.to_str().expect("temporary folders have plain names")
}

/// What the gateway sends when `frames` are played at `speed`, and what a replay of them says.
fn play_and_replay(frames: &[Frame], speed: &str) -> (Vec<Frame>, Vec<Frame>) {
    let folder = tempfile::tempdir().expect("there is room");
    let path = |name: &str| folder.path().join(name);
    let (log, live, replayed) = (path("bus.log"), path("live.log"), path("replayed.log"));
    write(&log, "can0", frames);
    let config = configuration(folder.path(), "virtual");
    let (log, config) = (plain(&log), plain(&config));
    let run =
        ["run", "--config", config, "--play", log, "--speed", speed, "--record", plain(&live)];
    let output = tertius(&run);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let output = tertius(&["replay", log, "--config", config, "--warnings", plain(&replayed)]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    (read(&live), read(&replayed))
}

/// The live frames are the replayed ones, then at most what fell due after the last frame, then the
/// stopping status, which no recording knows.
fn assert_same(live: &[Frame], replayed: &[Frame]) {
    let (last, live) = live.split_last().expect("it sends at least its stopping status");
    assert_eq!((last.id.value(), last.data()[6] >> 3 & 0b111), (0x1D1, 4), "its stopping status");
    assert!(live.len() >= replayed.len() && live.len() - replayed.len() <= 1);
    let (live, replayed) = (wire(live), wire(replayed));
    let differ = replayed.iter().zip(&live).position(|(replayed, live)| replayed != live);
    assert_eq!(differ, None, "of {} and {}", live.len(), replayed.len());
}

#[test]
fn a_recording_played_as_fast_as_it_goes_gives_what_its_replay_says() {
    // Steps of 1.25 mm at 60 s; they end at 65 s.
    let frames = excerpt(57.0, 66.51);
    let (live, replayed) = play_and_replay(&frames, "max");
    assert_same(&live, &replayed);
    assert!(live.iter().any(|frame| frame.id.value() == 0x2D1), "the step was found");
    // The bus's time is the recording's.
    let (first, last) = (frames[0].timestamp, frames[frames.len() - 1].timestamp);
    let soon = last.after(Span::from_seconds(0.05));
    assert!(live.iter().all(|frame| frame.timestamp >= first && frame.timestamp <= soon));
}

#[test]
fn a_quiet_bus_and_a_clock_that_was_set_are_played_as_they_were_recorded() {
    let mut frames = excerpt(57.0, 66.51);
    let first = frames[0].timestamp;
    frames.retain(|frame| {
        !(61.0..63.0).contains(&(frame.timestamp.since(first).as_seconds() + 57.0))
    });
    let third = frames.len() / 3;
    for frame in &mut frames[..third] {
        frame.timestamp = frame.timestamp.after(Span::from_seconds(7200.0));
    }
    for frame in &mut frames[2 * third..] {
        frame.timestamp = frame.timestamp.after(Span::from_seconds(86_400.0));
    }
    let (live, replayed) = play_and_replay(&frames, "max");
    assert_same(&live, &replayed);
}

/// The same bus on two interfaces of one recording.
#[test]
fn of_several_interfaces_in_a_recording_one_is_played() {
    let folder = tempfile::tempdir().expect("there is room");
    let path = |name: &str| folder.path().join(name);
    let frames = excerpt(59.5, 61.51);
    write(&path("first.log"), "can0", &frames);
    write(&path("second.log"), "can1", &frames);
    let lines = |name: &str| std::fs::read_to_string(path(name)).expect("it was written");
    let both: String = lines("first.log")
        .lines()
        .zip(lines("second.log").lines())
        .flat_map(|(first, second)| [first, "\n", second, "\n"].map(str::to_owned))
        .collect();
    std::fs::write(path("both.log"), both).expect("the folder is ours");
    let config = configuration(folder.path(), "virtual");
    let play = |log: &str, record: &str, more: &[&str]| {
        let (log, record) = (path(log), path(record));
        let run = ["run", "--config", plain(&config), "--play", plain(&log), "--speed", "max"];
        tertius(&[&run[..], &["--record", plain(&record)], more].concat())
    };
    let output = play("both.log", "neither.log", &[]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success(), "nobody can tell which is meant");
    assert!(
        said.contains("can0") && said.contains("can1") && said.contains("--interface"),
        "{said}"
    );
    let output = play("both.log", "one.log", &["--interface", "can1"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(play("first.log", "alone.log", &[]).status.success());
    assert_eq!(lines("one.log"), lines("alone.log"));
    assert!(lines("one.log").contains("2D1#"), "the step was found");
}

#[test]
fn its_speed_changes_nothing() {
    let frames = excerpt(59.5, 61.01);
    let started = std::time::Instant::now();
    let (live, replayed) = play_and_replay(&frames, "5");
    assert!(started.elapsed().as_secs_f64() > 0.3, "it kept to its time");
    assert_same(&live, &replayed);
}

#[test]
fn a_wrong_call_ends_with_2_and_says_what_was_expected() {
    let folder = tempfile::tempdir().expect("there is room");
    let log = folder.path().join("bus.log");
    write(&log, "can0", &excerpt(57.0, 57.1));
    let before = read(&log);
    let config = configuration(folder.path(), "virtual");
    let (log, config) = (plain(&log), plain(&config));
    let real = top().join("tests/recordings/e-type.toml");
    for (arguments, expected) in [
        (&["--config", config] as &[&str], "on which nothing else sends"),
        (&["--config", plain(&real), "--play", log], "bus.interface is \"can0\""),
        (&["--config", config, "--play", "no.log"], "cannot open the recording no.log"),
        (&["--config", config, "--play", log, "--speed", "0"], "or max"),
        (&["--config", config, "--play", log, "--record", log], "name another file"),
        (&["--config", config, "--record", "x.log"], "--play"),
    ] {
        let output = tertius(&[&["run"], arguments].concat());
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
        assert!(told.contains(expected), "{arguments:?}: {told}");
    }
    assert_eq!(read(Path::new(log)), before, "the recording was harmed");
}

/// Whoever asks for what this program has not gets no gateway that lacks it.
#[cfg(not(feature = "opcua"))]
#[test]
fn a_program_without_opc_ua_says_how_to_build_one_with_it() {
    let folder = tempfile::tempdir().expect("there is room");
    let config = configuration(folder.path(), "can0");
    let with = |listen: &str| {
        tertius(&["run", "--config", plain(&config), "--set", &format!("opcua.listen={listen}")])
    };
    let output = with("127.0.0.1:4840");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    for part in ["opcua.listen", "127.0.0.1:4840", "built without", "--features opcua"] {
        assert!(said.contains(part), "{part} in {said}");
    }
    let set = "opcua.listen=127.0.0.1:4840";
    let checked = tertius(&["check", plain(&config), "--set", set]);
    let said = String::from_utf8_lossy(&checked.stdout);
    assert!(said.contains("worth a look") && said.contains("--features opcua"), "{said}");
    let output = with("4840");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("must be ADDRESS:PORT"), "{said}");
}
