//! docs/OUTPUTS.md against what is written: nothing that a program reads is missing on it.

use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::sync::Arc;
use tertius::alarm::Detector;
use tertius::alarm::own::OwnMessage;
use tertius::appliance::store::EXPORT_COLUMNS;
use tertius::appliance::telemetry::Recorder;
use tertius::appliance::telemetry::clock::SystemClock;
use tertius::appliance::telemetry::exposition::exposition;
use tertius::inject::table;
use tertius::report::{estimates, residuals};
use tertius_testing::support::{Scratch, replay, top};

/// The words of the page that are written as code.
fn told() -> BTreeSet<String> {
    let page = fs::read_to_string(top().join("docs/OUTPUTS.md")).expect("it is there");
    let parts = page.split('`').skip(1).step_by(2);
    parts.flat_map(|part| part.split_whitespace().map(str::to_owned).collect::<Vec<_>>()).collect()
}

#[track_caller]
fn all_told<'a>(names: impl IntoIterator<Item = &'a str>) {
    let told = told();
    let missing: Vec<&str> = names.into_iter().filter(|name| !told.contains(*name)).collect();
    assert!(missing.is_empty(), "docs/OUTPUTS.md says nothing of {missing:?}");
}

/// The names of all fields of an object, but for those of objects that have detectors as names.
fn fields(value: &Value, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(object) => {
            for (name, inner) in object {
                found.insert(name.clone());
                fields(inner, found);
            }
        }
        Value::Array(list) => list.iter().for_each(|inner| fields(inner, found)),
        _ => {}
    }
}

#[test]
fn every_column_of_a_csv_is_told() {
    all_told(residuals::HEADER.split(','));
    all_told(estimates::HEADER.split(','));
    all_told(EXPORT_COLUMNS);
    all_told(table::HEADER);
}

#[test]
fn every_metric_is_told() {
    let recorder = Recorder::new(Arc::new(SystemClock::new()));
    let text = exposition(recorder.telemetry(), &SystemClock::new()).expect("text takes it");
    let families = text.lines().filter_map(|line| line.strip_prefix("# TYPE "));
    let names = families.map(|line| match line.split_once(' ').expect("a name and a type") {
        (name, "counter") => format!("{name}_total"),
        (name, "info") => format!("{name}_info"),
        (name, _) => name.to_owned(),
    });
    let names: Vec<String> = names.collect();
    assert!(names.len() > 60, "{}", names.len());
    all_told(names.iter().map(String::as_str));
}

#[test]
fn every_field_of_the_lines_of_json_is_told() {
    let scratch = Scratch::new();
    // Sequential detectors, devices and other things are in the one or the other.
    let sequential = "tests/recordings/e-type-sequential.toml";
    let faults = replay(&["tests/recordings/e-type-faults.log.zst"], sequential, &[]).ok();
    let bad = scratch.write("bad.log", "no frame\n");
    let refused = replay(&[&bad], sequential, &[]);
    let mut found = BTreeSet::new();
    for line in faults.lines().iter().chain(&refused.lines()) {
        fields(line, &mut found);
    }
    assert!(found.len() > 70, "{found:?}");
    all_told(found.iter().map(String::as_str));
}

#[test]
fn every_frame_and_detector_is_told() {
    let page = fs::read_to_string(top().join("docs/OUTPUTS.md")).expect("it is there");
    for message in OwnMessage::ALL {
        let heading = format!("*{}*, 0x{:03X} + node", message.name(), message.base());
        assert!(page.contains(&heading), "{heading:?} is not on the page");
    }
    all_told(Detector::ALL.map(Detector::name));
    // The signals of the gateway's frames, as the DBC has them.
    let dbc = fs::read_to_string(top().join("dbc/e-type.dbc")).expect("it ships");
    let (_, own) = dbc.split_once("BO_ 465 ").expect("Fd_Status");
    let own = own.split("\n\nCM_").next().expect("a part");
    let signals =
        own.lines().filter_map(|line| line.trim().strip_prefix("SG_ ")?.split(' ').next());
    let signals: BTreeSet<&str> = signals.filter(|name| !name.ends_with("_State")).collect();
    assert!(signals.len() > 12, "{signals:?}");
    for signal in signals.into_iter().filter(|name| !["Crc", "Counter"].contains(name)) {
        assert!(page.contains(&format!("| `{signal}` | ")), "{signal} is not on the page");
    }
}
