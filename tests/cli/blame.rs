//! The rule that named a suspect: in the lines of JSON, in the explanation of a warning, and in docs/BLAME.md.

use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use tertius::blame::{OVERRULING, Rule};
use tertius_testing::support::{E_TYPE, Scratch, recorded, recording, replay, tertius, top};

const FAULTS: &str = "e-type-faults.log.zst";

fn explained(at: f64) -> String {
    let at = at.to_string();
    let log = recording(FAULTS);
    tertius(&["replay", &log, "--config", E_TYPE, "--explain", &at], b"").ok().stdout
}

/// Each warning of the recording, explained at its time: the rule of its line is the one that decides.
#[test]
fn the_rule_of_a_warning_is_the_last_one_that_was_asked() {
    let run = replay(&[&recording(FAULTS)], E_TYPE, &[]).ok();
    let mut rules = BTreeSet::new();
    let raised = run.warnings().into_iter().filter(|it| it["state"] == "raised");
    for warning in raised.filter(|it| it["detector"] == "fde3" || it["detector"] == "fde2").take(8)
    {
        let text = |key: &str| warning[key].as_str().expect("a text").to_owned();
        let (by, suspect) = (text("by"), text("suspect"));
        // The newest cycle at that time is the one that has raised it.
        let told = explained(warning["t"].as_f64().expect("a time") + 1e-3);
        let label = text("detector").to_uppercase();
        let head = format!("cylinder {}, {label}: ", warning["cylinder"]);
        let (_, own) = told.split_once(&head).unwrap_or_else(|| panic!("no {head} in\n{told}"));
        let own = own.split("\n\n").next().expect("a part");
        let suspect = if suspect.starts_with('c') { suspect.to_uppercase() } else { suspect };
        assert!(own.contains(&format!("suspect {suspect} by {by}: ")), "{by} in\n{own}");
        let decided = own.lines().last().expect("a line").split_whitespace().collect::<Vec<_>>();
        assert_eq!(decided, [by.as_str(), &suspect], "\n{own}");
        rules.insert(by);
    }
    assert!(rules.len() > 1, "{rules:?}");
}

/// An incident has the rule of the detector that named its suspect.
#[test]
fn an_incident_is_named_by_the_rule_of_one_of_its_detectors() {
    let run = replay(&[&recording(FAULTS)], E_TYPE, &[]).ok();
    let mut named = 0;
    for incident in run.incidents() {
        let detectors = incident["detectors"].as_array().expect("a list");
        match &incident["suspect"] {
            suspect if suspect == "undecided" => assert_eq!(incident["by"], Value::Null),
            suspect => {
                let own = |it: &&Value| it["suspect"] == *suspect && it["by"] == incident["by"];
                assert!(detectors.iter().any(|it| own(&it)), "{incident}");
                named += 1;
            }
        }
    }
    assert!(named > 10, "{named}");
}

#[test]
fn a_time_without_a_finding_or_beyond_the_recording_is_reported() {
    assert_eq!(explained(50.0), "At 50 s no detector has found anything.\n");
    let log = recording(FAULTS);
    let call = ["replay", &log, "--config", E_TYPE, "--explain", "0.1"];
    tertius(&call, b"").failed(1, &["nothing was judged at that time"]);
    let call = ["replay", &log, "--config", E_TYPE, "--explain", "1e6"];
    tertius(&call, b"").failed(2, &["the recording ends", "give an earlier time"]);
    let call = ["replay", &log, "--config", E_TYPE, "--explain", "soon"];
    tertius(&call, b"").failed(2, &["expected seconds after the first frame"]);
}

/// docs/BLAME.md has every rule, and those that overrule in the order in which they are asked.
#[test]
fn the_page_has_every_rule_in_its_order() {
    let page = fs::read_to_string(top().join("docs/BLAME.md")).expect("it is there");
    let rows = page.lines().filter_map(|line| line.strip_prefix("| `")?.split_once('`'));
    let told: Vec<&str> = rows.map(|(rule, _)| rule).collect();
    let all: BTreeSet<&str> = Rule::ALL.into_iter().map(Rule::name).collect();
    assert_eq!(told.iter().copied().collect::<BTreeSet<_>>(), all);
    assert_eq!(told.len(), all.len(), "a rule is told twice");
    let asked: Vec<&str> = OVERRULING.iter().map(|(rule, _)| rule.name()).collect();
    assert_eq!(told[told.len() - asked.len()..], asked);
}

/// C1 of cylinder 1 leaves its range in the last cycle of a recording.
#[test]
fn a_warning_of_the_last_frame_is_explained() {
    let scratch = Scratch::new();
    let run = replay(&[&recording(FAULTS)], E_TYPE, &[]).ok();
    let warnings = run.warnings();
    let first = warnings.first().expect("it has some")["t"].as_f64().expect("a time");
    let text = recorded(FAULTS);
    let begin = text.lines().next().and_then(stamp).expect("a line has a stamp");
    let until = |line: &&str| stamp(line).is_some_and(|at| at - begin < first + 1e-6);
    let cut: Vec<&str> = text.lines().take_while(until).collect();
    let log = scratch.write("cut.log", cut.join("\n"));
    let call = ["replay", &log, "--config", E_TYPE, "--explain", &first.to_string()];
    let told = tertius(&call, b"").ok().stdout;
    assert!(told.contains("suspect "), "{told}");
}

/// Time stamp of a line of candump, s.
fn stamp(line: &str) -> Option<f64> {
    line.strip_prefix('(')?.split_once(')')?.0.parse().ok()
}
