//! The A-type goes the way of every machine: it is commissioned by what was recorded of it, and then faults are found and
//! nothing else; whole, and with three of its cylinders monitored.

use serde_json::Value;
use tertius_testing::support::{Scratch, changed, tertius, top};

/// The machine's folder: its configuration without anything learnt.
struct Quay {
    scratch: Scratch,
    config: String,
}

/// An incident as a replay has it.
#[derive(Debug, PartialEq)]
struct Found {
    cylinder: u64,
    suspect: String,
    /// s since the first frame.
    at: f64,
}

impl Quay {
    fn new(cylinders: u8) -> Self {
        let scratch = Scratch::new();
        let text = std::fs::read_to_string(top().join("config/a-type.toml")).expect("it ships");
        let (text, _) = text.split_once("\n[model]").expect("it has a model");
        let dbc = top().join("dbc").display().to_string();
        let count = format!("cylinders = {cylinders}");
        let text = changed(text, &[("../dbc", &dbc), ("cylinders = 6", &count)]);
        let text = format!("{text}\n[gateway]\nnode = 96\n\n[comparator]\ncritical = 0.04\n");
        let config = scratch.write("machine.toml", text);
        Self { scratch, config }
    }

    fn simulate(&self, seconds: &str, sea: &str, seed: &str, faults: &[&str]) -> String {
        let log = self.scratch.path(&format!("{seed}.log"));
        let plant = top().join("config/a-type-plant.toml").display().to_string();
        let call = ["simulate", "--config", &self.config, "--plant", &plant, "--in-loop"];
        let of = ["--duration", seconds, "--sea", sea, "--seed", seed, "--output", &log];
        let faults: Vec<&str> = faults.iter().flat_map(|fault| ["--fault", fault]).collect();
        tertius(&[&call[..], &of, &faults].concat(), b"").ok();
        log
    }

    fn commission(&self) {
        let log = self.simulate("1500", "1.75,6.5", "21", &[]);
        let run = tertius(&["commission", &log, "--config", &self.config], b"").ok();
        assert!(run.stdout.contains("is fit for use: no false alarm"), "{}", run.stdout);
    }

    fn replay(&self, log: &str) -> Vec<Found> {
        let run = tertius(&["replay", log, "--config", &self.config, "--format", "jsonl"], b"");
        let lines = run.ok().stdout;
        let lines = lines.lines().map(|line| serde_json::from_str::<Value>(line).expect("JSON"));
        // The last word on each, as its end tells it.
        let mut last = std::collections::BTreeMap::new();
        for line in lines.filter(|line| line["type"] == "incident") {
            last.insert(line["incident"].as_u64(), line);
        }
        let found = last.into_values().map(|it| Found {
            cylinder: it["cylinder"].as_u64().expect("a number"),
            suspect: it["suspect"].as_str().expect("a name").to_owned(),
            at: it["begin"].as_f64().expect("a time"),
        });
        found.collect()
    }
}

#[test]
fn an_a_type_is_commissioned_and_finds_steps_and_a_drift_in_another_sea() {
    let quay = Quay::new(6);
    quay.commission();
    assert_eq!(quay.replay(&quay.simulate("600", "1.4,6", "22", &[])), []);
    let faults = [
        "step,cylinder=3,sensor=c1,at=100,until=130,size=0.004",
        "step,cylinder=6,sensor=c2,at=200,until=230,size=-0.003",
        "drift,cylinder=5,sensor=c1,at=300,until=330,rate=0.001",
    ];
    let found = quay.replay(&quay.simulate("400", "1.4,6", "23", &faults));
    assert_found(&found, &[(3, "c1", 100.0, 0.2), (6, "c2", 200.0, 0.2), (5, "c1", 300.0, 3.0)]);
}

/// Of three cylinders there is still a majority, by which what all share is told from what one has.
#[test]
fn three_cylinders_of_an_a_type_are_commissioned_and_find_what_befalls_them() {
    let quay = Quay::new(3);
    quay.commission();
    assert_eq!(quay.replay(&quay.simulate("600", "1.4,6", "24", &[])), []);
    let faults = [
        "step,cylinder=3,sensor=c1,at=100,until=130,size=0.004",
        "drift,cylinder=1,sensor=c2,at=200,until=230,rate=0.001",
        "broken_wire,cylinder=2,sensor=c1,at=300,until=305",
    ];
    let found = quay.replay(&quay.simulate("400", "1.4,6", "25", &faults));
    assert_found(&found, &[(3, "c1", 100.0, 0.2), (1, "c2", 200.0, 3.0), (2, "c1", 300.0, 0.2)]);
}

/// Each fault, of a cylinder and a transducer from a time on, s, is one incident that begins within so many seconds; and
/// there is no other.
#[track_caller]
fn assert_found(found: &[Found], expected: &[(u64, &str, f64, f64)]) {
    assert_eq!(found.len(), expected.len(), "{found:#?}");
    for (it, (cylinder, suspect, at, within)) in found.iter().zip(expected) {
        assert_eq!(it.cylinder, *cylinder, "{it:?}");
        assert_eq!(it.suspect, *suspect, "{it:?}");
        assert!((*at..*at + within).contains(&it.at), "{it:?}");
    }
}
