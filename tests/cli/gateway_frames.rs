//! The frames of `replay --warnings`, read by python-can and cantools: what stands on the bus is
//! what the lines of JSON and the table of residuals say.

use serde_json::Value;
use std::collections::{BTreeMap, VecDeque};
use std::fmt::Write as _;
use tertius::alarm::e2e;
use tertius_testing::oracle;
use tertius_testing::support::{
    E_TYPE, Run, Scratch, Seeded, between, recorded, recording, replay,
};

const STATUS: u64 = 0x1D1;
const WARNING: u64 = 0x2D1;
const ESTIMATE: u64 = 0x3D1;
const FAULTS: [&str; 8] = [
    "unclassified",
    "abrupt",
    "noise",
    "incipient",
    "out_of_range",
    "broken_wire",
    "frozen",
    "stale",
];
const DETECTORS: [&str; 7] = ["", "fde1", "fde2", "fde3", "plausibility", "sequential", "process"];
const SUSPECTS: [&str; 4] = ["undecided", "c1", "c2", "process"];
const LEVELS: [&str; 5] = ["none", "yellow", "orange", "red", "black"];

/// One frame as cantools decodes it.
struct Sent {
    /// µs.
    at: i64,
    id: u64,
    signals: Value,
}

impl Sent {
    fn raw(&self, signal: &str) -> i64 {
        self.signals[signal].as_i64().unwrap_or_else(|| panic!("{signal} of {}", self.signals))
    }

    fn word<'a>(&self, signal: &str, words: &[&'a str]) -> &'a str {
        words[self.raw(signal) as usize]
    }
}

/// Time in µs, identifier, interface, whether E2E holds, raw signals.
type Decoded = (i64, u64, String, bool, Value);

/// The frames of a log, each of which has to stand up to cantools and E2E.
fn sent(log: &str) -> Vec<Sent> {
    sent_by("dbc/e-type.dbc", log)
}

/// The same by another DBC.
fn sent_by(dbc: &str, log: &str) -> Vec<Sent> {
    let frames = oracle::run("gateway.py", &[dbc, log], "");
    let frames: Vec<Decoded> = serde_json::from_str(&frames).expect("JSON");
    let check = |(at, id, interface, whole, signals): Decoded| {
        assert!(whole, "E2E profile 5 does not hold at {at}: {signals}");
        assert_eq!(interface, "can0");
        Sent { at, id, signals }
    };
    frames.into_iter().map(check).collect()
}

/// µs since the epoch.
fn micros(warning: &Value) -> i64 {
    (warning["timestamp"].as_f64().expect("a number") * 1e6).round() as i64
}

/// One row of the table of residuals, as far as it is needed here.
#[derive(Clone, Copy, Debug)]
struct Row {
    /// µs since the epoch.
    opened: i64,
    r: [Option<f64>; 3],
    /// C1 − C2 as measured.
    apart: Option<f64>,
    gated: bool,
}

/// The rows of each cylinder.
fn rows(table: &str, first: i64) -> Vec<Vec<Row>> {
    let mut rows = vec![Vec::new(); 6];
    for line in table.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |i: usize| fields[i].parse::<f64>().ok();
        let cylinder: usize = fields[1].parse().expect("a number");
        rows[cylinder - 1].push(Row {
            opened: first + (number(0).expect("a time") * 1e6).round() as i64,
            r: [number(8), number(9), number(10)],
            apart: number(2).zip(number(3)).map(|(c1, c2)| c1 - c2),
            gated: fields[11] == "1",
        });
    }
    rows
}

/// What is known to stand while the frames are walked through.
struct Standing {
    warning: Value,
    last_said: i64,
}

type Key = (i64, String, String);

/// FDEs have one place in a cylinder, plausibility one for each suspect.
fn key(cylinder: i64, detector: &str, suspect: &str) -> Key {
    let place = if detector == "plausibility" { suspect } else { "" };
    (cylinder, detector.to_owned(), place.to_owned())
}

fn key_of(warning: &Value) -> Key {
    let word = |name: &str| warning[name].as_str().expect("a word");
    key(warning["cylinder"].as_i64().expect("a number"), word("detector"), word("suspect"))
}

#[test]
fn every_frame_says_what_the_lines_of_json_say() {
    let scratch = Scratch::new();
    let (log, table) = (scratch.path("sent.log"), scratch.path("residuals.csv"));
    let log_in = recording("e-type-faults.log.zst");
    let run = replay(&[&log_in], E_TYPE, &["--warnings", &log, "--residuals", &table]).ok();
    let frames = sent(&log);
    let mut told: VecDeque<Value> = run.warnings().into();
    let first = micros(&told[0]) - (told[0]["t"].as_f64().expect("a number") * 1e6).round() as i64;
    let restarts: Vec<Value> =
        run.lines().into_iter().filter(|line| line["notice"] == "restart").collect();
    assert_eq!(restarts.len(), 1, "FDE2 of cylinder 6 after its transducer was stuck");
    let walk = Walk { first, rows: rows(&scratch.read("residuals.csv"), first), restarts };

    let mut standing: BTreeMap<Key, Standing> = BTreeMap::new();
    let mut counters: BTreeMap<u64, i64> = BTreeMap::new();
    let mut next_status = first + 100_000;
    let (mut repeats, mut last) = (0, first);
    for frame in &frames {
        assert!(frame.at >= last, "frames are in the order of time");
        last = frame.at;
        let counter = counters.insert(frame.id, frame.raw("Counter"));
        let expected = counter.map_or(0, |counter| (counter + 1) % 256);
        assert_eq!(frame.raw("Counter"), expected, "counter of {:#x} at {}", frame.id, frame.at);
        for (key, standing) in &standing {
            assert!(frame.at - standing.last_said <= 1_000_000, "{key:?} was not said again");
        }
        match frame.id {
            STATUS => {
                assert_eq!(frame.at, next_status, "Fd_Status comes every 100 ms");
                next_status += 100_000;
                walk.check_status(frame, &standing);
            }
            WARNING => match told.front() {
                Some(warning) if micros(warning) == frame.at && same(warning, frame) => {
                    let raised = warning["state"] != "cleared";
                    assert_eq!(frame.raw("Raised"), i64::from(raised), "{warning}");
                    let warning = told.pop_front().expect("it was looked at");
                    walk.check_numbers(frame, &warning);
                    match warning["state"].as_str() {
                        Some("cleared") => drop(standing.remove(&key_of(&warning))),
                        _ => {
                            let last_said = frame.at;
                            standing.insert(key_of(&warning), Standing { warning, last_said });
                        }
                    }
                }
                _ => {
                    repeats += 1;
                    let key = key(
                        frame.raw("Cylinder"),
                        frame.word("Detector", &DETECTORS),
                        frame.word("Suspect", &SUSPECTS),
                    );
                    let standing = standing.get_mut(&key).expect("only what stands is repeated");
                    assert!(same(&standing.warning, frame), "{}", frame.signals);
                    assert_eq!(frame.at - standing.last_said, 1_000_000, "{key:?}");
                    assert_eq!(frame.raw("Raised"), 1);
                    standing.last_said = frame.at;
                    walk.check_repeated_residual(frame);
                }
            },
            other => panic!("the gateway sent {other:#x}"),
        }
    }
    assert_eq!(told, [] as [Value; 0], "every warning is on the bus");
    assert!(repeats > 100, "{repeats} repetitions");
    assert!(next_status > first + 479_900_000, "Fd_Status to the end");
}

/// Whether a frame tells of `warning`, numbers aside.
fn same(warning: &Value, frame: &Sent) -> bool {
    warning["cylinder"] == frame.raw("Cylinder")
        && warning["detector"] == frame.word("Detector", &DETECTORS)
        && warning["fault"] == frame.word("Fault", &FAULTS)
        && warning["suspect"] == frame.word("Suspect", &SUSPECTS)
        && warning["level"] == frame.word("Level", &LEVELS)
}

struct Walk {
    first: i64,
    rows: Vec<Vec<Row>>,
    restarts: Vec<Value>,
}

impl Walk {
    fn check_numbers(&self, frame: &Sent, warning: &Value) {
        match warning["residual"].as_f64() {
            Some(residual) => {
                let apart = frame.raw("Residual") as f64 * 1e-5 - residual;
                assert!(apart.abs() <= 0.500_001e-5, "{} against {warning}", frame.signals);
            }
            None => assert_eq!(frame.raw("Residual"), -32768, "the count that means none"),
        }
        match (warning["threshold"].as_f64(), frame.raw("Threshold")) {
            (Some(threshold), 255) => assert!(threshold > 0.0127, "{warning}"),
            (Some(threshold), raw) => {
                assert!((raw as f64 * 5e-5 - threshold).abs() <= 2.500_001e-5, "{warning}");
            }
            (None, raw) => assert_eq!(raw, 0),
        }
    }

    /// The two newest rows of a cylinder: of the open cycle, if it was evaluated, and before.
    fn newest(&self, cylinder: i64, at: i64) -> &[Row] {
        let rows = &self.rows[cylinder as usize - 1];
        let end = rows.partition_point(|row| row.opened <= at);
        &rows[end.saturating_sub(2)..end]
    }

    fn check_repeated_residual(&self, frame: &Sent) {
        let detector = frame.raw("Detector") as usize;
        let raw = frame.raw("Residual");
        if detector > 3 {
            return assert_eq!(raw, -32768);
        }
        let (cylinder, i) = (frame.raw("Cylinder"), detector - 1);
        let newest = self.newest(cylinder, frame.at);
        let judged = |row: &&Row| detector == 3 || self.judges(row, cylinder, i);
        // Critical is what the machine itself measures.
        let critical = detector == 3 && frame.raw("Threshold") == 255;
        let told = |row: &Row| if critical { row.apart } else { row.r[i] };
        let mut found = newest.iter().filter(judged).filter_map(told).peekable();
        // While nothing is judged the last one that was stands, which is not to be found here.
        assert!(
            found.peek().is_none() || found.any(|r| (r - raw as f64 * 1e-5).abs() <= 0.500_001e-5),
            "{} against {newest:?}",
            frame.signals
        );
    }

    fn check_status(&self, frame: &Sent, standing: &BTreeMap<Key, Standing>) {
        let standing: Vec<&Value> = standing.values().map(|standing| &standing.warning).collect();
        assert_eq!(frame.raw("ActiveWarnings"), standing.len() as i64, "at {}", frame.at);
        let level = |warning: &&Value| LEVELS.iter().position(|level| warning["level"] == *level);
        let level = standing.iter().filter_map(level).max().unwrap_or(0);
        assert_eq!(frame.raw("Level"), level as i64, "at {}", frame.at);

        let mut all_judge = [true; 2];
        for cylinder in 1..=6 {
            let of_cylinder = standing.iter().filter(|warning| warning["cylinder"] == cylinder);
            let blamed: Vec<&str> = of_cylinder.filter_map(|w| w["suspect"].as_str()).collect();
            for (i, name) in ["c1", "c2"].into_iter().enumerate() {
                let found = frame.raw(&format!("Cyl{cylinder}_{}_State", name.to_uppercase()));
                let newest = self.newest(cylinder, frame.at);
                let judged = [0, 1].map(|age| {
                    let row = newest.iter().rev().nth(age);
                    row.is_some_and(|row| self.judges(row, cylinder, i))
                });
                (0..2).for_each(|age| all_judge[age] &= judged[age]);
                let expected = judged.map(|judged| match () {
                    () if blamed.contains(&name) => 3,
                    () if blamed.contains(&"undecided") => 2,
                    () if judged && !blamed.contains(&"process") => 1,
                    () => 0,
                });
                let place = format!("cylinder {cylinder}, {name}, at {}", frame.at);
                assert!(expected.contains(&found), "{place}: {found}, not {expected:?}");
            }
        }
        let started = frame.at - self.first > 1_030_000;
        let expected = all_judge.map(|all| match () {
            () if all => 1,
            () if started => 3,
            () => 0,
        });
        assert!(expected.contains(&frame.raw("Mode")), "{} at {}", frame.signals, frame.at);
    }

    /// Whether the observer on transducer `i` could judge in this row.
    fn judges(&self, row: &Row, cylinder: i64, i: usize) -> bool {
        let settling = |restart: &Value| {
            restart["cylinder"] == cylinder
                && restart["detector"] == DETECTORS[i + 1]
                && (-10_000..990_000).contains(&(row.opened - micros(restart)))
        };
        !row.gated && row.r[i].is_some() && !self.restarts.iter().any(settling)
    }
}

/// What a replay said, without what it counted.
fn said(run: &Run) -> Vec<Value> {
    run.lines().into_iter().filter(|line| line["type"] != "summary").collect()
}

#[test]
fn whatever_arrives_the_gateway_sends_only_its_own_and_hears_only_its_inputs() {
    let scratch = Scratch::new();
    let log = between(&recorded("e-type-faults.log.zst"), 55.0, 70.0);
    let plain = scratch.write("plain.log", &log);
    let sent_plain = scratch.path("plain.sent");
    let quiet = replay(&[&plain], E_TYPE, &["--warnings", &sent_plain]).ok();
    assert!(quiet.warnings().len() >= 4);

    let mut seeded = Seeded(0x1D1);
    let own = scratch.read("plain.sent");
    let mut own = own.lines().cycle();
    let (mut noisy, mut added) = (String::new(), 0);
    for (index, line) in log.lines().enumerate() {
        _ = writeln!(noisy, "{line}");
        if index + 1 == log.lines().count() || !seeded.chance(0.3) {
            continue;
        }
        added += 1;
        let (stamp, _) = line.split_once(" can0 ").expect("a line of candump -l");
        let data = format!("{:016X}", seeded.next());
        let frame = match seeded.below(8) {
            // The gateway's own, as sent, as someone else would send them, and Fd_Estimate.
            0 => own.next().expect("it sent some")[25..].to_owned(),
            1 => format!("{:03X}#{data}", [STATUS, WARNING, 0x3D1][seeded.below(3) as usize]),
            // Identifiers of inputs in other forms: extended, remote, error.
            2 => format!("{:08X}#{data}", 0x181 + seeded.below(6)),
            3 => format!("{:03X}#R", 0x181 + seeded.below(6)),
            4 => format!("{:08X}#{data}", 0x2000_0000 + 0x80 + seeded.below(8)),
            5 => format!("{:08X}##1{data}", seeded.below(1 << 29)),
            // CANopen: NMT, emergencies, SDO, heartbeats.
            6 => format!("{:03X}#{data}", [0, 0x81, 0x601, 0x581, 0x701][seeded.below(5) as usize]),
            _ => format!("{:03X}#{data}", 0x400 + seeded.below(0x400)),
        };
        _ = writeln!(noisy, "{stamp} can0 {frame}");
    }
    assert!(added > 3000, "{added}");
    let noisy = scratch.write("noisy.log", noisy);
    let sent_noisy = scratch.path("noisy.sent");
    let run = replay(&[&noisy], E_TYPE, &["--warnings", &sent_noisy]).ok();

    assert_eq!(said(&run), said(&quiet));
    assert_eq!(scratch.read("noisy.sent"), scratch.read("plain.sent"));
    let more = |key: &str| run.summary()[key].as_u64().zip(quiet.summary()[key].as_u64());
    for key in ["frames", "ignored_frames"] {
        assert!(more(key).is_some_and(|(noisy, quiet)| noisy == quiet + added), "{key}");
    }
    let other = scratch.read("noisy.sent");
    let other = other.lines().find(|line| !line.contains(" 1D1#") && !line.contains(" 2D1#"));
    assert_eq!(other, None);
}

/// A row of the table of estimates.
struct Estimated {
    opened: f64,
    cylinder: i64,
    /// m.
    position: Option<f64>,
    sigma: Option<f64>,
    valid: bool,
    source: String,
}

impl Estimated {
    fn read(line: &str) -> Self {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(fields.len(), 7, "{line}");
        let number = |i: usize| fields[i].parse::<f64>().ok();
        Self {
            opened: number(0).expect("a time"),
            cylinder: fields[1].parse().expect("a number"),
            position: number(2),
            sigma: number(3),
            valid: fields[4] == "1",
            source: fields[5].to_owned(),
        }
    }

    fn check(&self, frame: &Sent) {
        let told = format!("{} for {:?} ± {:?}", frame.signals, self.position, self.sigma);
        assert_eq!(frame.raw("Cylinder"), self.cylinder, "{told}");
        assert_eq!(frame.raw("Valid"), i64::from(self.valid), "{told}");
        let micrometres = self.sigma.map_or(f64::INFINITY, |sigma| (sigma * 1e6).ceil());
        assert_eq!(frame.raw("Sigma") as f64, micrometres.min(65_535.0), "{told}");
        let counts = self.position.map_or(0.0, |position| (position + 1.5) * 27_648.0 / 3.0);
        let expected = if self.valid { counts } else { 0.0 };
        assert!((frame.raw("Position") as f64 - expected).abs() <= 0.500_001, "{told}");
    }
}

#[test]
fn every_estimate_on_the_bus_is_the_one_in_the_table() {
    let scratch = Scratch::new();
    let (log, plain) = (scratch.path("sent.log"), scratch.path("plain.log"));
    let table = scratch.path("estimates.csv");
    let log_in = recording("e-type-faults.log.zst");
    let tables = "[estimate]\nsend = true\n\n[gateway]\nbus_share = 0.15\n\n[plausibility]";
    let config = scratch.config(&[("[plausibility]", tables)]);
    replay(&[&log_in], &config, &["--warnings", &log, "--estimates", &table]).ok();
    replay(&[&log_in], E_TYPE, &["--warnings", &plain]).ok();

    let table = scratch.read("estimates.csv");
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("t,cylinder,estimate,sigma,valid,source,without"));
    let rows: Vec<Estimated> = lines.map(Estimated::read).collect();
    let frames = sent(&log);
    let first = frames[0].at;
    let estimates = || frames.iter().filter(|frame| frame.id == ESTIMATE);
    assert_eq!(estimates().count(), rows.len(), "each row is sent");
    assert_eq!(rows.len(), 6 * 24_000, "for each cylinder in each cycle");
    for (k, (frame, row)) in estimates().zip(&rows).enumerate() {
        row.check(frame);
        assert_eq!(frame.raw("Counter"), k as i64 % 256);
        let late = (frame.at - first) as f64 * 1e-6 - row.opened;
        assert!((-0.02..0.02).contains(&late), "{late} s after the opening of its cycle");
    }
    for source in ["both", "c1", "c2"] {
        let valid = rows.iter().filter(|row| row.source == source && row.valid).count();
        assert!(valid > 0, "{source}");
    }
    let invalid = rows.iter().filter(|row| !row.valid).count();
    assert!((6 * 49..6 * 2400).contains(&invalid), "{invalid}: the first second, and doubts");

    // All else is as without them.
    let others = |log: &str| -> Vec<String> {
        scratch.read(log).lines().filter(|it| !it.contains(" 3D1#")).map(str::to_owned).collect()
    };
    assert!(others("sent.log") == others("plain.log"));
}

/// A machine that reaches from -3 m to 0 m, and an Fd_Estimate of its DBC that has room for it.
#[test]
fn estimates_are_on_the_scale_of_the_dbc() {
    const OURS: &str = "(0.00010850694444444444,-1.5) [-1.49989149305556|1.5]";
    let scratch = Scratch::new();
    let log_in = between(&recorded("e-type-faults.log.zst"), 0.0, 20.0);
    let log_in = scratch.write("part.log", log_in);
    let tables = "[estimate]\nsend = true\n\n[gateway]\nbus_share = 0.15\n\n[plausibility]";
    let config = scratch.config(&[("[plausibility]", tables), ("[-1.5, 1.5]", "[-3.0, 0.0]")]);
    let dbc = scratch.read("e-type.dbc");
    let estimate = format!(" SG_ Position : 32|16@1+ {OURS}");
    let sigma = " SG_ Sigma : 48|16@1+ (0.000001,0) [0|0.065535]";
    assert!(dbc.contains(&estimate) && dbc.contains(sigma));
    let dbc = dbc
        .replace(&estimate, " SG_ Position : 32|16@1+ (0.00005,-3.001) [-3.00095|0.27575]")
        .replace(sigma, " SG_ Sigma : 48|16@1+ (0.000002,0) [0|0.13107]")
        .replace(OURS, "(0.00010850694444444444,-3.0) [-2.99989149305556|0]");
    let dbc = scratch.write("e-type.dbc", dbc);
    let (log, table) = (scratch.path("sent.log"), scratch.path("estimates.csv"));
    replay(&[&log_in], &config, &["--warnings", &log, "--estimates", &table]).ok();

    let table = scratch.read("estimates.csv");
    let rows: Vec<Estimated> = table.lines().skip(1).map(Estimated::read).collect();
    let frames = sent_by(&dbc, &log);
    let estimates = frames.iter().filter(|frame| frame.id == ESTIMATE);
    assert_eq!(estimates.clone().count(), rows.len());
    let mut far = 0;
    for (frame, row) in estimates.zip(&rows) {
        assert_eq!(frame.raw("Valid"), i64::from(row.valid), "{}", frame.signals);
        let sigma = frame.raw("Sigma") as f64 * 2e-6;
        let told = row.sigma.map_or(0.13107, |sigma| sigma.min(0.13107));
        assert!((-1e-9..2e-6).contains(&(sigma - told)), "{}, σ {told}", frame.signals);
        if let (true, Some(position)) = (row.valid, row.position) {
            let metres = frame.raw("Position") as f64 * 5e-5 - 3.001;
            assert!((metres - position).abs() <= 2.500_001e-5, "{} at {position}", frame.signals);
            far += u32::from(position < -1.5);
        }
    }
    assert!(far > 1000, "{far} valid estimates beyond the default scale");
}

#[test]
fn another_node_has_other_identifiers_and_data_ids() {
    let scratch = Scratch::new();
    let log = between(&recorded("e-type-faults.log.zst"), 58.0, 62.0);
    let log = scratch.write("part.log", log);
    let tables =
        "[gateway]\nnode = 127\nbus_share = 0.1\n\n[estimate]\nsend = true\n\n[plausibility]";
    let config = scratch.config(&[("[plausibility]", tables)]);
    replay(&[&log], &config, &["--warnings", &scratch.path("sent.log")]).ok();
    let sent = scratch.read("sent.log");
    let mut kinds = BTreeMap::new();
    for line in sent.lines() {
        let (_, frame) = line.split_once(" can0 ").expect("a line of candump -l");
        let (id, data) = frame.split_once('#').expect("an identifier");
        let id = u16::from_str_radix(id, 16).expect("hexadecimal");
        let byte = |i: usize| u8::from_str_radix(&data[2 * i..2 * i + 2], 16);
        let data: Vec<u8> = (0..8).map(|i| byte(i).expect("hexadecimal")).collect();
        assert!(e2e::check(&data, id).is_ok(), "{line}");
        *kinds.entry(id).or_insert(0) += 1;
    }
    assert_eq!(kinds.keys().copied().collect::<Vec<_>>(), [0x1FF, 0x2FF, 0x3FF], "{kinds:?}");
    assert!(kinds[&0x2FF] >= 3, "{kinds:?}");
}
