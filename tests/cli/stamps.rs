//! Time stamps that cannot be those of the frames.

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

/// Every 0.4 s what was recorded with odd numbers is written after the rest.
#[test]
fn frames_that_a_logger_wrote_late_are_told_with_what_puts_them_in_order() {
    let scratch = Scratch::new();
    let log = hanging_load();
    let lines: Vec<&str> = log.split_inclusive('\n').collect();
    let pieces = lines.chunks(40).flat_map(|piece| {
        let of = |odd: usize| piece.iter().copied().skip(odd).step_by(2);
        of(0).chain(of(1)).collect::<Vec<&str>>()
    });
    let unsorted = scratch.write("unsorted.log", pieces.collect::<String>());
    let told = &["the time stamps go back", "sort -s -k 1,1 all.log > sorted.log"];
    is_unjudged(&unsorted, told);
    // Two seconds of it, in which it happens four times.
    let brief: String = scratch.read("unsorted.log").split_inclusive('\n').take(200).collect();
    is_unjudged(&scratch.write("brief.log", brief), told);
    let converted = tertius(&["convert", &unsorted, &scratch.path("all.log")], b"").ok();
    let told = "the time stamps go back ";
    assert!(converted.stderr.contains(told), "{}", converted.stderr);
    let sound = scratch.write("sound.log", log);
    let converted = tertius(&["convert", &sound, &scratch.path("same.log")], b"").ok();
    assert!(!converted.stderr.contains(told), "{}", converted.stderr);
}

/// Whatever the reason: too few cycles for an observer are no sign of health.
#[test]
fn a_recording_in_which_no_observer_judged_is_not_judged() {
    let scratch = Scratch::new();
    let log: String = hanging_load().split_inclusive('\n').take(60).collect();
    is_unjudged(&scratch.write("short.log", log), &["too few for the observers to settle"]);
}

/// Each begins again in the middle: what follows is judged, nothing is said of the cylinder, and it is told what it was.
#[test]
fn counters_of_time_stamps_that_began_again_are_told_and_no_fault() {
    let scratch = Scratch::new();
    let log = between(&recorded("e-type-healthy.log.zst"), 160.0, 172.0);
    let times: Vec<f64> = log.lines().map(seconds).collect();
    let (first, middle) = (times[0], times[times.len() / 2]);
    for (wrap, coarse, words) in [
        (4294.967296, 1e-6, "a counter of 32 bits of µs began again once"),
        (65.536, 1e-3, "a counter of 16 bits of ms began again once"),
        (60.0, 1e-3, "the counter of an SLCAN adapter began again once"),
        (86_400.0, 1e-6, "a time of day began again once"),
        (4_294_967.296, 1e-3, "a counter of 32 bits of ms began again once"),
        (4.294967296, 1e-6, "a counter of 32 bits of ns began again once"),
        (7.25, 1e-6, ""),
    ] {
        for begin in [1_700_000_000.0, wrap + first - middle] {
            let stamp = |n: usize, _: &str| {
                let back = if times[n] >= middle { wrap } else { 0.0 };
                let at = (begin + times[n] - first - back).max(0.0);
                format!("{:017.6}", (at / coarse).round() * coarse)
            };
            let wrapped = scratch.write("wrapped.log", stamped(&log, stamp));
            let run = replay(&[&wrapped], E_TYPE, &[]).ok();
            let summary = run.summary();
            assert_eq!(summary["judged"], true, "{wrap} s");
            assert_eq!((&summary["time_jumps"], &summary["backwards"]), (&1.into(), &1.into()));
            assert!(run.incidents().is_empty() && run.warnings().is_empty(), "{wrap} s");
            let remarks = summary["remarks"].to_string();
            assert_eq!(remarks.contains("began again"), !words.is_empty(), "{wrap} s: {remarks}");
            assert!(remarks.contains(words), "{wrap} s: {remarks}");
        }
    }
}
