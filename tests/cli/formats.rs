//! The same bus, recorded in every format.

use std::fs;

use serde_json::Value;
use tertius_testing::oracle;
use tertius_testing::support::{E_TYPE, Run, Scratch, between, recorded, replay, tertius};

/// A step of cylinder 1's C1 is at 60 s; the interface has another name in each format.
const FROM: f64 = 57.0;
const TO: f64 = 64.5;

/// The rows of the residuals without their times, and the warnings without theirs.
fn said(run: &Run, residuals: &str) -> (Vec<String>, Vec<Value>) {
    let row = |line: &str| line.split_once(',').expect("columns").1.to_owned();
    let rows = residuals.lines().map(row).collect();
    let mut warnings = run.warnings();
    for warning in &mut warnings {
        let fields = warning.as_object_mut().expect("an object");
        fields.retain(|key, _| !["t", "timestamp"].contains(&key.as_str()));
    }
    (rows, warnings)
}

#[test]
fn a_recording_says_the_same_in_every_format() {
    let scratch = Scratch::new();
    let log = scratch.write("bus.log", between(&recorded("e-type-faults.log.zst"), FROM, TO));
    let path = |name: &str| scratch.path(name);
    let [pcap, asc, blf, trc] = ["bus.pcap", "bus.asc", "bus.blf", "bus.trc"].map(path);
    let [csv, mf4] = ["bus.csv", "bus.mf4"].map(path);
    oracle::run("pcap.py", &[&log, &pcap], "");
    oracle::run("asc.py", &["write", &log, &asc], "");
    oracle::run("blf.py", &["write", &log, &blf, "131072", "-1"], "");
    oracle::run("trc.py", &["write", "2.1", &log, &trc], "");
    oracle::run("savvycan.py", &["write", "dir", &log, &csv], "");
    oracle::run("mf4.py", &["write", &log, &mf4, "2"], "");
    let table = scratch.path("residuals.csv");
    let of = |recording: &str| {
        let options = ["--residuals", table.as_str(), "--force"];
        let run = replay(&[recording], E_TYPE, &options).ok();
        assert_eq!(run.summary()["bad_lines"], 0, "{recording}");
        said(&run, &scratch.read("residuals.csv"))
    };
    let (rows, warnings) = of(&log);
    assert!(rows.len() > 2000 && !warnings.is_empty(), "{} {warnings:?}", rows.len());
    for recording in [&pcap, &asc, &blf, &trc, &csv, &mf4] {
        let (other_rows, other_warnings) = of(recording);
        assert_eq!(other_rows, rows, "{recording}");
        assert_eq!(other_warnings.len(), warnings.len(), "{recording}");
        assert_eq!(other_warnings, warnings, "{recording}");
    }
    // A log that ends in a container is replayed up to it, and told to be damaged.
    let whole = fs::read(&blf).expect("it was written");
    let cut = scratch.write("cut.blf", &whole[..whole.len() - 100]);
    let told = "cut.blf: frames are missing; at byte ";
    let run = replay(&[&cut], E_TYPE, &[]).failed(1, &[told, "the rest of a container"]);
    let summary = run.summary();
    assert_eq!((&summary["judged"], &summary["damaged_inputs"]), (&true.into(), &1.into()));
    // What leads to the frames stands behind them here.
    let whole = fs::read(&mf4).expect("it was written");
    let cut = scratch.write("cut.mf4", &whole[..whole.len() / 2]);
    let told = "cut.mf4: frames are missing; at byte ";
    let run = replay(&[&cut], E_TYPE, &[]).failed(1, &[told, "found the end of the file"]);
    let summary = run.summary();
    assert_eq!((&summary["judged"], &summary["damaged_inputs"]), (&false.into(), &1.into()));
    for (reason, says) in [told, "no frame; it seems to be bus logging in MDF 4"].iter().enumerate()
    {
        assert!(
            summary["reasons"][reason].as_str().is_some_and(|it| it.contains(says)),
            "{summary}"
        );
    }
    tertius(&["convert", &cut, &scratch.path("converted.log")], b"").failed(1, &[told]);
}
