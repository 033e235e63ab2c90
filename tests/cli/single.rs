//! Machines with cylinders that have C1 alone.

use serde_json::Value;
use tertius_testing::oracle;
use tertius_testing::process::read;
use tertius_testing::support::{Scratch, between, changed, recorded, replay, tertius};

/// Cylinder 3 without C2.
const MIXED: [(&str, &str); 1] =
    [("n = 3\nc2_gain = 1.00018289\nc2_offset = -0.00251205", "n = 3\nc2 = false")];

/// The recordings' machine, on which no cylinder has a C2.
fn without_c2(scratch: &Scratch) -> String {
    let config = scratch.config(&[]);
    let text = scratch.read("e-type.toml");
    let (text, _) = text.split_once("\n[[cylinder]]").expect("there are tables");
    let lines = text.lines().filter(|line| !line.starts_with("c2"));
    scratch.write("e-type.toml", lines.map(|line| format!("{line}\n")).collect::<String>());
    config
}

/// The faults of cylinder 3: a step of 10 mm of C1 at 135 s, one of 25 mm of C2 at 150 s, 5 s each.
fn steps(scratch: &Scratch) -> String {
    scratch.write("steps.log", between(&recorded("e-type-faults.log.zst"), 128.0, 160.0))
}

/// The block of cylinder `n` in what `check` says.
fn block(text: &str, n: u8) -> String {
    let (_, rest) = text.split_once(&format!("\ncylinder {n}\n")).expect("it is described");
    rest.split("\n\n").next().expect("there is a first part").to_owned()
}

#[test]
fn check_describes_a_cylinder_without_c2_by_what_it_has() {
    let scratch = Scratch::new();
    let text = tertius(&["check", &scratch.config(&MIXED)], b"").ok().stdout;
    assert!(text.contains("FDE1 and FDE2 judge when engaged"), "{text}");
    let alone = block(&text, 3);
    for line in [
        "frames    0x183 0x1A3\n",
        "FDE1      gain of",
        "C2        not fitted, so nothing is compared: no FDE2, no FDE3, no sequential detector",
        "estimate  C1 and the model; valid",
    ] {
        assert!(alone.contains(line), "{line:?} is not in\n{alone}");
    }
    assert!(!alone.contains("FDE2  ") && !alone.contains("FDE3  "), "{alone}");
    let other = block(&text, 4);
    assert!(other.contains("FDE2  ") && other.contains("FDE3      C1 − (0.998863 C2"), "{other}");

    let text = tertius(&["check", &without_c2(&scratch)], b"").ok().stdout;
    assert!(text.contains("every 0.02 s; FDE1 judges when engaged"), "{text}");
    assert!(!text.contains("FDE2  ") && !text.contains("0x19"), "{text}");
    assert!(text.contains("cylinders 1–6"), "{text}");
}

#[test]
fn a_cylinder_without_c2_is_judged_by_its_observer_and_the_others_as_ever() {
    let scratch = Scratch::new();
    let log = steps(&scratch);
    let run = replay(&[&log], &scratch.config(&MIXED), &[]).ok();
    let alone: Vec<Value> = run.warnings().into_iter().filter(|it| it["cylinder"] == 3).collect();
    assert!(!alone.is_empty());
    for warning in &alone {
        assert_eq!(warning["detector"], "fde1", "{warning}");
        assert_ne!(warning["suspect"], "c2", "{warning}");
    }
    let begin = |it: &Value| it["t"].as_f64().expect("a time");
    let first = alone.first().map(begin).expect("there is one");
    assert!((7.0..7.1).contains(&first), "{first}");
    // Nothing reads C2, whose step begins at 22 s.
    let raised = alone.iter().filter(|it| it["state"] == "raised").map(begin);
    assert!(raised.filter(|t| (21.9..26.9).contains(t)).count() == 0, "{alone:#?}");

    let both = replay(&[&log], &scratch.config(&[]), &[]).ok();
    let of_others = |warnings: Vec<Value>| -> Vec<Value> {
        warnings.into_iter().filter(|it| it["cylinder"] != 3).collect()
    };
    assert_eq!(of_others(run.warnings()), of_others(both.warnings()));
}

#[test]
fn the_story_of_a_cylinder_without_c2_compares_with_no_other_reading() {
    let scratch = Scratch::new();
    let config = scratch.config(&MIXED);
    let text = tertius(&["replay", "--config", &config, &steps(&scratch)], b"").ok().stdout;
    let (_, stories) = text.split_once("C1's observer").expect("there is evidence");
    let evidence = stories.split('.').next().expect("it ends");
    assert!(!evidence.contains("C2") && !evidence.contains("difference"), "{text}");
    assert!(
        text.contains("if C1 reads another length")
            || text.contains("look at the cylinder, its valve"),
        "{text}"
    );
    assert!(!text.contains("the transducer that reads another length"), "{text}");
}

/// The states of C2 and the cylinder that a frame says has none, of each Fd_Status.
fn statuses(scratch: &Scratch, config: &str) -> Vec<([i64; 6], i64)> {
    let sent = scratch.path("sent.log");
    replay(&[&steps(scratch)], config, &["--warnings", &sent, "--force"]).ok();
    let frames = oracle::run("gateway.py", &["dbc/e-type.dbc", &sent], "");
    let frames: Vec<(i64, u64, String, bool, Value)> = serde_json::from_str(&frames).expect("JSON");
    let of = |signals: &Value, name: &str| signals[name].as_i64().expect("a number");
    let status = |(_, id, _, whole, signals): &(i64, u64, String, bool, Value)| {
        assert!(whole);
        let state = |n: usize| of(signals, &format!("Cyl{}_C2_State", n + 1));
        (*id == 0x1D1).then(|| (std::array::from_fn(state), of(signals, "WithoutC2")))
    };
    frames.iter().filter_map(status).collect()
}

#[test]
fn fd_status_names_the_cylinders_without_c2_in_turn() {
    let scratch = Scratch::new();
    let of_mixed = statuses(&scratch, &scratch.config(&MIXED));
    assert!(of_mixed.len() > 300);
    assert!(of_mixed.iter().all(|(states, without)| (states[2], *without) == (0, 3)));
    let [.., (states, _)] = of_mixed[..] else { panic!("there are some") };
    assert_eq!(states, [1, 1, 0, 1, 1, 1]);
    let of_all = statuses(&scratch, &without_c2(&scratch));
    let turns: Vec<i64> = of_all.iter().take(8).map(|(_, without)| *without).collect();
    assert_eq!(turns, [1, 2, 3, 4, 5, 6, 1, 2]);
    let of_none = statuses(&scratch, &scratch.config(&[]));
    assert!(of_none.iter().all(|(_, without)| *without == 0));
}

#[test]
fn a_simulated_cylinder_without_c2_sends_none_and_takes_no_fault_of_it() {
    let scratch = Scratch::new();
    let config = scratch.config(&MIXED);
    let log = scratch.path("machine.log");
    let call = ["simulate", "--config", &config, "--plant", "config/e-type-plant.toml"];
    tertius(&[&call[..], &["--duration", "2", "--output", &log]].concat(), b"").ok();
    let frames = read(log.as_ref());
    let count = |id: u32| frames.iter().filter(|frame| frame.id.value() == id).count();
    assert_eq!([0x193, 0x194, 0x183].map(count), [0, 100, 100]);
    let fault = ["--fault", "step,cylinder=3,sensor=c2,at=1,size=0.01"];
    let output = scratch.path("faulty.log");
    let call = ["inject", &log, "--config", &config, "--output", &output];
    tertius(&[&call[..], &fault].concat(), b"").failed(2, &["cylinder 3 has no C2"]);
}

/// What is left out of a configuration is a mistake of its own.
#[test]
fn a_calibration_of_a_c2_that_is_not_there_is_refused_where_it_stands() {
    let scratch = Scratch::new();
    let (from, to) = MIXED[0];
    let config = scratch.config(&[(from, &format!("{to}\nc2_gain = 1.001"))]);
    let run = tertius(&["check", &config], b"");
    run.failed(2, &["`cylinder[2].c2_gain` is there, but cylinder 3 has no C2", "leave it out"]);
    let text = changed(&scratch.read("e-type.toml"), &[("\nc2_gain = 1.001", "")]);
    tertius(&["check", &scratch.write("e-type.toml", text)], b"").ok();
}
