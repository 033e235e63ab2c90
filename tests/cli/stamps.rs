//! Time stamps that cannot be those of the frames, and frames that were written late.

use tertius_testing::support::{
    E_TYPE, HANGING_LOAD, Run, Scratch, between, recorded, replay, seconds, tertius,
};

/// Eight seconds of a hanging load.
fn hanging_load() -> String {
    recorded("hanging-load.log.gz").split_inclusive('\n').take(800).collect()
}

/// The same lines with other time stamps, by the number of the line.
fn stamped(log: &str, stamp: impl Fn(usize, &str) -> String) -> String {
    let line = |(n, line): (usize, &str)| {
        let (_, rest) = line.split_once(") ").expect("a candump line");
        format!("({}) {rest}\n", stamp(n, line))
    };
    log.lines().enumerate().map(line).collect()
}

/// Nothing was judged for the reason that is told, and nothing looks as if all were well.
#[track_caller]
fn is_unjudged(log: &str, words: &[&str]) {
    let page = tertius(&["replay", log, "--config", HANGING_LOAD], b"").failed(1, words).stdout;
    assert!(page.contains("NOTHING WAS JUDGED"), "{page}");
    assert!(!page.contains("No incident"), "{page}");
    let Run { code, stdout, .. } = replay(&[log], HANGING_LOAD, &[]);
    let last: serde_json::Value =
        serde_json::from_str(stdout.lines().last().expect("a summary")).expect("JSON");
    assert_eq!((code, &last["judged"]), (Some(1), &false.into()));
}

#[test]
fn a_recording_without_time_stamps_says_nothing_about_the_machine() {
    let scratch = Scratch::new();
    let log = hanging_load();
    replay(&[&scratch.write("right.log", &log)], HANGING_LOAD, &[]).ok();
    for stamp in ["0000000000.000000", "1700000000.000000"] {
        let alike = scratch.write("alike.log", stamped(&log, |_, _| stamp.to_owned()));
        is_unjudged(&alike, &["every frame has the same time stamp", "record without -H"]);
    }
}

#[test]
fn time_stamps_since_the_frame_before_are_told_and_read_on_request() {
    let scratch = Scratch::new();
    let log = hanging_load();
    let times: Vec<f64> = log.lines().map(seconds).collect();
    let delta = |n: usize, _: &str| {
        let step = if n == 0 { 0.0 } else { times[n] - times[n - 1] };
        format!("{step:017.6}")
    };
    let deltas = scratch.write("deltas.log", stamped(&log, delta));
    is_unjudged(&deltas, &["an earlier time stamp than a frame ahead", "--time-stamps delta"]);
    let read = replay(&[&deltas], HANGING_LOAD, &["--time-stamps", "delta"]).ok();
    let right = replay(&[&scratch.write("right.log", &log)], HANGING_LOAD, &[]).ok();
    assert_eq!(read.summary()["cycles"], right.summary()["cycles"]);
    assert_eq!(read.incidents().len(), right.incidents().len());
}

/// Whatever the reason: too few cycles for an observer are no sign of health.
#[test]
fn a_recording_in_which_no_observer_judged_is_not_judged() {
    let scratch = Scratch::new();
    let log: String = hanging_load().split_inclusive('\n').take(60).collect();
    is_unjudged(&scratch.write("short.log", log), &["too few for the observers to settle"]);
}

/// Of all cylinders, C2 was written every 0.4 s.
#[test]
fn what_a_logger_wrote_late_is_judged_as_if_it_were_sorted() {
    let scratch = Scratch::new();
    let mut lines: Vec<String> = between(&recorded("e-type-healthy.log.zst"), 160.0, 180.0)
        .split_inclusive('\n')
        .map(str::to_owned)
        .collect();
    let sorted = scratch.write("sorted.log", lines.concat());
    let written = |line: &String| {
        let at = seconds(line);
        let late = line.contains(" 19");
        let at = if late { ((at / 0.4).floor() + 1.0) * 0.4 } else { at };
        (at * 1e6) as i64
    };
    lines.sort_by_key(written);
    let late = scratch.write("late.log", lines.concat());
    assert_ne!(scratch.read("late.log"), scratch.read("sorted.log"));
    let right = replay(&[&sorted], E_TYPE, &[]).ok();
    let found = replay(&[&late], E_TYPE, &[]).ok();
    assert_eq!((found.incidents(), found.summary()), (right.incidents(), right.summary()));
    let page = tertius(&["replay", &late, "--config", E_TYPE], b"").ok().stdout;
    assert!(page.contains("No incident") && page.contains("wrote late (sorted)"), "{page}");
    let piped = tertius(
        &["replay", "-", "--config", E_TYPE, "--format", "jsonl"],
        scratch.read("late.log").as_bytes(),
    );
    assert_eq!(piped.ok().incidents(), Vec::<serde_json::Value>::new());
    let told = tertius(&["convert", &late, &scratch.path("again.log")], b"").ok().stderr;
    assert!(told.contains("written late by the logger") && told.contains("sorted"), "{told}");
    assert_eq!(scratch.read("again.log"), scratch.read("sorted.log"));
}
