//! Incidents: one for each fault, with its transducer, and with the peaks that the table of residuals has.

use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use tertius_testing::oracle;
use tertius_testing::support::{E_TYPE, Run, Scratch, recording, replay, tertius, top};

const SIMULATED: &str = "config/e-type-simulated.toml";

/// The incidents as they were told last, by their numbers.
fn newest(run: &Run) -> BTreeMap<u64, Value> {
    let number = |it: &Value| it["incident"].as_u64().expect("a number");
    run.incidents().into_iter().map(|incident| (number(&incident), incident)).collect()
}

fn seconds(incident: &Value, key: &str) -> Option<f64> {
    incident[key].as_f64()
}

/// Compares the peaks with those of the table of residuals `csv`; returns how many there were.
fn assert_peaks(run: &Run, csv: &str) -> u64 {
    let limits = [csv, "1e-3", "1.5e-3", "0.05", "0.02"];
    let answer = oracle::run("incidents.py", &limits, &run.stdout);
    let judged: Value = serde_json::from_str(&answer).expect("it answers in JSON");
    assert_eq!(judged["differences"], Value::Array(Vec::new()));
    judged["compared"].as_u64().expect("a count")
}

#[test]
fn each_fault_of_the_recording_is_one_incident_of_its_transducer() {
    let scratch = Scratch::new();
    let csv = scratch.path("residuals.csv");
    let run = replay(&[&recording("e-type-faults.log.zst")], E_TYPE, &["--residuals", &csv]).ok();
    let incidents = newest(&run);
    let truth =
        fs::read_to_string(top().join(recording("e-type-faults.truth.csv"))).expect("it is there");
    let mut faults = 0;
    for (row, incident) in truth.lines().skip(1).zip(incidents.values()) {
        let fields: Vec<&str> = row.split(',').collect();
        let (begin, end) = (fields[3].parse::<f64>().unwrap(), fields[6].parse::<f64>().unwrap());
        assert_eq!(incident["cylinder"].to_string(), fields[0], "{row}");
        assert_eq!(incident["suspect"], fields[1].to_lowercase(), "{row}");
        let from = seconds(incident, "begin").expect("it began");
        assert!((begin..end).contains(&from), "{row}: {from}");
        let until = seconds(incident, "end").expect("it is over");
        assert!((end - 2.5..end + 2.5).contains(&until), "{row}: {until}");
        faults += 1;
    }
    assert_eq!((faults, incidents.len()), (14, 14));
    assert_eq!(run.summary()["incidents"], 14);
    let black: Vec<u64> = incidents
        .iter()
        .filter(|(_, it)| it["level"] == "black")
        .map(|(number, _)| *number)
        .collect();
    assert_eq!(black, [10, 13], "70 mm, and a reading that stood while the other moved on");
    assert_eq!(assert_peaks(&run, &csv), 44);
}

/// Faults of every kind one after another on one cylinder, as an hour in a bad week may have them.
#[test]
fn faults_one_after_another_are_told_apart() {
    let scratch = Scratch::new();
    let [log, csv] = ["faults.log", "residuals.csv"].map(|name| scratch.path(name));
    let faults = [
        ("step,sensor=c1,size=0.004", 10.0, 20.0),
        ("noise,sensor=c2,size=0.003", 35.0, 45.0),
        ("drift,sensor=c2,rate=-0.0005", 60.0, 90.0),
        ("freeze,sensor=c1", 105.0, 115.0),
        ("loss,sensor=c2", 130.0, 135.0),
        ("incipient,sensor=c1,size=0.06,b=1", 150.0, 165.0),
        ("broken_wire,sensor=c1", 180.0, 190.0),
        ("step,sensor=c2,size=-0.008", 200.0, 300.0),
    ];
    let mut call = vec!["simulate", "--config", SIMULATED, "--seed", "17", "--duration", "225"];
    let specs: Vec<String> = faults
        .iter()
        .map(|(what, from, until)| {
            let (kind, rest) = what.split_once(',').expect("a kind and more");
            format!("{kind},cylinder=4,{rest},at={from},until={until}")
        })
        .collect();
    specs.iter().for_each(|spec| call.extend(["--fault", spec]));
    call.extend(["--output", &log]);
    tertius(&call, b"").ok();
    let run = replay(&[&log], SIMULATED, &["--residuals", &csv]).ok();
    let incidents = newest(&run);
    assert_eq!(incidents.len(), faults.len());
    for ((what, from, until), incident) in faults.iter().zip(incidents.values()) {
        let suspect = incident["suspect"].as_str().expect("a word");
        assert!(what.contains(&format!("sensor={suspect}")), "{what}: {incident}");
        let begin = seconds(incident, "begin").expect("it began");
        assert!((*from..from + 10.0).contains(&begin), "{what}: {begin}");
        match seconds(incident, "end") {
            Some(end) => assert!((end - until).abs() < 2.5, "{what}: {end}"),
            None => assert!(*until > 225.0, "{what} stands"),
        }
    }
    let last = incidents.values().last().expect("there are some");
    assert_eq!((&last["state"], &last["ending"]), (&Value::from("standing"), &Value::Null));
    assert!(assert_peaks(&run, &csv) > 16);
    let text = tertius(&["replay", &log, "--config", SIMULATED], b"").ok().stdout;
    assert!(
        text.contains("8 incidents in 4 min. Worst: cylinder 4, C1, black: frozen reading"),
        "{text}"
    );
    assert!(
        // The first names the files and the configuration, and is as long as these are.
        text.lines().skip(1).all(|line| line.chars().count() <= 80 || line.contains("recording")),
        "{text}"
    );
}

/// Three noises of one transducer each, a drift that ends, and a step of which nobody knows whose it is.
#[test]
fn the_worst_is_the_largest_against_its_limit_and_a_late_suspect_is_told_as_such() {
    let scratch = Scratch::new();
    let log = scratch.path("faults.log");
    let (healthy, csv) = (recording("e-type-healthy.log.zst"), scratch.path("residuals.csv"));
    let mut call = vec!["inject", &healthy, "--config", E_TYPE, "--output", &log];
    for fault in [
        "noise,cylinder=4,sensor=c1,at=200,size=0.003",
        "noise,cylinder=5,sensor=c1,at=250,size=0.006",
        "noise,cylinder=2,sensor=c1,at=260,size=0.002",
        "drift,cylinder=3,sensor=c2,at=200,rate=0.0002,until=320",
        "step,cylinder=1,sensor=c1,at=100,size=0.06,until=102",
    ] {
        call.extend(["--fault", fault]);
    }
    tertius(&call, b"").ok();
    let run = replay(&[&log], E_TYPE, &["--residuals", &csv]).ok();
    assert!(assert_peaks(&run, &csv) > 10);
    let told = run.incidents();
    let of = |cylinder: u64| told.iter().filter(move |it| it["cylinder"] == cylinder);
    let drift: Vec<&Value> = of(3).collect();
    for two in drift.windows(2) {
        let [before, after] = [two[0], two[1]].map(|it| seconds(it, "t").expect("a time"));
        let [small, large] = [two[0], two[1]].map(|it| seconds(it, "peak").expect("it").abs());
        let grew = two[0]["suspect"] == two[1]["suspect"] && two[1]["state"] == "revised";
        assert!(!grew || after - before >= 5.0, "{before} {after}");
        assert!(large <= 1.35 * small || after - before < 5.1, "{small} {large}");
    }
    assert!(drift.len() > 8, "{} times", drift.len());
    let end = drift.last().expect("it is over");
    assert_eq!((&end["suspect"], &end["named_by_its_end"]), (&"c2".into(), &true.into()));
    assert!((seconds(end, "named").expect("it is named") - 320.0).abs() < 0.1, "{end}");
    assert!(end["summary"].as_str().is_some_and(|it| it.contains("when the fault ended")), "{end}");
    let step = of(1).next().expect("it is found");
    assert!((seconds(step, "size").expect("a step") - 0.06).abs() < 5e-4, "{step}");
    let text = tertius(&["replay", &log, "--config", E_TYPE], b"").ok().stdout;
    assert!(text.contains("Worst: cylinder 1, C1 or C2, black: step of 60.3 mm"), "{text}");
    let table = text.lines().skip_while(|line| !line.contains("largest, mm")).skip(1);
    let rows = table.take_while(|row| !row.is_empty());
    let cylinders = rows.filter_map(|row| row.split_whitespace().nth(1)?.parse::<u64>().ok());
    // By what was largest against its limit: trip, drift of 24 mm, noises of 6, 3 and 2 mm.
    assert_eq!(cylinders.collect::<Vec<_>>(), [1, 3, 5, 4, 2], "{text}");
    assert!(text.contains(" C2 late "), "{text}");
}

#[test]
fn a_quiet_recording_fits_one_screen_and_says_what_was_judged() {
    let log = recording("e-type-healthy.log.zst");
    let sequential = "tests/recordings/e-type-sequential.toml";
    let text = tertius(&["replay", &log, "--config", sequential], b"").ok().stdout;
    assert!(text.lines().count() <= 24, "{text}");
    for told in [
        "No incident in 10 min.",
        "The observers judged 56.7 % of the time.",
        "not monitored 43.3 %",
        "Not judged: every cylinder from 22:13:20.000 to 22:15:30.020",
    ] {
        assert!(text.contains(told), "{told:?} is not in\n{text}");
    }
    let zoned = ["replay", &log, "--config", sequential, "--time-zone", "Europe/Amsterdam"];
    assert!(tertius(&zoned, b"").ok().stdout.contains("every cylinder from 23:13:20.000"));
    let nowhere = ["replay", &log, "--config", sequential, "--time-zone", "Mars/Olympus"];
    let refused = tertius(&nowhere, b"");
    assert!(refused.code != Some(0) && refused.stderr.contains("Europe/Amsterdam"), "{refused:?}");
}

/// The recording's own configuration has none, as that machine is the thesis's.
#[test]
fn a_machine_without_a_model_is_told_so() {
    let told = |config: &str| {
        let run =
            tertius(&["replay", &recording("e-type-healthy.log.zst"), "--config", config], b"");
        run.ok()
            .stdout
            .contains("no [model], so that R1 and R2 are by that of the thesis, Table 4-1")
    };
    assert!(told(E_TYPE));
    assert!(!told("config/e-type-simulated.toml"));
}
