//! Detectors that the configuration switches off raise no warning, and no transducer is healthy by them.

use serde_json::Value;
use tertius_testing::oracle;
use tertius_testing::support::{E_TYPE, Scratch, between, recorded, replay, tertius};

const SEQUENTIAL: &str = "tests/recordings/e-type-sequential.toml";
const NO_OBSERVERS: [&str; 2] = ["--set", "fde.enabled=false"];
const NO_DIFFERENCE: [&str; 2] = ["--set", "comparator.enabled=false"];

/// A minute with faults of several kinds.
fn faulty(scratch: &Scratch) -> String {
    scratch.write("faulty.log", between(&recorded("e-type-faults.log.zst"), 128.0, 188.0))
}

/// How many warnings of each of FDE1 to FDE3 a replay has with these `options`.
fn counts(log: &str, options: &[&str]) -> [usize; 3] {
    let warnings = replay(&[log], SEQUENTIAL, options).ok().warnings();
    ["fde1", "fde2", "fde3"].map(|name| warnings.iter().filter(|it| it["detector"] == name).count())
}

#[test]
fn a_detector_that_is_off_warns_of_nothing_and_the_others_as_ever() {
    let scratch = Scratch::new();
    let log = faulty(&scratch);
    let [fde1, fde2, fde3] = counts(&log, &[]);
    assert!(fde1 > 0 && fde2 > 0 && fde3 > 0, "{fde1} {fde2} {fde3}");
    let [none, nothing, without_observers] = counts(&log, &NO_OBSERVERS);
    assert_eq!([none, nothing], [0, 0]);
    assert!(without_observers > 0);
    let [own, other, none] = counts(&log, &NO_DIFFERENCE);
    assert!(own > 0 && other > 0 && none == 0, "{own} {other} {none}");
}

/// Values of the states of C1 and C2 in the frames Fd_Status of a healthy half minute, each once.
fn states(scratch: &Scratch, config: &str, options: &[&str]) -> Vec<i64> {
    let log = between(&recorded("e-type-healthy.log.zst"), 200.0, 230.0);
    let (log, sent) = (scratch.write("healthy.log", log), scratch.path("sent.log"));
    replay(&[&log], config, &[&["--warnings", &sent, "--force"], options].concat());
    let frames = oracle::run("gateway.py", &["dbc/e-type.dbc", &sent], "");
    let frames: Vec<(i64, u64, String, bool, Value)> = serde_json::from_str(&frames).expect("JSON");
    // An observer needs a second to settle, a sequential detector a few.
    let late = frames.iter().filter(|(at, id, ..)| *id == 0x1D1 && at - frames[0].0 > 15_000_000);
    let states = late.flat_map(|(.., signals)| {
        let signals = signals.as_object().expect("signals by name");
        let states = signals.iter().filter(|(name, _)| name.ends_with("_State"));
        states.map(|(_, value)| value.as_i64().expect("a raw value")).collect::<Vec<_>>()
    });
    let mut states: Vec<i64> = states.collect();
    states.sort_unstable();
    states.dedup();
    states
}

#[test]
fn without_its_observer_a_transducer_is_healthy_only_by_the_sequential_detector() {
    let scratch = Scratch::new();
    let [unknown, healthy] = [0, 1];
    assert_eq!(states(&scratch, E_TYPE, &[]), [healthy]);
    assert_eq!(states(&scratch, E_TYPE, &NO_OBSERVERS), [unknown]);
    // It knows parts of the stroke only, and what it does not know is no good news.
    assert_eq!(states(&scratch, SEQUENTIAL, &NO_OBSERVERS), [unknown, healthy]);
}

#[test]
fn check_and_replay_name_what_is_off() {
    let scratch = Scratch::new();
    let log = faulty(&scratch);
    let page = |config, options: &[&str]| {
        tertius(&[&["replay", &log, "--config", config], options].concat(), b"").ok().stdout
    };
    let text = page(SEQUENTIAL, &NO_OBSERVERS);
    assert!(
        text.contains("\nSwitched off: FDE1 and FDE2.\nThe sequential detectors judged"),
        "{text}"
    );
    let text = page(E_TYPE, &NO_DIFFERENCE);
    assert!(text.contains(" of the time.\nSwitched off: FDE3.\n"), "{text}");
    let both = [&["check", E_TYPE], &NO_OBSERVERS[..], &NO_DIFFERENCE].concat();
    let text = tertius(&both, b"").ok().stdout;
    for line in [
        "FDE1      off (fde.enabled); gain of",
        "FDE3      off (comparator.enabled); C1 −",
        "switched off: FDE1, FDE2 and FDE3. `tertius commission` switches",
    ] {
        assert!(text.contains(line), "{line:?} is not in\n{text}");
    }
}

/// Nothing is judged then, and the exit code is 1.
#[test]
fn a_machine_without_any_detector_is_not_called_free_of_incidents() {
    let scratch = Scratch::new();
    let log = scratch.write("a.log", between(&recorded("e-type-healthy.log.zst"), 200.0, 210.0));
    replay(&[&log], E_TYPE, &NO_OBSERVERS).failed(
        1,
        &["nothing was judged: FDE1 and FDE2 are switched off (fde.enabled), and no cylinder has"],
    );
}
