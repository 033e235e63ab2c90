//! Every number of `replay --residuals` against NumPy, SciPy and cantools.

use serde_json::{Value, json};
use std::fs;
use std::io::Cursor;
use tertius::bus::{Options, Recording, Source};
use tertius::config;
use tertius::config::design;
use tertius::dbc::{self, Database};
use tertius::monitor::{Monitor, Record, Sink};
use tertius_testing::oracle;
use tertius_testing::support::{
    E_TYPE, HANGING_LOAD, Scratch, Seeded, between, recorded, replay, top,
};

/// What the oracle makes of a recording, after the comparison that every recording has to stand:
/// the same rows, the same places empty, and no number further apart than 1e-12.
fn compared(log: &str, config: &str, dbc: &str) -> Value {
    let scratch = Scratch::new();
    let (log, table) = (scratch.write("replayed.log", log), scratch.path("residuals.csv"));
    let run = replay(&[&log], config, &["--residuals", &table]).ok();
    let settings = fs::read_to_string(top().join(config)).expect("the configuration");
    let settings: toml::Value = toml::from_str(&settings).expect("it is TOML");
    let answer = oracle::run("residuals.py", &[dbc, &log, &table], &json!(settings).to_string());
    let answer: Value = serde_json::from_str(&answer).expect("JSON");

    assert_eq!(answer["rows"][0], answer["rows"][1], "{answer}");
    assert_eq!(answer["first_odd"], Value::Null, "a number where the other has none");
    for (column, worst) in answer["worst"].as_object().expect("a difference of each column") {
        let worst = worst.as_f64().expect("no column is empty");
        let allowed = if matches!(column.as_str(), "cylinder" | "gated") { 0.0 } else { 1e-12 };
        assert!(worst <= allowed, "{column} differs by {worst:e}: {answer}");
    }
    assert_eq!(answer["longer_than_shortest"], 0, "numbers are as short as they can be");
    let restart = |line: &Value| json!([line["t"], line["cylinder"], line["detector"]]);
    let restarts = run.lines().into_iter().filter(|line| line["notice"] == "restart");
    let restarts: Vec<Value> = restarts.map(|line| restart(&line)).collect();
    assert_eq!(json!(restarts), answer["restarts"]);
    let summary = run.summary();
    assert_eq!(summary["late_frames"], answer["late"]);
    assert_eq!(summary["repeated_frames"], answer["twice"]);
    assert_eq!(summary["missing_cycles"], answer["missing"]);
    answer
}

#[test]
fn faults() {
    let answer = compared(&recorded("e-type-faults.log.zst"), E_TYPE, "dbc/e-type.dbc");
    assert_eq!(answer["rows"][0], 6 * 24_000);
    assert_eq!(answer["frozen"], 245, "C2 of cylinder 6 stands still from 430 s to 435 s");
    assert_eq!(answer["restarts"][0][1], 6);
}

#[test]
fn coarse_transducers() {
    let answer = compared(&recorded("e-type-coarse.log.zst"), E_TYPE, "dbc/e-type.dbc");
    assert_eq!(answer["rows"][0], 6 * 15_000);
    assert_eq!(answer["gated"], 6 * 50, "until the observers have settled");
}

/// One cylinder without Sync and velocity, in Motorola byte order.
#[test]
fn position_alone() {
    let log = recorded("hanging-load.log.gz");
    let answer = compared(&log, HANGING_LOAD, "tests/recordings/hanging-load.dbc");
    assert_eq!(answer["rows"][0], 16_060);
}

/// The monitor of [`E_TYPE`], in this process.
#[derive(Default)]
struct Records(Vec<Record>);

impl Sink for Records {
    fn record(&mut self, record: &Record) {
        self.0.push(*record);
    }
}

#[test]
fn numbers_read_back_bit_for_bit() {
    let loaded = config::load(&top().join(E_TYPE)).expect("it is sound");
    let dbc = dbc::text::from_bytes(&loaded.dbc_text);
    let database = Database::parse(&dbc).expect("it is sound");
    let design = design::judging(&loaded.settings, &database).expect("they fit");
    let log = spoilt(&between(&recorded("e-type-healthy.log.zst"), 115.0, 145.0));
    let reader = Box::new(Cursor::new(log.clone()));
    let mut recording = Recording::from_reader("memory", reader, Options::default());
    let (mut monitor, mut records) = (Monitor::new(design), Records::default());
    while let Some(frame) = recording.next_frame().expect("it opens") {
        monitor.take(frame, &mut records);
    }
    monitor.finish(&mut records);

    let scratch = Scratch::new();
    let (log, table) = (scratch.write("replayed.log", log), scratch.path("residuals.csv"));
    replay(&[&log], E_TYPE, &["--residuals", &table]).ok();
    let table = scratch.read("residuals.csv");
    assert_eq!(table.lines().count(), records.0.len() + 1);
    for (line, record) in table.lines().skip(1).zip(&records.0) {
        let values = [record.c1, record.c2, record.c2_corrected, record.command];
        let values = values.into_iter().chain(record.estimates).chain(record.residuals);
        let expected: Vec<Option<u64>> = values.map(|value| value.map(f64::to_bits)).collect();
        let fields: Vec<&str> = line.split(',').collect();
        let bits = |field: &&str| field.parse::<f64>().ok().map(f64::to_bits);
        assert_eq!(fields[2..11].iter().map(bits).collect::<Vec<_>>(), expected, "{line}");
    }
}

/// What a bad bus does: frames lost, late, damaged and sent again, senders and cycles silent.
#[test]
fn losses() {
    let log = between(&recorded("e-type-healthy.log.zst"), 115.0, 175.0);
    let answer = compared(&spoilt(&log), E_TYPE, "dbc/e-type.dbc");
    let at_least = |key: &str, least: u64| {
        let found = answer[key].as_u64().expect("a count");
        assert!(found >= least, "{key} is {found}, too few to show anything");
    };
    at_least("late", 50);
    at_least("twice", 20);
    at_least("missing", 100);
    at_least("refused", 200);
    at_least("gated", 2000);
    assert!(answer["restarts"].as_array().expect("a list").len() > 40, "{answer}");
}

/// `log` after a bad bus, the same in every run.
fn spoilt(log: &str) -> String {
    let mut seeded = Seeded(175);
    let mut spoilt: Vec<(i64, String)> = Vec::new();
    // Until which cycle nothing comes at all, and until which one not of this identifier.
    let (mut cycle, mut dark, mut silent) = (0, 0, (String::new(), 0));
    let mut last_of_c1 = String::new();
    for line in log.lines() {
        let (stamp, frame) = line.split_once(" can0 ").expect("a line of candump -l");
        let (id, data) = frame.split_once('#').expect("an identifier");
        let at: i64 = stamp[1..18].replace('.', "").parse().expect("digits");
        if id == "080" {
            cycle += 1;
            if seeded.chance(0.01) {
                dark = cycle + 1 + seeded.below(12);
            }
            if seeded.chance(0.02) {
                let of = ["080", "1C1", "184", "194", "1A3", "1A5"][seeded.below(6) as usize];
                silent = (of.to_owned(), cycle + 2 + seeded.below(70));
            }
        }
        if cycle < dark || (id == silent.0 && cycle < silent.1) || seeded.chance(0.01) {
            continue;
        }
        // Readings stay before 3/4 Ts, where they would be taken for those of the next cycle.
        let late = if id.starts_with("1A") { 17_000 } else { 12_000 };
        let delay = match id {
            "080" => 0,
            _ if seeded.chance(0.01) => seeded.below(late),
            _ if id.starts_with("1A") && seeded.chance(0.01) => 15_000 + seeded.below(2_000),
            _ => 0,
        };
        let mut frame = frame.to_owned();
        if id == "185" {
            // A sender that repeats itself, its counter included.
            let again = !last_of_c1.is_empty() && seeded.chance(0.02);
            frame = if again { last_of_c1.clone() } else { frame };
            last_of_c1.clone_from(&frame);
        } else if id.starts_with("18") || id.starts_with("19") {
            frame = match seeded.below(300) {
                0 => format!("{id}#FF7F{}", &data[4..]),
                1 => format!("{id}#0000{}", &data[4..]),
                2 => format!("{id}#{}01{}", &data[..8], &data[10..]),
                _ => frame,
            };
        }
        spoilt.push((at + delay as i64, frame.clone()));
        if id != "080" && seeded.chance(0.005) {
            spoilt.push((at + delay as i64 + 60, frame));
        }
    }
    spoilt.sort_by_key(|(at, _)| *at);
    let line = |(at, frame): (i64, String)| {
        format!("({}.{:06}) can0 {frame}\n", at / 1_000_000, at % 1_000_000)
    };
    spoilt.into_iter().map(line).collect()
}
