//! Recordings with injected faults, judged by python-can, cantools and NumPy.

use std::path::Path;
use std::process::{Command, Output};
use tertius::bus::{LogWriter, Options, Recording, Source};
use tertius_testing::oracle;

const TABLE: &str = "cylinder,sensor,kind,t0,magnitude,parameter,t1
1,C1,step,2.0,0.00175,,7.5
1,C2,step,3.0001,-0.025,0.0,
2,C1,noise,1.0,0.000868,,
2,C2,incipient,2.005,0.07,1.0,12
3,C1,incipient,0.5,-0.2,0.25,
3,C2,drift,1.23,0.001,0,
4,C1,stuck,4.0,0.0,0.0,8.0
4,C2,scale,2.5,0.01,,9.9
5,C1,spike,1.0,0.005,0.05,
5,C2,drift,0,-1e-5,,
";

/// The first `frames` frames of the engaged part of the healthy recording.
fn excerpt(path: &Path, frames: usize) {
    let log = oracle::top().join("tests/recordings/e-type-healthy.log.zst");
    let mut recording = Recording::open(&[log], Options::default()).unwrap();
    let mut writer = LogWriter::new(Vec::new(), "can0");
    let (mut first, mut written) = (None, 0);
    while let Some(frame) = recording.next_frame().unwrap() {
        let t = frame.timestamp.since(*first.get_or_insert(frame.timestamp)).as_seconds();
        if t >= 140.0 && written < frames {
            writer.write(frame).unwrap();
            written += 1;
        }
    }
    assert_eq!(written, frames);
    std::fs::write(path, writer.into_inner()).unwrap();
}

fn inject(healthy: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tertius"))
        .arg("inject")
        .arg(healthy)
        .arg("--config")
        .arg(oracle::top().join("tests/recordings/e-type.toml"))
        .args(arguments)
        .output()
        .unwrap()
}

#[test]
fn every_shape_decodes_elsewhere_to_reading_plus_fault_within_half_a_count() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name| directory.path().join(name);
    let (healthy, faulty, table) = (path("healthy.log"), path("faulty.log"), path("faults.csv"));
    excerpt(&healthy, 15_000);
    std::fs::write(&table, TABLE).unwrap();
    let [table, faulty] = [&table, &faulty].map(|path| path.to_str().unwrap());
    let output = inject(&healthy, &["--faults", table, "--output", faulty, "--seed", "3"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let arguments = ["dbc/e-type.dbc", healthy.to_str().unwrap(), faulty, table];
    let judged = oracle::run("inject.py", &arguments, "");
    let rows: Vec<Vec<&str>> = judged.lines().map(|line| line.split(' ').collect()).collect();
    let kinds: Vec<&str> = TABLE.lines().skip(1).map(|l| l.split(',').nth(2).unwrap()).collect();
    assert_eq!(rows.iter().map(|row| row[0]).collect::<Vec<_>>(), kinds);
    for row in &rows {
        let [frames, changed]: [u64; 2] = [1, 2].map(|i| row[i].parse().unwrap());
        let error: f64 = row[3].parse().unwrap();
        // The oracle rounds once more than the frames, in the last place.
        assert!(error <= 0.5 + 1e-6, "{row:?}");
        assert!(frames >= 100 && changed > 0, "{row:?}");
    }
    // -1, 0, 1 are equally likely: 630 frames, σ = 12.
    for count in &rows[2][4..] {
        let count: i64 = count.parse().unwrap();
        let expected = rows[2][1].parse::<i64>().unwrap() / 3;
        assert!((count - expected).abs() < 50, "{:?}", rows[2]);
    }
    // One spike in twenty: 630 frames, σ = 5.5.
    let spikes: i64 = rows[8][6].parse().unwrap();
    assert!((12..55).contains(&spikes), "{:?}", rows[8]);
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_seed_others() {
    let directory = tempfile::tempdir().unwrap();
    let healthy = directory.path().join("healthy.log");
    excerpt(&healthy, 3_000);
    let run = |seed: &str| {
        let fault = "noise,cylinder=2,sensor=c2,size=0.002";
        let loss = "loss,cylinder=5,probability=0.5";
        let output = inject(&healthy, &["--fault", fault, "--fault", loss, "--seed", seed]);
        assert!(output.status.success());
        output.stdout
    };
    assert_eq!(run("7"), run("7"));
    assert_ne!(run("7"), run("8"));
}
