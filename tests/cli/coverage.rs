//! For how long the sequential detectors knew enough to say something, and why not.

use serde_json::Value;
use tertius::sequential::Unknown;
use tertius_testing::support::{self, Scratch};

const CONFIG: &str = "tests/recordings/e-type-sequential.toml";

/// Frames of C2 of cylinder 2.
const LOST: &str = " 192#";

/// For so long they are gone while the platform is engaged, s.
const GONE: [f64; 2] = [200.0, 220.0];

/// Of a cylinder: judged, and unknown by [`Unknown::ALL`], s.
fn coverage(summary: &Value, cylinder: usize) -> (f64, [f64; 4]) {
    let line = &summary["cylinders"][cylinder - 1]["sequential"];
    let unknown = Unknown::ALL.map(|why| line["unknown_seconds"][why.name()].as_f64());
    let judged = line["judged_seconds"].as_f64().expect("it has a detector");
    (judged, unknown.map(|seconds| seconds.expect("every reason is there")))
}

/// The configuration in which cylinder 3 was calibrated on one side of its stroke only.
fn half_calibrated() -> String {
    let text = std::fs::read_to_string(support::top().join(CONFIG)).expect("it is there");
    let dbc = support::top().join("dbc/e-type.dbc");
    let text = text.replace("../../dbc/e-type.dbc", &dbc.display().to_string());
    let mut tables: Vec<String> = text.split("[[cylinder]]").map(str::to_owned).collect();
    let (head, rest) = tables[3].split_once("\nsamples = [").expect("it has a profile");
    let (samples, tail) = rest.split_once(']').expect("it ends");
    let count = samples.split(',').count();
    let seen = samples.split(',').enumerate();
    let seen: Vec<&str> = seen.map(|(k, it)| if k < count / 2 { "0" } else { it.trim() }).collect();
    tables[3] = format!("{head}\nsamples = [{}]{tail}", seen.join(", "));
    tables.join("[[cylinder]]")
}

#[test]
fn a_replay_says_for_how_long_a_sequential_detector_knew_nothing_and_why() {
    let scratch = Scratch::new();
    let whole = support::recorded("e-type-healthy.log.zst");
    let begin = support::seconds(whole.lines().next().expect("there are frames"));
    let gone = |line: &&str| {
        let t = support::seconds(line) - begin;
        !(line.contains(LOST) && (GONE[0]..GONE[1]).contains(&t))
    };
    let log: Vec<&str> = whole.lines().filter(gone).collect();
    let log = scratch.write("lost.log", log.join("\n") + "\n");
    let config = scratch.write("half.toml", half_calibrated());
    let page = scratch.path("page.html");
    let run = support::replay(&[&log], &config, &["--report", &page]).ok();
    let summary = run.summary();
    let sound = support::replay(&[&support::recording("e-type-healthy.log.zst")], CONFIG, &[]).ok();
    let sound = sound.summary();
    let duration = summary["duration"].as_f64().expect("a number");
    let gated = summary["cylinders"][0]["gated"].as_u64().expect("a count") as f64 * 0.02;
    for cylinder in 1..=6 {
        let (judged, [unmonitored, unread, uncalibrated, baseline]) = coverage(&summary, cylinder);
        let sum = judged + unmonitored + unread + uncalibrated + baseline;
        assert!((sum - duration).abs() < 0.1, "cylinder {cylinder}: {sum} of {duration} s");
        assert!((unmonitored - gated).abs() < 1.5, "{unmonitored} of {gated} s, and what settles");
        assert!((0.1..30.0).contains(&baseline), "cylinder {cylinder}: {baseline} s");
        assert!(judged > 60.0, "cylinder {cylinder}: {judged} s");
        let (before, [_, read, calibrated, _]) = coverage(&sound, cylinder);
        let lost = if cylinder == 2 { GONE[1] - GONE[0] } else { 0.0 };
        assert!((lost..lost + 1.0).contains(&(unread - read)), "cylinder {cylinder}: {unread} s");
        match cylinder {
            3 => assert!(uncalibrated > calibrated + 40.0, "{uncalibrated} and {calibrated} s"),
            2 => assert!(judged < before - lost / 2.0, "{judged} of {before} s"),
            _ => assert_eq!((judged, uncalibrated), (before, calibrated), "cylinder {cylinder}"),
        }
    }
    let (_, [.., uncalibrated, _]) = coverage(&summary, 3);
    let told = format!("{uncalibrated:.1} s");
    let html = scratch.read("page.html");
    assert!(html.contains(&told) && html.contains("not calibrated"), "the page has {told}");
    let text = support::tertius(&["replay", &log, "--config", &config], b"").ok().stdout;
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        line.contains("The sequential detectors judged 46.7 % of the time; not monitored 43.3 %"),
        "{text}"
    );
    assert!(line.contains("Not judged: cylinder 2's C2 from"), "{text}");
}

#[test]
fn without_a_detector_nothing_is_said_of_one() {
    let log = support::recording("e-type-coarse.log.zst");
    let config = "tests/recordings/e-type.toml";
    let run = support::replay(&[&log], config, &[]).ok();
    assert!(run.summary()["cylinders"][0].get("sequential").is_none());
    let text = support::tertius(&["replay", &log, "--config", config], b"").ok().stdout;
    assert!(!text.contains("sequential detectors"), "{text}");
}
