//! The studies of the last transducer in `evaluate`.

use crate::yard::{Yard, tertius};
use serde_json::Value;
use tertius_testing::support;

const CONFIG: &str = "config/e-type-simulated.toml";

#[test]
fn both_studies_give_the_same_bytes_on_any_number_of_threads() {
    let run = |threads: &str, seed: &str| {
        let rows = ["--rows", "last,single", "--sea", "2.5,8", "--trials", "1", "--hours", "0.01"];
        let call = ["evaluate", "--config", CONFIG, "--threads", threads, "--seed", seed];
        support::tertius(&[&call[..], &rows].concat(), b"").ok().stdout
    };
    let one = run("1", "3");
    assert_eq!(one, run("2", "3"));
    assert_eq!(one.lines().filter(|line| line.contains("drift 100 mm/s")).count(), 12 + 4, "{one}");
    for word in ["noise 6 σ", "broken wire", "absent", "10 mm off", "last one named"] {
        assert!(one.contains(word), "{word:?} is not in\n{one}");
    }
}

/// Where the last transducer of each cylinder was named first, s since the first frame.
fn named(log: &str, config: &str, transducer: &str) -> Vec<Option<f64>> {
    let run = tertius(&["replay", log, "--config", config, "--format", "jsonl"]);
    let records = run.stdout.lines().map(|it| serde_json::from_str::<Value>(it).expect("JSON"));
    let warnings: Vec<_> = records
        .filter(|it| it["type"] == "warning" && it["suspect"] == transducer)
        .filter(|it| it["state"] == "raised")
        .collect();
    let of = |n: u64| warnings.iter().find(|it| it["cylinder"] == n);
    (1..=6).map(|n| Some(of(n)?["t"].as_f64().expect("a time"))).collect()
}

/// An observer follows a drift: those of 40 mm/s went on until the reading left its range.
#[test]
fn a_drift_of_the_last_transducer_is_found_by_dead_reckoning() {
    let yard = Yard::new();
    let config = yard.path("config.toml");
    let lesson = yard.simulate("lesson.log", ["1.5,7", "31"], 700, &[]);
    tertius(&["calibrate", &lesson, "--config", &config, "--into", &config]).ok();
    let log = yard.simulate("healthy.log", ["1.5,7", "32"], 520, &[]);
    let begin = |n: u32| 330.0 + 10.0 * f64::from(n);
    let lost = |n: u32| format!("loss,cylinder={n},sensor=c1,at={},probability=1", begin(n) - 25.0);
    let drift = |n: u32| format!("drift,cylinder={n},sensor=c2,at={},rate=0.04", begin(n));
    let faults: Vec<_> = (1..=6).map(lost).chain((1..=4).map(drift)).collect();
    let faults: Vec<_> = faults.iter().map(String::as_str).collect();
    let found = named(&yard.inject(&log, "faulty.log", &faults), &config, "c2");
    for (n, at) in (1..=6).zip(&found) {
        let after = at.map(|at| at - begin(n));
        let is_right = if n <= 4 {
            after.is_some_and(|after| (0.0..3.0).contains(&after))
        } else {
            after.is_none()
        };
        assert!(is_right, "cylinder {n}: {after:?} s");
    }
}

/// Without a second transducer no drive is learnt, and the model itself is reckoned by.
#[test]
fn a_fast_drift_of_an_only_transducer_is_found_by_the_model() {
    let yard = Yard::new();
    let text = yard.read("config.toml");
    let alone = text.lines().filter(|it| !it.starts_with("c2")).map(|it| format!("{it}\n"));
    let config = yard.0.write("alone.toml", alone.collect::<String>());
    let lesson = yard.simulate("lesson.log", ["1.5,7", "31"], 700, &[]);
    tertius(&["identify", &lesson, "--config", &config, "--into", &config]).ok();
    let log = yard.simulate("healthy.log", ["1.5,7", "32"], 520, &[]);
    let drift = |n: u32| format!("drift,cylinder={n},sensor=c1,at={},rate=0.045", 380 + 10 * n);
    let faults: Vec<_> = (1..=4).map(drift).collect();
    let faults: Vec<_> = faults.iter().map(String::as_str).collect();
    let found = named(&yard.inject(&log, "faulty.log", &faults), &config, "c1");
    for (n, at) in (1..=6).zip(&found) {
        let after = at.map(|at| at - f64::from(380 + 10 * n));
        let is_right = if n <= 4 {
            after.is_some_and(|after| (0.0..12.0).contains(&after))
        } else {
            after.is_none()
        };
        assert!(is_right, "cylinder {n}: {after:?} s");
    }
}
