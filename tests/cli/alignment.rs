//! A machine whose C1 and C2 nobody has calibrated is not faulty, and a fault of it is found all the same.

use serde_json::Value;
use std::fs;
use tertius_testing::support::{Run, Scratch, changed, replay, tertius, top};

const SIMULATED: &str = "config/e-type-simulated.toml";

/// The same machine without the corrections of C2.
const BARE: &str = "config/e-type.toml";

/// Half a minute of the simulated machine with these faults, replayed by `config`.
fn machine(scratch: &Scratch, config: &str, faults: &[&str], options: &[&str]) -> Run {
    let log = scratch.path("machine.log");
    let mut call = vec!["simulate", "--config", SIMULATED, "--seed", "1", "--duration", "30"];
    faults.iter().for_each(|fault| call.extend(["--fault", fault]));
    call.extend(["--output", &log]);
    tertius(&call, b"").ok();
    replay(&[&log], config, options).ok()
}

/// The remarks on what was never calibrated.
fn remarks(run: &Run) -> Vec<String> {
    let remarks = run.summary()["remarks"].clone();
    let texts = remarks.as_array().into_iter().flatten().filter_map(Value::as_str);
    texts.filter(|it| it.contains("not calibrated")).map(str::to_owned).collect()
}

#[test]
fn a_machine_without_a_calibration_is_told_to_be_calibrated_once() {
    let scratch = Scratch::new();
    let run = machine(&scratch, BARE, &[], &[]);
    assert_eq!(run.incidents(), [] as [Value; 0], "no transducer is at fault");
    let remarks = remarks(&run);
    assert_eq!(remarks.len(), 1, "{remarks:?}");
    for words in ["run `tertius commission`", "cylinders 1–6", "by up to 4.88 mm"] {
        assert!(remarks[0].contains(words), "{remarks:?}");
    }
    let warned: Vec<Value> = run.warnings();
    assert!(warned.len() >= 6, "the bus is told that C1 and C2 differ");
    assert!(
        warned.iter().all(|it| it["fault"] == "not_calibrated" && it["suspect"] == "undecided")
    );

    let log = scratch.path("machine.log");
    let text = tertius(&["replay", &log, "--config", BARE], b"").ok().stdout;
    assert!(text.contains("\nNo incident in 30.0 s."), "{text}");
    assert!(text.contains("not calibrated: run `tertius commission`"), "{text}");
    assert!(!text.contains("step"), "{text}");
}

#[test]
fn a_configuration_without_a_calibration_is_worth_a_look() {
    let text = tertius(&["check", BARE], b"").ok().stdout;
    let (_, doubts) = text.split_once("worth a look\n").expect("a doubt");
    assert!(doubts.contains("not calibrated: run `tertius commission`"), "{text}");
    assert!(doubts.contains("C1 and C2 of cylinders 1–6"), "{text}");
    let text = tertius(&["check", SIMULATED], b"").ok().stdout;
    assert!(!text.contains("not calibrated: run"), "{text}");
}

#[test]
fn what_grows_on_a_machine_without_a_calibration_is_an_incident() {
    let scratch = Scratch::new();
    let drift = ["drift,cylinder=3,sensor=c2,rate=0.001,at=10"];
    let run = machine(&scratch, BARE, &drift, &[]);
    let opened: Vec<Value> =
        run.incidents().into_iter().filter(|it| it["state"] == "opened").collect();
    assert_eq!(opened.len(), 1, "{opened:?}");
    assert_eq!((&opened[0]["cylinder"], &opened[0]["fault"]), (&3.into(), &"incipient".into()));
    let begin = opened[0]["begin"].as_f64().expect("it began");
    assert!((10.0..18.0).contains(&begin), "1 mm/s since 10 s: {begin}");
    assert_eq!(remarks(&run).len(), 1, "the others are not calibrated, as before");
}

/// At the first sample, at once and by and by.
#[test]
fn a_machine_trips_whatever_is_calibrated() {
    let scratch = Scratch::new();
    for (fault, until) in [
        ("step,cylinder=3,sensor=c1,size=0.06,at=0", 0.1),
        ("step,cylinder=3,sensor=c1,size=0.06,at=15", 15.1),
        ("drift,cylinder=3,sensor=c1,rate=0.02,at=10", 14.0),
    ] {
        let folder = scratch.path(&until.to_string());
        fs::create_dir(&folder).expect("it is new");
        let log = format!("{folder}/machine.log");
        let call = ["simulate", "--config", SIMULATED, "--duration", "20", "--fault", fault];
        tertius(&[&call[..], &["--output", &log]].concat(), b"").ok();
        let run = replay(&[&log], BARE, &[]).ok();
        let black = |it: &&Value| it["level"] == "black" && it["cylinder"] == 3;
        let warned = run.warnings().into_iter().find(|it| black(&it)).expect("a warning");
        assert!(warned["t"].as_f64().expect("a time") < until, "{fault}: {warned}");
        assert_ne!(warned["fault"], "not_calibrated", "{fault}");
        assert!(run.incidents().iter().any(|it| black(&it)), "{fault}");
    }
}

#[test]
fn a_difference_from_the_start_of_a_calibrated_machine_is_an_incident_and_no_step() {
    let scratch = Scratch::new();
    scratch.config(&[]);
    let text = fs::read_to_string(top().join(SIMULATED)).expect("it ships");
    let moved = [("../dbc/e-type.dbc", "e-type.dbc"), ("c2_offset = 0.004318", "c2_offset = 0.0")];
    let config = scratch.write("moved.toml", changed(&text, &moved));
    let run = machine(&scratch, &config, &[], &[]);
    let opened: Vec<Value> =
        run.incidents().into_iter().filter(|it| it["state"] == "opened").collect();
    assert_eq!(opened.len(), 1, "{opened:?}");
    assert_eq!((&opened[0]["cylinder"], &opened[0]["fault"]), (&1.into(), &"unclassified".into()));
    assert_eq!(remarks(&run), [] as [&str; 0]);
}

#[test]
fn the_log_tells_once_that_a_machine_is_not_calibrated() {
    let scratch = Scratch::new();
    let log = scratch.path("machine.log");
    let call = ["simulate", "--config", SIMULATED, "--seed", "1", "--duration", "10"];
    tertius(&[&call[..], &["--output", &log]].concat(), b"").ok();
    let told = |config: &str| {
        let set = ["--set", "bus.interface=virtual", "--set", "http.listen=off"];
        let play = ["run", "--config", config, "--play", &log, "--speed", "max"];
        let run = tertius(&[&play[..], &set].concat(), b"").ok();
        let warned = run.stderr.lines().filter(|line| line.contains("WARN"));
        warned.map(str::to_owned).collect::<Vec<_>>()
    };
    let warned = told(BARE);
    let [line] = &warned[..] else { panic!("{warned:?}") };
    assert!(line.contains("not calibrated: run `tertius commission`"), "{line}");
    let calibrated = told(SIMULATED);
    assert!(calibrated.iter().all(|line| !line.contains("not calibrated")), "{calibrated:?}");
}
