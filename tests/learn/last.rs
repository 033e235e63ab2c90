//! The last transducer of a cylinder: its studies in `evaluate`, and its drifts by what was learnt.

use crate::yard::{Yard, tertius};
use serde_json::Value;
use tertius::alarm::{Level, Warning};
use tertius::config::design;
use tertius::dbc::{Database, text};
use tertius::estimate::Estimate;
use tertius::evaluate::{Grade, Lessons, ProcessMachine, Stand};
use tertius::inject::{Fault, place};
use tertius::monitor::{Estimates, Monitor, MonitorDesign, Sink};
use tertius::simulator::{EPOCH, Options, Tables};
use tertius::time::Timestamp;
use tertius::verdict::Suspect;
use tertius_testing::support::{self, top};

const CONFIG: &str = "config/e-type-simulated.toml";

#[test]
fn its_studies_give_the_same_bytes_on_any_number_of_threads() {
    let run = |threads: &str, seed: &str| {
        let rows = [
            "--rows",
            "last,single,accommodate",
            "--sea",
            "2.5,8",
            "--trials",
            "1",
            "--hours",
            "0.01",
        ];
        let call = ["evaluate", "--config", CONFIG, "--threads", threads, "--seed", seed];
        support::tertius(&[&call[..], &rows].concat(), b"").ok().stdout
    };
    let one = run("1", "3");
    assert_eq!(one, run("2", "3"));
    assert_eq!(one.lines().filter(|line| line.contains("drift 100 mm/s")).count(), 12 + 4, "{one}");
    for word in
        ["noise 6 σ", "broken wire", "absent", "10 mm off", "last one named", "then drift 0.1 mm/s"]
    {
        assert!(one.contains(word), "{word:?} is not in\n{one}");
    }
}

/// Injects `faults` into a recording, and asserts that cylinders 1 to 4 have their `transducer` named within so many seconds
/// after their faults `begin`, and the others not at all.
fn assert_found(
    (yard, config): (&Yard, &str),
    faults: &[String],
    transducer: &str,
    begin: fn(u32) -> f64,
    within: f64,
) {
    let log = yard.simulate("healthy.log", ["1.5,7", "32"], 520, &[]);
    let faults: Vec<_> = faults.iter().map(String::as_str).collect();
    let log = yard.inject(&log, "faulty.log", &faults);
    let run = tertius(&["replay", &log, "--config", config, "--format", "jsonl"]);
    let records = run.stdout.lines().map(|it| serde_json::from_str::<Value>(it).expect("JSON"));
    let warnings: Vec<_> = records
        .filter(|it| it["type"] == "warning" && it["state"] == "raised")
        .filter(|it| it["suspect"] == transducer)
        .collect();
    for n in 1..=6 {
        let first = warnings.iter().find(|it| it["cylinder"] == n);
        let after = first.map(|it| it["t"].as_f64().expect("a time") - begin(n));
        let is_right = match after {
            Some(after) => n <= 4 && (0.0..within).contains(&after),
            None => n > 4,
        };
        assert!(is_right, "cylinder {n}: {after:?} s");
    }
}

/// An observer follows a drift: those of 40 mm/s went on until the reading left its range.
#[test]
fn a_drift_of_the_last_transducer_is_found_by_dead_reckoning() {
    let yard = Yard::new();
    let config = yard.path("config.toml");
    let lesson = yard.simulate("lesson.log", ["1.5,7", "31"], 700, &[]);
    tertius(&["calibrate", &lesson, "--config", &config, "--into", &config]).ok();
    let begin = |n: u32| 330.0 + 10.0 * f64::from(n);
    let lost = |n: u32| format!("loss,cylinder={n},sensor=c1,at={},probability=1", begin(n) - 25.0);
    let drift = |n: u32| format!("drift,cylinder={n},sensor=c2,at={},rate=0.04", begin(n));
    let faults: Vec<_> = (1..=6).map(lost).chain((1..=4).map(drift)).collect();
    assert_found((&yard, &config), &faults, "c2", begin, 3.0);
}

/// As of a supply that C1 and C2 share: their difference is zero, and both observers follow.
#[test]
fn a_drift_that_both_have_in_common_is_found_by_dead_reckoning() {
    let yard = Yard::new();
    let config = yard.path("config.toml");
    let lesson = yard.simulate("lesson.log", ["1.5,7", "31"], 700, &[]);
    tertius(&["calibrate", &lesson, "--config", &config, "--into", &config]).ok();
    let begin = |n: u32| 330.0 + 10.0 * f64::from(n);
    let drifts = |n: u32| {
        ["c1", "c2"]
            .map(|sensor| format!("drift,cylinder={n},sensor={sensor},at={},rate=0.015", begin(n)))
    };
    let faults: Vec<_> = (1..=4).flat_map(drifts).collect();
    assert_found((&yard, &config), &faults, "process", begin, 10.0);
}

/// FDE1 and FDE2 are quiet again after a second. In the loop the controller answers by a command beyond the lesson's.
#[test]
fn a_step_that_both_have_in_common_stands() {
    let yard = Yard::new();
    let config = yard.path("config.toml");
    let lesson = yard.simulate("lesson.log", ["1.5,7", "31"], 700, &[]);
    tertius(&["calibrate", &lesson, "--config", &config, "--into", &config]).ok();
    let text = yard.read("config.toml");
    let limits = "\n[fde]\ncommand = 0.8\ncommand_change = 0.03 ";
    assert_eq!(text.matches("\n[fde] ").count(), 1, "{text}");
    let config = yard.0.write("limited.toml", text.replace("\n[fde] ", limits));
    let steps = |n: u32| {
        ["c1", "c2"].map(|sensor| {
            format!("step,cylinder={n},sensor={sensor},at={},size=0.025", 330 + 10 * n)
        })
    };
    let faults: Vec<_> = (1..=4).flat_map(steps).collect();
    let faults = faults.iter().flat_map(|it| ["--fault", it]).collect::<Vec<_>>();
    for more in [&["--force"][..], &["--force", "--in-loop"]] {
        let log = yard.simulate("faulty.log", ["1.5,7", "32"], 420, &[&faults[..], more].concat());
        let run = tertius(&["replay", &log, "--config", &config, "--format", "jsonl"]).ok();
        let records = run.stdout.lines().map(|it| serde_json::from_str::<Value>(it).expect("JSON"));
        let warnings: Vec<_> =
            records.filter(|it| it["type"] == "warning" && it["detector"] == "fde1").collect();
        for n in 1..=6 {
            let newest = warnings.iter().rfind(|it| it["cylinder"] == n);
            let is = |key: &str, word: &str| newest.is_some_and(|it| it[key] == word);
            let stands =
                is("suspect", "process") && is("fault", "abrupt") && !is("state", "cleared");
            let expected = (n <= 4, n <= 4);
            assert_eq!((newest.is_some(), stands), expected, "{more:?}, {n}: {newest:?}");
        }
    }
}

/// An observer that has followed a step is quiet, and is no evidence. The way of the rod is, where it shows the step back.
#[test]
fn the_latch_ends_when_the_rods_way_shows_that_the_reading_stepped_back() {
    let yard = Yard::new();
    let config = yard.path("config.toml");
    let lesson = yard.simulate("lesson.log", ["1.5,7", "31"], 700, &[]);
    tertius(&["calibrate", &lesson, "--config", &config, "--into", &config]).ok();
    let begin = |n: u32| 330.0 + 10.0 * f64::from(n);
    let end = |n: u32| begin(n) + 30.0;
    let faults = |n: u32| {
        let lost = format!("loss,cylinder={n},sensor=c1,at={},probability=1", begin(n) - 25.0);
        let fault = format!("step,cylinder={n},sensor=c2,at={},size=0.025", begin(n));
        let step = format!("{fault},until={}", end(n));
        // Of cylinder 5 it comes back by half, and of cylinder 6 not at all.
        let half = format!("step,cylinder=5,sensor=c2,at={},size=0.0125", end(5));
        // Of cylinder 4 both are off alike before C1 is lost, from where C2 steps on.
        let alike = ["c1", "c2"].map(|it| format!("step,cylinder=4,sensor={it},at=330,size=0.02"));
        match n {
            4 => [&alike[..], &[lost, step]].concat(),
            5 => vec![lost, step, half],
            6 => vec![lost, fault],
            _ => vec![lost, step],
        }
    };
    let log = yard.simulate("healthy.log", ["1.5,7", "32"], 520, &[]);
    let faults: Vec<_> = (1..=6).flat_map(faults).collect();
    let faults: Vec<_> = faults.iter().map(String::as_str).collect();
    let log = yard.inject(&log, "faulty.log", &faults);
    let run = tertius(&["replay", &log, "--config", &config, "--format", "jsonl"]);
    let records = run.stdout.lines().map(|it| serde_json::from_str::<Value>(it).expect("JSON"));
    let warnings: Vec<_> = records.filter(|it| it["type"] == "warning").collect();
    let of_fde1 = |it: &&Value| it["cylinder"] == 4 && it["detector"] == "fde1";
    let alike = warnings.iter().rfind(of_fde1).expect("both jumped");
    assert_eq!([&alike["by"], &alike["suspect"]], ["both-jump", "process"], "{alike}");
    assert_ne!(alike["state"], "cleared", "C2 is back where both are off");
    for n in 1..=6 {
        let mut own = warnings.iter().filter(|it| it["cylinder"] == n && it["suspect"] == "c2");
        let latched = own.any(|it| it["level"] == "black");
        let cleared = own.find(|it| it["state"] == "cleared").map(|it| it["t"].as_f64());
        let after = cleared.map(|it| it.expect("a time") - end(n));
        let is_right = match after {
            Some(after) => n <= 4 && (0.3..1.5).contains(&after),
            None => n > 4,
        };
        assert!(latched && is_right, "cylinder {n}: {latched}, {after:?} s");
        // Dead reckoning has seen both steps, too.
        let again = if n <= 4 { own.next() } else { None };
        assert_eq!(again, None, "cylinder {n}");
    }
}

/// Without a second transducer no drive is learnt, and the model itself gives the velocity.
#[test]
fn a_fast_drift_of_an_only_transducer_is_found_by_the_model() {
    let yard = Yard::new();
    let text = yard.read("config.toml");
    let alone = text.lines().filter(|it| !it.starts_with("c2")).map(|it| format!("{it}\n"));
    let config = yard.0.write("alone.toml", alone.collect::<String>());
    let lesson = yard.simulate("lesson.log", ["1.5,7", "31"], 700, &[]);
    tertius(&["identify", &lesson, "--config", &config, "--into", &config]).ok();
    let begin = |n: u32| 380.0 + 10.0 * f64::from(n);
    let drift = |n: u32| format!("drift,cylinder={n},sensor=c1,at={},rate=0.045", begin(n));
    let faults: Vec<_> = (1..=4).map(drift).collect();
    assert_found((&yard, &config), &faults, "c1", begin, 12.0);
}

/// The warnings, and when each cylinder had a valid estimate, s.
#[derive(Default)]
struct Heard {
    warnings: Vec<Warning>,
    valid: Vec<(u8, f64)>,
}

impl Sink for Heard {
    fn warning(&mut self, warning: &Warning) {
        self.warnings.push(*warning);
    }

    fn estimate(&mut self, at: Timestamp, cylinder: u8, estimate: Option<&Estimate>) {
        if estimate.is_some_and(|it| it.valid) {
            self.valid.push((cylinder, at.since(EPOCH).as_seconds()));
        }
    }
}

/// Thresholds, detectors and the relations of the hydraulics are the machine's own. Nothing that moves is left to compare.
#[test]
fn both_that_freeze_at_once_on_a_commissioned_machine_are_both_named() {
    let loaded = tertius::config::load(&top().join(CONFIG)).expect("it ships");
    let database = Database::parse(&text::from_bytes(&loaded.dbc_text)).expect("it ships");
    let plant = std::fs::read_to_string(top().join("config/e-type-hydraulic-plant.toml"));
    let tables = Tables::parse(&plant.expect("it ships")).expect("it ships");
    let design = design::judging(&loaded.settings, &database).expect("they fit");
    let stand = Stand::new(&tables, &loaded.settings, &database, &design);
    let (machine, sea) = (ProcessMachine { grade: Grade::Fine, lag: 0.06 }, [2.5, 8.0]);
    let lessons = Lessons { calibration: 0.25, level: 0.25 };
    let learnt = stand.commission(machine, false, &[sea], [1, 2], lessons).expect("it teaches");
    let is_taught = learnt.design.cylinders.iter().all(|it| {
        it.sequential.is_some() && it.process.as_ref().is_some_and(|it| it.flow.is_some())
    });
    assert!(is_taught);
    for seed in [5, 6] {
        let begin = |n: u8| 120.0 + f64::from(n);
        let freeze = |n: u8, sensor: &str| {
            let text = format!("freeze,cylinder={n},sensor={sensor},at={}", begin(n));
            let fault = Fault::parse(&text).expect(&text);
            place(&fault, &loaded.settings, &database).expect("it has a place")
        };
        let faults = (1..=3).flat_map(|n| ["c1", "c2"].map(|sensor| freeze(n, sensor))).collect();
        let options = Options { seed, sea: Some(sea), faults, ..Options::default() };
        let mut simulator = stand.steady(Grade::Fine, &options).expect("it can be simulated");
        let told = MonitorDesign { estimates: Estimates::Computed, ..learnt.design.clone() };
        let (mut monitor, mut heard) = (Monitor::new(told), Heard::default());
        for _ in 0..50 * 150 {
            simulator.step(&mut |frame| monitor.take(frame, &mut heard));
        }
        monitor.finish(&mut heard);
        for n in 1..=6 {
            let valid = || heard.valid.iter().filter(|it| it.0 == n).map(|it| it.1);
            assert!(valid().any(|at| (100.0..120.0).contains(&at)), "{seed}, {n}");
            let black = [Suspect::C1, Suspect::C2].map(|suspect| {
                let of_it = |it: &&Warning| {
                    (it.cylinder, it.finding.suspect) == (n, suspect)
                        && it.finding.level == Level::Black
                };
                let first = heard.warnings.iter().find(of_it);
                first.map(|it| it.timestamp.since(EPOCH).as_seconds() - begin(n))
            });
            if n > 3 {
                assert_eq!(black, [None; 2], "{seed}, {n}");
                continue;
            }
            let named = black.map(|it| it.unwrap_or_else(|| panic!("{seed}, {n}: {black:?}")));
            assert!(named.iter().all(|it| (0.0..6.0).contains(it)), "{seed}, {n}: {named:?}");
            let both = begin(n) + named[0].max(named[1]);
            assert_eq!(valid().find(|at| *at > both), None, "{seed}, {n}: valid after {both}");
        }
    }
}
