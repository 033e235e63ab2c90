//! What the kept recordings lead to, as files that a person reads in a review.
//!
//! `UPDATE_GOLDEN=1 cargo test --test cli golden` writes what is found now; look at the difference
//! before it is taken in.

use crc::{CRC_64_XZ, Crc};
use serde_json::Value;
use std::collections::BTreeMap;
use std::env;
use std::fmt::Write as _;
use std::fs;
use tertius_testing::support::{
    E_TYPE, HANGING_LOAD, Run, Scratch, recording, replay, tertius, top,
};

/// After a fault has gone its warnings clear, and its going is a step that the observers see, s.
const AFTERMATH: f64 = 5.0;

/// These with the tables of `tertius calibrate` for the sequential detectors.
const SEQUENTIAL: &str = "tests/recordings/e-type-sequential.toml";
const HANGING_SEQUENTIAL: &str = "tests/recordings/hanging-load-sequential.toml";

const CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_XZ);

fn replayed(name: &str, config: &str) -> Run {
    replay(&[&recording(name)], config, &[]).ok()
}

/// Compares `found` with the file `name` of tests/golden.
#[track_caller]
fn golden(name: &str, found: &str) {
    let path = top().join("tests/golden").join(name);
    if env::var_os("UPDATE_GOLDEN").is_some_and(|value| value == "1") {
        return fs::write(&path, found).expect("it can be written");
    }
    let expected = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        expected == found,
        "tests/golden/{name} is another one now:\n{}\n\
         If that is what it should be: UPDATE_GOLDEN=1 cargo test --test cli golden",
        difference(&expected, found)
    );
}

/// The lines that are only in one of two texts, by their longest common subsequence.
fn difference(expected: &str, found: &str) -> String {
    let (old, new): (Vec<&str>, Vec<&str>) = (expected.lines().collect(), found.lines().collect());
    let mut common = vec![vec![0_usize; new.len() + 1]; old.len() + 1];
    for i in (0..old.len()).rev() {
        for j in (0..new.len()).rev() {
            common[i][j] = if old[i] == new[j] {
                common[i + 1][j + 1] + 1
            } else {
                common[i + 1][j].max(common[i][j + 1])
            };
        }
    }
    let (mut i, mut j, mut text) = (0, 0, String::new());
    while i < old.len() || j < new.len() {
        if i < old.len() && j < new.len() && old[i] == new[j] {
            (i, j) = (i + 1, j + 1);
        } else if j == new.len() || (i < old.len() && common[i + 1][j] >= common[i][j + 1]) {
            _ = writeln!(text, "{:>4} - {}", i + 1, old[i]);
            i += 1;
        } else {
            _ = writeln!(text, "{:>4} + {}", j + 1, new[j]);
            j += 1;
        }
    }
    text
}

/// A row of a recording's `.truth.csv`.
#[derive(Debug)]
struct Truth {
    cylinder: u64,
    transducer: String,
    kind: String,
    begin: f64,
    end: f64,
    size: String,
}

fn truth(name: &str) -> Vec<Truth> {
    let text = fs::read_to_string(top().join(recording(name))).expect("the truth is there");
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |i: usize| fields[i].parse::<f64>().expect("a number");
        let kind = fields[2].to_owned();
        let unit = match &*kind {
            "drift" => " mm/s",
            "step" | "noise" | "incipient" => " mm",
            _ => "",
        };
        let size = if unit.is_empty() { number(4) } else { number(4) * 1e3 };
        Truth {
            cylinder: fields[0].parse().expect("a number"),
            transducer: fields[1].to_lowercase(),
            kind,
            begin: number(3),
            end: number(6),
            size: format!("{}{unit}", (size * 1e6).round() / 1e6),
        }
    };
    text.lines().skip(1).map(row).collect()
}

/// The truth, each fault with the warnings that belong to it: those of its cylinder from its begin
/// until [`AFTERMATH`] after its end.
fn beside_the_truth(truth: &[Truth], warnings: &[Value], incidents: &[Value]) -> String {
    let mut text = "Each fault of the truth, and the warnings that belong to it; times from its \
                    begin.\n"
        .to_owned();
    let mut left: Vec<&Value> = warnings.iter().collect();
    for fault in truth {
        let time = |warning: &Value| warning["t"].as_f64().expect("a number");
        let belongs = |warning: &&Value| {
            warning["cylinder"] == fault.cylinder
                && (fault.begin..fault.end + AFTERMATH).contains(&time(warning))
        };
        let (its, others): (Vec<_>, Vec<_>) = left.into_iter().partition(belongs);
        left = others;
        text += &heading(fault, &its);
        its.iter().for_each(|warning| text += &line(warning, fault.begin));
    }
    _ = writeln!(text, "\nWarnings that belong to no fault: {}", left.len());
    left.iter().for_each(|warning| text += &line(warning, 0.0));
    text + &as_incidents(incidents)
}

/// The incidents as a person reads them, each as it was told last.
fn as_incidents(incidents: &[Value]) -> String {
    let mut newest: BTreeMap<u64, &Value> = BTreeMap::new();
    for incident in incidents {
        newest.insert(incident["incident"].as_u64().expect("a number"), incident);
    }
    let mut text = "\nThe incidents, from begin to end:\n".to_owned();
    for (number, incident) in newest {
        let time =
            |key: &str| incident[key].as_f64().map_or("stands".to_owned(), |t| format!("{t:.3} s"));
        let ending = incident["ending"].as_str().unwrap_or("–");
        let summary = word(incident, "summary");
        _ = writeln!(
            text,
            "{number:>3}  {} to {}, {ending}: {summary}",
            time("begin"),
            time("end")
        );
        _ = writeln!(text, "     {}", word(incident, "evidence"));
    }
    text
}

fn heading(fault: &Truth, warnings: &[&Value]) -> String {
    let Truth { cylinder, transducer, kind, begin, end, size } = fault;
    let told = in_a_word(fault, warnings);
    let lasting = end - begin;
    format!(
        "\n{begin} s: cylinder {cylinder}, {transducer}, {kind} {size}, for {lasting} s: {told}\n"
    )
}

/// How fast, and whom the first detector blames a fifth of a second later, while the fault is there.
fn in_a_word(fault: &Truth, warnings: &[&Value]) -> String {
    let Some(first) = warnings.first().filter(|w| w["t"].as_f64() < Some(fault.end)) else {
        return "not detected".to_owned();
    };
    let t = first["t"].as_f64().expect("a number");
    let decided =
        |w: &&&Value| w["detector"] == first["detector"] && w["t"].as_f64() <= Some(t + 0.2);
    let blamed = warnings.iter().rfind(decided).map_or("", |w| word(w, "suspect"));
    let verdict = match blamed {
        "undecided" => "undecided",
        blamed if blamed == fault.transducer => "the right one",
        _ => "WRONG",
    };
    format!("{} after {:.3} s, {verdict}", word(first, "detector"), t - fault.begin)
}

fn word<'a>(warning: &'a Value, key: &str) -> &'a str {
    warning[key].as_str().expect("a word")
}

fn line(warning: &Value, begin: f64) -> String {
    let millimetres = |key: &str| {
        warning[key].as_f64().map_or("–".to_owned(), |metres| format!("{:.3} mm", metres * 1e3))
    };
    let text = format!(
        "{:>+10.3} s  {:<12}  {:<7}  {:<12}  {:<9}  {:<6}  {:>10} of {:>9}",
        warning["t"].as_f64().expect("a number") - begin,
        word(warning, "detector"),
        word(warning, "state"),
        word(warning, "fault"),
        word(warning, "suspect"),
        word(warning, "level"),
        millimetres("residual"),
        millimetres("threshold"),
    );
    let scale = |percent: f64| format!("  scale {percent:+.2} %");
    text + &warning["gain_percent"].as_f64().map_or(String::new(), scale) + "\n"
}

/// A summary, one field a line, so that a difference is seen.
fn readable(summary: &Value) -> String {
    serde_json::to_string_pretty(summary).expect("it was JSON") + "\n"
}

fn worst_r3(summary: &Value) -> f64 {
    let cylinders = summary["cylinders"].as_array().expect("a list");
    cylinders.iter().filter_map(|c| c["worst_r3"].as_f64()).fold(0.0, f64::max)
}

#[test]
fn faults() {
    let run = replayed("e-type-faults.log.zst", E_TYPE);
    golden("e-type-faults.jsonl", &run.stdout);
    let truth = truth("e-type-faults.truth.csv");
    assert_eq!(truth.len(), 14);
    golden("e-type-faults.txt", &beside_the_truth(&truth, &run.warnings(), &run.incidents()));
}

/// The same with the sequential detectors beside the thresholds; calibrated on the healthy recording.
#[test]
fn faults_by_evidence() {
    let run = replayed("e-type-faults.log.zst", SEQUENTIAL);
    let truth = truth("e-type-faults.truth.csv");
    golden(
        "e-type-faults.sequential.txt",
        &beside_the_truth(&truth, &run.warnings(), &run.incidents()),
    );
    // Every word of theirs has its size and its onset; of a gain it says how large it is, and that of
    // the truth is 1 %.
    let (mut scales, warnings) = (0, run.warnings());
    for warning in warnings.iter().filter(|w| w["detector"] == "sequential") {
        assert_eq!(warning["size"], warning["residual"], "{warning}");
        assert!(warning["onset"].as_f64() <= warning["t"].as_f64(), "{warning}");
        let Some(percent) = warning["gain_percent"].as_f64() else {
            assert_eq!(warning.get("shape"), None, "{warning}");
            continue;
        };
        let named = (&warning["shape"], &warning["fault"]);
        assert_eq!(named, (&"scale".into(), &"unclassified".into()), "{warning}");
        assert!((percent - 1.0).abs() < 0.05, "{warning}");
        scales += 1;
    }
    assert_eq!(scales, 2, "changed and cleared");
    let healthy = replayed("e-type-healthy.log.zst", SEQUENTIAL);
    assert_eq!(healthy.lines().len(), 1, "nothing but a summary: {}", healthy.stdout);
}

/// All that long replays write with everything on, by checksum: the core has its functions from libm, so
/// that it is the same with every C library and on every processor.
#[test]
fn every_byte() {
    let scratch = Scratch::new();
    let mut text = String::new();
    for log in ["e-type-faults.log.zst", "e-type-coarse.log.zst"] {
        let paths = ["residuals.csv", "estimates.csv", "warnings.log"].map(|it| scratch.path(it));
        let [residuals, estimates, warnings] = &paths;
        let options = ["--residuals", residuals, "--estimates", estimates, "--warnings", warnings];
        let run =
            replay(&[&recording(log)], SEQUENTIAL, &[&options[..], &["--force"]].concat()).ok();
        let mut told = |name: &str, bytes: &[u8]| {
            let digest = CRC.checksum(bytes);
            _ = writeln!(text, "{log} {name}: {} bytes, CRC-64 {digest:016x}", bytes.len());
        };
        told("standard output", run.stdout.as_bytes());
        for path in &paths {
            let name = path.rsplit('/').next().expect("it has a name");
            told(name, &fs::read(path).expect("it was written"));
        }
    }
    golden("every-byte.txt", &text);
}

#[test]
fn a_healthy_machine_is_quiet() {
    let run = replayed("e-type-healthy.log.zst", E_TYPE);
    assert_eq!(run.lines().len(), 1, "nothing but a summary: {}", run.stdout);
    assert!(worst_r3(&run.summary()) < 1.5e-3);
    golden("e-type-healthy.summary.json", &readable(&run.summary()));
}

#[test]
fn coarse_transducers_are_at_the_thresholds() {
    let run = replayed("e-type-coarse.log.zst", E_TYPE);
    assert_eq!(run.summary()["warnings"]["fde3"], 0);
    assert!(worst_r3(&run.summary()) < 1.5e-3);
    golden("e-type-coarse.summary.json", &readable(&run.summary()));
}

/// The model is another machine's: its observers disagree with the rig, and FDE3 does not.
#[test]
fn a_rig_with_a_foreign_model() {
    let run = replayed("hanging-load.log.gz", HANGING_LOAD);
    assert_eq!(run.summary()["warnings"]["fde3"], 0);
    assert!(worst_r3(&run.summary()) < 1.5e-3);
    // The observer that crosses first is believed until the other one crosses, a cycle or two later.
    let warnings = run.warnings();
    for (index, first) in warnings.iter().enumerate().filter(|(_, w)| w["suspect"] != "process") {
        let time = |warning: &Value| warning["t"].as_f64().expect("a number");
        let later = warnings[index + 1..].iter().find(|w| w["detector"] == first["detector"]);
        let corrected =
            later.is_some_and(|w| w["suspect"] == "process" && time(w) < time(first) + 0.05);
        assert!(corrected, "a transducer is blamed for what the model gets wrong: {first}");
    }
    golden("hanging-load.summary.json", &readable(&run.summary()));
}

/// A rig that rests for minutes, on little calibration: each fault alone, put into the healthy recording.
/// The observers have another machine's model and blame the process all the time.
#[test]
fn a_rig_by_evidence() {
    let healthy = replayed("hanging-load.log.gz", HANGING_SEQUENTIAL);
    let sequential = |warning: &Value| warning["detector"] == "sequential";
    assert!(!healthy.warnings().iter().any(sequential), "{}", healthy.stdout);
    let scratch = Scratch::new();
    let table = fs::read_to_string(recording("hanging-load.faults.csv")).expect("it is there");
    let faults = truth("hanging-load.faults.csv");
    assert_eq!(faults.len(), 10);
    let mut text =
        "Each fault alone, and the warnings while it is there; times from its begin.\n".to_owned();
    for (fault, row) in faults.iter().zip(table.lines().skip(1)) {
        let columns = table.lines().next().expect("a heading");
        scratch.write("fault.csv", format!("{columns}\n{row}\n"));
        let (faulty, csv) = (scratch.path("faulty.log"), scratch.path("fault.csv"));
        let log = recording("hanging-load.log.gz");
        let rig = [
            "inject",
            &log,
            "--config",
            HANGING_LOAD,
            "--faults",
            &csv,
            "--output",
            &faulty,
            "--force",
        ];
        tertius(&rig, b"").ok();
        let warnings = replay(&[&faulty], HANGING_SEQUENTIAL, &[]).ok().warnings();
        let there =
            |w: &&Value| w["t"].as_f64().is_some_and(|t| (fault.begin..fault.end).contains(&t));
        let by_model = |w: &&Value| w["detector"] == "fde1" || w["detector"] == "fde2";
        let (model, others): (Vec<&Value>, Vec<&Value>) =
            warnings.iter().filter(there).partition(by_model);
        text += &heading(fault, &others);
        others.iter().for_each(|warning| text += &line(warning, fault.begin));
        let raised = |suspect: &str| {
            model.iter().filter(|w| w["state"] == "raised" && w["suspect"] == suspect).count()
        };
        let [process, c1, c2, open] = ["process", "c1", "c2", "undecided"].map(raised);
        _ = writeln!(
            text,
            "      fde1, fde2: {process} process, {c1} c1, {c2} c2, {open} undecided"
        );
        for warning in others.iter().filter(|w| sequential(w)) {
            let suspect = word(warning, "suspect");
            assert!(suspect == "undecided" || suspect == fault.transducer, "{warning}");
        }
    }
    golden("hanging-load-faults.sequential.txt", &text);
}
