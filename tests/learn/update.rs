//! `--update`: what is learnt on several days adds up, and what is no healthy machine is left out.

use crate::yard::{Yard, moved, tertius};
use std::fs;
use tertius::frame::{Frame, Id, Kind, MAX_DATA};
use tertius::learnt::{Learnt, MOST_BYTES, Packing, Seals};
use tertius::time::Timestamp;
use tertius_testing::support::{Run, Seeded};
use toml::{Table, Value};

/// Of a simulated recording's first frame, s.
const BEGIN: i64 = 1_700_000_000;

const DAY: i64 = 86_400;

impl Yard {
    fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).expect("it was written")
    }

    /// A recording in this sea, so many days after the first.
    fn record(&self, name: &str, sea: &str, seconds: i64, day: i64) -> String {
        let seed = (31 + day).to_string();
        self.simulate("first.log", [sea, &seed], seconds, &["--force"]);
        self.0.write(name, moved(&self.read("first.log"), day * DAY))
    }

    /// The same recording with a fault.
    fn faulty(&self, log: &str, fault: &str) -> String {
        self.inject(log, "faulty.log", &[fault])
    }

    fn learn(&self, command: &str, logs: &[&str], config: &str, more: &[&str]) -> Run {
        let config = self.path(config);
        let into: &[&str] = if command == "calibrate" { &["--into", &config] } else { &[] };
        tertius(&[&[command], logs, &["--config", &config], into, more].concat())
    }

    fn update(&self, command: &str, log: &str) -> Run {
        self.learn(command, &[log], "config.toml", &["--update"])
    }

    fn table(&self, name: &str) -> Table {
        self.read(name).parse().expect("TOML")
    }

    fn learnt(&self) -> Learnt {
        Learnt::parse(&self.bytes("config.learnt")).expect("it is whole")
    }

    /// What the call changes of the configuration and of what is kept: nothing.
    #[track_caller]
    fn unchanged(&self, call: impl FnOnce() -> Run) -> Run {
        let before = ["config.toml", "config.learnt"].map(|name| self.bytes(name));
        let run = call();
        assert!(before == ["config.toml", "config.learnt"].map(|name| self.bytes(name)));
        run
    }
}

fn sequential(table: &Table) -> Vec<&Value> {
    let cylinders = table["cylinder"].as_array().expect("they are learnt").iter();
    cylinders.map(|cylinder| &cylinder["sequential"]).collect()
}

fn numbers(value: &Value, key: &str) -> Vec<f64> {
    let values = value[key].as_array().expect("an array").iter();
    values.map(|value| value.as_float().expect("a number")).collect()
}

/// What the nodes of all cylinders are known to, m; known are those that three of it leave at 0.2 mm.
fn deviations(table: &Table) -> Vec<f64> {
    sequential(table).into_iter().flat_map(|it| numbers(it, "node_deviations")).collect()
}

fn known(table: &Table) -> usize {
    deviations(table).iter().filter(|deviation| 3.0 * **deviation <= 2e-4).count()
}

#[test]
fn two_days_one_after_the_other_teach_what_both_together_teach() {
    let yard = Yard::new();
    let first = yard.record("first-day.log", "1.8,7", 300, 0);
    let second = yard.record("second-day.log", "2.5,8", 300, 1);
    let before = yard.read("config.toml");
    yard.0.write("both.toml", &before);
    yard.update("commission", &first).ok();
    let one = yard.table("config.toml");
    let dry = |more: &[&str]| yard.learn("commission", &[&second], "config.toml", more);
    yard.unchanged(|| dry(&["--update", "--dry-run"]).ok());
    let run = yard.update("commission", &second).ok();
    assert!(run.stdout.contains("with what is kept of 1 recording earlier"), "{}", run.stdout);
    let two = yard.table("config.toml");
    let run = yard.learn("commission", &[&first, &second], "both.toml", &[]).ok();
    // A day without frames is no hour that was tried, and no place for a fault.
    assert!(run.stdout.contains("learnt from all 10.0 min recorded in"), "{}", run.stdout);
    assert!(run.stdout.contains("second-day.log with configuration "), "{}", run.stdout);
    assert!(run.stdout.contains("h after 300.0 s counts as a minute"), "{}", run.stdout);
    let both = yard.table("both.toml");
    for key in ["model", "cylinder", "comparator"] {
        assert_eq!(two[key], both[key], "to the last digit");
    }
    // The search for weights begins at those that stand.
    let high = |table: &Table| table["fde"]["high"].as_float().expect("a number");
    assert!((high(&two) / high(&both) - 1.0).abs() < 0.05, "{} {}", high(&two), high(&both));

    assert!(known(&two) > known(&one) + 6, "{} {}", known(&two), known(&one));
    let sums = [&two, &one].map(|table| {
        let pairs = deviations(table).into_iter().zip(deviations(&one));
        pairs.filter(|(_, one)| *one < 2e-5).map(|(it, _)| it).sum::<f64>()
    });
    assert!(sums[0] < 0.9 * sums[1], "{sums:?}");

    // Twice the same counts once.
    let run = yard.unchanged(|| yard.update("commission", &second).ok());
    assert!(run.stdout.contains("was already learnt"), "{}", run.stdout);
    // And the same with something of it is not another one.
    let part = ["--update", "--to", "200"];
    let again = |more: &[&str]| yard.learn("commission", &[&second], "config.toml", more);
    yard.unchanged(|| again(&part).failed(2, &["overlaps with one that was learnt"]));

    let learnt = yard.learnt();
    assert_eq!((learnt.parts.len(), learnt.pieces.len()), (2, 10));
    let minute = learnt.bytes() / learnt.pieces.len();
    assert!(minute < 200_000, "{minute} bytes a minute, of 2.1 MB in a recording");
}

#[test]
fn what_was_learnt_under_other_tables_is_not_mixed_with_these() {
    let yard = Yard::new();
    let first = yard.record("first-day.log", "2.5,8", 240, 0);
    let second = yard.record("second-day.log", "2.5,8", 240, 1);
    yard.update("commission", &first).ok();
    let (text, kept) = (yard.read("config.toml"), yard.bytes("config.learnt"));
    let with = |key: &str, value: &str| {
        let at = text.find(&format!("\n{key} = ")).expect("it is there") + 1;
        let end = at + text[at..].find('\n').expect("a line");
        format!("{}{key} = {value}{}", &text[..at], &text[end..])
    };
    let refused = |text: &str, words: &[&str]| {
        yard.0.write("config.toml", text);
        yard.unchanged(|| yard.update("commission", &second).failed(2, words));
    };
    for (key, value, told) in [
        ("theta", "[-0.01, -0.12, -1.7e-5, -10.7, -0.0023]", "[model]"),
        ("q", "[1e-8, 1e-3, 100.0]", "[observer]"),
        ("high", "2e-3", "[fde]"),
        ("c2_gain", "1.125", "[[cylinder]]"),
        ("name", "\"another\"", "[machine]"),
    ] {
        let words = ["does not belong to this configuration", told, "--fresh"];
        refused(&with(key, value), &words);
    }
    yard.0.write("config.toml", &text);
    let dbc = yard.read("e-type.dbc");
    yard.0.write("e-type.dbc", format!("{dbc}\n"));
    refused(&text, &["the DBC"]);
    yard.0.write("e-type.dbc", dbc);
    let mut flipped = kept.clone();
    flipped[kept.len() / 2] ^= 4;
    yard.0.write("config.learnt", &flipped);
    refused(&text, &["config.learnt", "it was changed or truncated", "--fresh"]);
    yard.0.write("config.learnt", "[mine]\n");
    refused(&text, &["something else is in it"]);
    let fresh = || yard.learn("commission", &[&second], "config.toml", &["--update", "--fresh"]);
    yard.unchanged(|| fresh().failed(2, &["something else is in it"]));

    // A calibration does not depend on weights.
    yard.0.write("config.learnt", &kept);
    yard.0.write("config.toml", with("q", "[1e-8, 1e-3, 100.0]"));
    yard.update("calibrate", &second).ok();
    assert_eq!(yard.learnt().parts.len(), 2);
    // And what is begun anew has nothing of the first day.
    fresh().ok();
    assert_eq!(yard.learnt().parts.len(), 1);
}

#[test]
fn what_was_learnt_under_other_overrides_is_not_mixed_with_these() {
    let yard = Yard::new();
    let first = yard.record("first-day.log", "2.5,8", 240, 0);
    let second = yard.record("second-day.log", "2.5,8", 240, 1);
    let call = |command: &str, log: &str, set: &[&str]| {
        yard.learn(command, &[log], "config.toml", &[&["--update"], set].concat())
    };
    let refused = |set: &[&str], told: &str| {
        let words = ["does not belong to this configuration", told, "--set", "--fresh"];
        yard.unchanged(|| call("commission", &second, set).failed(2, &words));
    };
    yard.update("commission", &first).ok();
    for (set, told) in [
        ("machine.name=lent out", "[machine]"),
        ("observer.q=[1e-8, 1e-3, 100.0]", "[observer]"),
        ("fde.high=2e-3", "[fde]"),
        ("comparator.bound=0.003", "comparator.bound"),
    ] {
        refused(&["--set", set], told);
    }

    // Those of the day before are in force again, except for what was learnt under them.
    let set = ["--set", "machine.name=lent out", "--set", "comparator.bound=0.003"];
    let fresh = [&set[..], &["--fresh"]].concat();
    call("calibrate", &first, &fresh).ok();
    assert_ne!(yard.table("config.toml")["machine"]["name"].as_str(), Some("lent out"));
    refused(&[], "[machine]");
    refused(&set, "comparator.bound");
    call("calibrate", &second, &set[..2]).ok();
    assert_eq!(yard.learnt().parts.len(), 2);
}

#[test]
fn a_fault_is_left_out_and_one_that_stays_is_refused() {
    let yard = Yard::new();
    let first = yard.record("first-day.log", "1.8,7", 240, 0);
    let second = yard.record("second-day.log", "2.5,8", 480, 1);
    yard.update("commission", &first).ok();
    let (text, kept) = (yard.read("config.toml"), yard.bytes("config.learnt"));
    let fault = |when: &str, size: &str| {
        yard.faulty(&second, &format!("step,cylinder=3,sensor=c1,{when},size={size}"))
    };
    for (when, size, words) in [
        ("at=0", "0.001", "cylinder 3: C1 - C2 differs from the tables by 0.9"),
        ("at=270", "0.001", "s until after the end"),
        ("at=200", "0.0003", "mm of it stay"),
    ] {
        let log = fault(when, size);
        for command in ["commission", "calibrate"] {
            let words = [words, "is not healthy", "nothing was written"];
            yard.unchanged(|| yard.update(command, &log).failed(1, &words));
        }
    }
    yard.update("calibrate", &second).ok();
    let sound = yard.table("config.toml");
    yard.0.write("config.toml", text);
    yard.0.write("config.learnt", kept);
    let short = fault("at=130,until=132", "0.004");
    let run = yard.update("calibrate", &short).ok();
    for words in ["cylinder 3: ", "nats of evidence at 13", "from 110 to 152 s are left out"] {
        assert!(run.stdout.contains(words), "{words}: {}", run.stdout);
    }
    // The tables are as without it.
    let cut = yard.table("config.toml");
    assert_eq!(cut["comparator"]["bound"], sound["comparator"]["bound"]);
    for (cut, sound) in sequential(&cut).into_iter().zip(sequential(&sound)) {
        assert_eq!(cut["level"], sound["level"]);
        let nodes = numbers(cut, "nodes").into_iter().zip(numbers(sound, "nodes"));
        for ((cut, sound), deviation) in nodes.zip(numbers(sound, "node_deviations")) {
            assert!((cut - sound).abs() < 1.5 * deviation, "{cut} {sound} {deviation}");
        }
    }
    // And nothing of it is kept.
    let mut stamps = Vec::new();
    let learnt = yard.learnt();
    let mut take =
        |frame: &Frame| stamps.push(frame.timestamp.as_nanos() / 1_000_000_000 - BEGIN - DAY);
    learnt.pieces.iter().for_each(|piece| piece.unpack(&mut take).expect("it is whole"));
    assert!(stamps.contains(&100) && stamps.contains(&160));
    assert!(!stamps.iter().any(|at| (112..151).contains(at)));
}

/// The configuration is written first; a run that ends before the rest is noticed, and nothing is lost.
#[test]
fn a_run_that_was_interrupted_is_taken_up_or_noticed() {
    let yard = Yard::new();
    let logs = [0, 1].map(|day| yard.record(&format!("{day}.log"), "2.5,8", 240, day));
    yard.update("calibrate", &logs[0]).ok();
    let old = yard.bytes("config.learnt");
    yard.update("calibrate", &logs[1]).ok();
    let new = yard.bytes("config.learnt");
    yard.0.write("config.learnt", &old);
    let words = ["comparator.bound or the calibrations of [[cylinder]] differ from those"];
    yard.unchanged(|| yard.update("calibrate", &logs[1]).failed(2, &words));
    yard.0.write("config.learnt.new", &new);
    let run = yard.update("calibrate", &logs[1]).ok();
    assert!(run.stderr.contains("the last run was interrupted"), "{}", run.stderr);
    assert!(run.stdout.contains("was already learnt"), "{}", run.stdout);
    // Half of it beside is of a run that had not changed anything.
    yard.0.write("config.learnt", &new);
    yard.0.write("config.learnt.new", &old[..old.len() / 2]);
    let run = yard.unchanged(|| yard.update("calibrate", &logs[0]).ok());
    assert!(run.stdout.contains("was already learnt"), "{}", run.stdout);
    let call = ["--update", "--into", &yard.path("other.toml")];
    yard.0.write("other.toml", yard.read("config.toml"));
    let config = yard.path("config.toml");
    tertius(&[&["calibrate", &logs[1], "--config", &config][..], &call].concat())
        .failed(2, &["--into has to be the configuration itself"]);
}

/// Beyond what may be kept, that goes first in which the rods were nowhere.
#[test]
fn what_is_kept_is_bounded() {
    let yard = Yard::new();
    let log = yard.record("first-day.log", "2.5,8", 180, 0);
    yard.update("calibrate", &log).ok();
    let mut learnt = yard.learnt();
    let of_the_rods = learnt.pieces.clone();
    let (mut packing, mut seeded) = (Packing::default(), Seeded(1));
    let id = Id::standard(0x7E0).expect("11 bits");
    for k in 0..MOST_BYTES as i64 / MAX_DATA as i64 {
        let at = Timestamp::from_nanos((BEGIN - DAY) * 1_000_000_000 + k * 1_000_000);
        let words: [[u8; 8]; MAX_DATA / 8] =
            [(); MAX_DATA / 8].map(|()| seeded.next().to_le_bytes());
        packing.take(&Frame::new(at, id, Kind::Fd { flags: 0 }, words.as_flattened()));
    }
    learnt.add([], packing.finish());
    assert!(learnt.bytes() > MOST_BYTES);
    let config = yard.read("config.toml");
    learnt.seals = Seals::of(&config, &yard.bytes("e-type.dbc")).expect("it is TOML");
    yard.0.write("config.learnt", learnt.to_bytes());
    let second = yard.record("second-day.log", "2.5,8", 60, 1);
    yard.update("calibrate", &second).ok();
    let bounded = yard.learnt();
    assert!((MOST_BYTES / 2..=MOST_BYTES).contains(&bounded.bytes()), "{}", bounded.bytes());
    assert!(of_the_rods.iter().all(|piece| bounded.pieces.contains(piece)));
}
