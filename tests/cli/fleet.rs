//! `fleet plan`: what has to be replayed, in order, and what is refused.

use serde_json::Value;
use std::fs;
use tertius_testing::support::{E_TYPE, Run, Scratch, between, recorded, tertius, top};

/// Three parts of a recording, whose names are in another order than their times.
fn parts(scratch: &Scratch) -> [String; 3] {
    let log = recorded("e-type-healthy.log.zst");
    fs::create_dir(scratch.path("a")).expect("ours");
    [("a/2.log", 30.0), ("a/1.log", 33.0), ("a/0.log", 36.0)]
        .map(|(name, begin)| scratch.write(name, between(&log, begin, begin + 3.0)))
}

fn entry(name: &str, recordings: &str, more: &str) -> String {
    let config = top().join(E_TYPE).display().to_string();
    format!(
        "[[machine]]\nname = {name:?}\nconfig = {config:?}\nrecordings = {recordings}\n{more}\n"
    )
}

fn plan(scratch: &Scratch, fleet: &str, options: &[&str]) -> Run {
    let fleet = scratch.write("fleet.toml", fleet);
    tertius(&[&["fleet", "plan", &fleet], options].concat(), b"")
}

#[test]
fn jobs_are_in_the_order_of_time_and_can_be_called() {
    let scratch = Scratch::new();
    let [first, second, third] = parts(&scratch);
    let fleet = entry("A1", "[\"a/?.log\", \"a\"]", "") + &entry("B", &format!("[{third:?}]"), "");
    for options in [&["--format", "jsonl"][..], &["--format", "jsonl", "--quick"]] {
        let run = plan(&scratch, &fleet, options).ok();
        let jobs = run.lines();
        let told = |key: &str| jobs.iter().map(|job| job[key].clone()).collect::<Vec<_>>();
        assert_eq!(
            told("recording"),
            [&first, &second, &third, &third].map(|it| Value::from(&**it))
        );
        assert_eq!(told("job"), [1, 2, 3, 4]);
        assert_eq!(told("index"), [1, 2, 3, 1]);
        assert_eq!(told("after"), [Value::Null, 1.into(), 2.into(), Value::Null]);
        assert_eq!(told("machine"), ["A1", "A1", "A1", "B"]);
        assert_eq!(jobs[0]["begin"], "1700000030.00021");
        assert_eq!(jobs[0]["end"].is_null(), options.len() == 3);
    }
    let run = plan(&scratch, &fleet, &["--format", "jsonl"]).ok();
    let state = scratch.path("state");
    for job in &run.lines()[..3] {
        let call: Vec<&str> =
            job["arguments"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
        // Without tables there is nothing that the machine's name is for.
        let at = call.iter().position(|it| *it == "--machine").expect("it is named");
        let call = [&call[..at], &call[at + 2..], &["--state", &state]].concat();
        // The platform is settled there, of which nothing is judged.
        let run = tertius(&call, b"").failed(1, &["never in a monitored state"]);
        assert!(run.summary()["frames"].as_u64() > Some(3000));
    }
    let people = plan(&scratch, &fleet, &[]).ok();
    for words in
        ["2 machines, 4 recordings", "2023-11-14 22:13:50.000 UTC to 2023-11-14 22:13:5", "a/2.log"]
    {
        assert!(people.stdout.contains(words), "{words} is not in\n{}", people.stdout);
    }
}

#[test]
fn what_cannot_be_replayed_in_order_is_refused_in_words() {
    let scratch = Scratch::new();
    let [first, second, _] = parts(&scratch);
    let all = "[\"a/*.log\"]";
    let refuse = |fleet: &str, options: &[&str], words: &[&str]| {
        plan(&scratch, fleet, options).failed(2, words)
    };

    refuse(
        &(entry("A1", all, "") + &entry("a1", all, "")),
        &[],
        &["two machines are called \"a1\""],
    );
    refuse(&entry("../x", all, ""), &[], &["\"../x\"", "no slash"]);
    refuse(
        &entry("A", all, "").replace(".toml", ".nothing"),
        &[],
        &["machine \"A\"", "configuration is missing", "e-type.nothing"],
    );
    refuse(&entry("A", "[]", ""), &[], &["machine \"A\"", "no recordings"]);
    refuse(&entry("A", "[\"b/*.log\"]", ""), &[], &["b/*.log", "no such recording"]);
    refuse(&entry("A", all, "speed = 1"), &[], &["fleet.toml", "unknown field `speed`"]);
    refuse(&entry("A", all, "history = \"a.dwells\""), &[], &["machine \"A\"", "stop_states"]);
    refuse(
        &entry("A", "[\"https://example.org/1.log\", \"a\"]", ""),
        &[],
        &["some of its recordings are URLs"],
    );
    refuse("", &[], &["fleet.toml", "missing field `machine`"]);
    let nothing = scratch.write("a/empty.log", "");
    refuse(&entry("A", all, ""), &[], &["empty.log"]);
    fs::remove_file(nothing).expect("ours");

    // A recording that begins before the end of another one, and the same one under two names.
    let log = recorded("e-type-healthy.log.zst");
    let over = scratch.write("a/over.log", between(&log, 31.0, 32.0));
    refuse(
        &entry("A", all, ""),
        &[],
        &["recordings overlap", "over.log begins at 1700000031.0", "a/2.log"],
    );
    plan(&scratch, &entry("A", all, ""), &["--quick"]).ok();
    fs::remove_file(over).expect("ours");
    fs::copy(&second, scratch.path("a/again.log")).expect("ours");
    for options in [&[][..], &["--quick"]] {
        refuse(&entry("A", all, ""), options, &["recordings overlap", "again.log", "1.log"]);
    }
    fs::remove_file(scratch.path("a/again.log")).expect("ours");
    assert!(first.ends_with("2.log"));
}

#[test]
fn a_machine_with_several_buses_has_recordings_of_all_of_them() {
    let scratch = Scratch::new();
    let log = scratch.path("both.log");
    let two = top().join("config/e-type-two-buses.toml").display().to_string();
    let call = ["simulate", "--config", &two, "--duration", "5", "--output", &log];
    tertius(&call, b"").ok();
    let both = scratch.read("both.log").replace("can0", "vcan7").replace("can1", "vcan3");
    scratch.write("both.log", &both);
    let entry = |recordings: &str, interface: &str| {
        let more = format!("interface = {interface:?}");
        let config = top().join(E_TYPE).display().to_string();
        entry("A", recordings, &more).replace(&config, &two)
    };
    let mapped = "first=vcan7,second=vcan3";
    let jobs = plan(&scratch, &entry("[\"both.log\"]", mapped), &["--format", "jsonl"]).ok();
    let arguments = jobs.lines()[0]["arguments"].as_array().expect("a list").clone();
    let call: Vec<&str> = arguments.iter().filter_map(Value::as_str).collect();
    let at = call.iter().position(|it| *it == "--machine").expect("it is named");
    let run = tertius(&[&call[..at], &call[at + 2..]].concat(), b"").ok();
    assert_eq!(run.summary()["frames"], both.lines().count());

    // Also where the recordings are somewhere else, and nobody looks into them.
    for recordings in ["[\"both.log\"]", "[\"https://example.org/both.log\"]"] {
        plan(&scratch, &entry(recordings, "vcan7"), &[])
            .failed(2, &["machine \"A\"", "found \"vcan7\", expected a bus", "first=can0"]);
    }
    for (name, bus) in [("one.log", "vcan7"), ("two.log", "vcan3")] {
        let of: String = both.split_inclusive('\n').filter(|line| line.contains(bus)).collect();
        scratch.write(name, of);
    }
    plan(&scratch, &entry("[\"one.log\", \"two.log\"]", mapped), &[])
        .failed(2, &["recordings overlap", "all buses of the machine: record them to one file"]);
}

#[test]
fn urls_are_passed_on_in_their_order() {
    let scratch = Scratch::new();
    let fleet = entry(
        "A",
        "[\"https://example.org/2.log\", \"s3://bucket/1.log\"]",
        "interface = \"can1\"",
    );
    let jobs = plan(&scratch, &fleet, &["--format", "jsonl"]).ok().lines();
    assert_eq!(jobs[0]["recording"], "https://example.org/2.log");
    assert_eq!((&jobs[1]["is_url"], &jobs[1]["begin"]), (&true.into(), &Value::Null));
    let call: Vec<&str> =
        jobs[1]["arguments"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
    assert_eq!(call[..2], ["replay", "-"]);
    assert!(call.windows(2).any(|pair| pair == ["--interface", "can1"]));
}
