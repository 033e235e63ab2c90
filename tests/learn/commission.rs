//! `tertius commission`: a healthy recording in, a configuration that can be used out, or words.

use crate::yard::{Yard, moved, tertius};
use std::fs;
use tertius_testing::support::Run;
use toml::Table;

/// Seconds in each sea.
const HALF: i64 = 150;

/// Seconds between two recordings.
const PAUSE: i64 = 30;

const CALM: [&str; 2] = ["1.2,6.5", "31"];
const ROUGH: [&str; 2] = ["2.5,8", "32"];

impl Yard {
    /// Five minutes, calm and rough, in one file, with `faults` in it.
    fn recording(&self, name: &str, faults: &[&str]) -> String {
        self.recording_of(&[CALM, ROUGH], name, faults)
    }

    /// As [`Self::recording`], a half of it for each of `seas`.
    fn recording_of(&self, seas: &[[&str; 2]], name: &str, faults: &[&str]) -> String {
        let parts = seas.iter().zip(0..).map(|(of, number)| {
            let log = self.simulate(&format!("{}.log", of[1]), *of, HALF, &["--force"]);
            moved(&fs::read_to_string(log).expect("it was written"), number * (HALF + PAUSE))
        });
        let log = self.0.write(name, parts.collect::<String>());
        if faults.is_empty() { log } else { self.inject(&log, &format!("faulty-{name}"), faults) }
    }

    fn commission(&self, logs: &[&str], more: &[&str]) -> Run {
        let config = self.path("config.toml");
        tertius(&[&["commission"], logs, &["--config", &config], more].concat())
    }

    /// What the machine is commissioned with stays as it is, and nothing is beside it.
    #[track_caller]
    fn is_untouched(&self, before: &str) {
        assert_eq!(self.read("config.toml"), before);
        assert!(!fs::exists(self.path("config.toml.bak-1")).expect("the folder is there"));
    }
}

fn comments(text: &str) -> Vec<&str> {
    text.lines().filter(|line| line.starts_with('#')).collect()
}

fn sequential(text: &str) -> Vec<i64> {
    let table: Table = text.parse().expect("TOML");
    let cylinders = table["cylinder"].as_array().expect("they are learnt").iter();
    let known = cylinders.filter(|cylinder| cylinder.get("sequential").is_some());
    known.map(|cylinder| cylinder["n"].as_integer().expect("a number")).collect()
}

#[test]
fn from_a_recording_to_a_configuration_that_holds_in_another_sea() {
    let yard = Yard::new();
    let log = yard.recording("healthy.log", &[]);
    let before = yard.read("config.toml");
    // Values of a call are no part of what is written.
    let set = ["--set", "bus.interface=can7", "--set", "store.days=7"];
    let dry = yard.commission(&[&log], &[&["--dry-run"], &set[..]].concat()).ok();
    yard.is_untouched(&before);
    assert!(dry.stdout.contains("\n+++ with the tables\n"), "{}", dry.stdout);
    assert!(!dry.stdout.contains("can7") && !dry.stdout.contains("days = 7\n"), "{}", dry.stdout);

    let report = yard.path("report.html");
    let run = yard.commission(&[&log], &["--report", &report]).ok();
    let first = run.stdout.lines().next().expect("a line");
    assert!(first.contains(" is fit for use: no false alarm in "), "{first}");
    assert!(first.contains("step of 1 mm 0.0"), "{first}");
    // Nothing in a pipe but what is kept where.
    assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    assert_eq!(yard.read("config.toml.bak-1"), before);
    let after = yard.read("config.toml");
    assert_eq!(comments(&after)[..comments(&before).len()], comments(&before), "they stay");
    for line in dry.stdout.lines().filter_map(|line| line.strip_prefix('+')).skip(1) {
        assert!(line.starts_with("++") || after.contains(line), "{line}");
    }
    assert_eq!(sequential(&after), [1, 2, 3, 4, 5, 6]);
    // The detectors reckon with what the calibration has reckoned with.
    assert_eq!(after.matches("\noutlier_share = 0.01\n").count(), 6, "{after}");
    tertius(&["check", &yard.path("config.toml")]).ok();

    let page = fs::read_to_string(report).expect("it was written");
    let place = |what: &str| page.find(what).unwrap_or_else(|| panic!("{what} is not on the page"));
    let heading = |name: &str| format!("<h2 id=\"{name}");
    let parts = ["trial", "model", "calibration", "tuning"].map(heading);
    let parts = ["is fit for use"].into_iter().chain(parts.iter().map(String::as_str));
    assert!(parts.map(place).is_sorted(), "the verdict is first");

    let other = yard.simulate("other.log", ["2.0,7.5", "77"], 300, &[]);
    let config = yard.path("config.toml");
    let replay = tertius(&["replay", &other, "--config", &config, "--format", "jsonl"]).ok();
    assert!(replay.warnings().is_empty(), "{:?}", replay.warnings());

    // The same to the byte as one after the other.
    let single = yard.0.write("single.toml", &before);
    let identify = ["identify", "--held-back", "0"];
    for command in [&identify[..], &["calibrate"], &["tune"]] {
        tertius(&[command, &[&log, "--config", &single, "--into", &single]].concat()).ok();
    }
    assert_eq!(yard.read("single.toml"), after);
}

#[test]
fn a_cylinder_with_a_fault_is_refused_and_the_others_are_taken_if_one_says_so() {
    let yard = Yard::new();
    let before = yard.read("config.toml");
    let fault = |at: i64| format!("step,cylinder=3,sensor=c1,at={at},until={},size=0.001", at + 4);
    let faults: Vec<String> = [20, 70, 130, 190, 250].map(fault).to_vec();
    let faults: Vec<&str> = faults.iter().map(String::as_str).collect();
    let log = yard.recording("healthy.log", &faults);
    let words = ["is fit for use except for cylinder 3", "nothing was written"];
    let run = yard.commission(&[&log], &[]).failed(1, &words);
    for word in ["cylinder 3 is refused (calibrate): ", "nats of evidence at", "--accept-refused"] {
        assert!(run.stdout.contains(word), "{word}: {}", run.stdout);
    }
    yard.is_untouched(&before);
    let output = yard.path("others.toml");
    yard.commission(&[&log], &["--accept-refused", "--output", &output]).ok();
    yard.is_untouched(&before);
    assert_eq!(sequential(&yard.read("others.toml")), [1, 2, 4, 5, 6]);
    tertius(&["check", &output]).ok();
}

/// A fault of a few seconds is left out of calibration, thresholds and trial, and told.
#[test]
fn a_short_fault_is_left_out_of_all_that_is_learnt() {
    let yard = Yard::new();
    // What is left out is a tenth of it at the most, 20 s to either side of the fault included.
    let seas = [CALM, ROUGH, ["2.0,7", "33"], ["1.8,7", "34"]];
    let fault = "step,cylinder=3,sensor=c1,at=130,until=132,size=0.004";
    let faulty = yard.recording_of(&seas, "healthy.log", &[fault]);
    let folder = yard.path("elsewhere");
    fs::create_dir(&folder).expect("a folder");
    // In another folder the DBC is named from there.
    let output = format!("{folder}/cut.toml");
    let run = yard.commission(&[&faulty], &["--output", &output]).ok();
    tertius(&["check", &output]).ok();
    assert!(run.stdout.contains("no false alarm in"), "{}", run.stdout);
    assert!(run.stdout.contains("cylinder 3: no healthy cylinder has such readings as those"));
    let text = fs::read_to_string(&output).expect("it was written");
    assert_eq!(sequential(&text), [1, 2, 3, 4, 5, 6]);
    // With the fault it would be some millimetres.
    let healthy = yard.path("healthy.log");
    let output = yard.path("healthy.toml");
    yard.commission(&[&healthy], &["--output", &output]).ok();
    let [cut, whole] = [text, yard.read("healthy.toml")].map(|text| {
        let table: Table = text.parse().expect("TOML");
        table["fde"]["high"].as_float().expect("a threshold")
    });
    assert!((cut / whole - 1.0).abs() < 0.1, "{cut} {whole}: {}", run.stdout);
}

/// From one day to the next the transducers are a little apart by temperature, which is no fault of either.
#[test]
fn of_another_day_nothing_before_it_is_remembered() {
    let yard = Yard::new();
    let first = yard.recording("first.log", &[]);
    let second = yard.recording_of(&[["1.2,6.5", "41"], ["2.5,8", "42"]], "second.log", &[]);
    let warmer = "step,cylinder=3,sensor=c1,at=0,size=0.0003";
    let second = yard.inject(&second, "warmer.log", &[warmer]);
    let later =
        yard.0.write("later.log", moved(&fs::read_to_string(second).expect("it is there"), 86_400));
    let run = yard.commission(&[&first, &later], &["--dry-run"]).ok();
    assert!(run.stdout.contains("no false alarm in"), "{}", run.stdout);
    assert!(!run.stdout.contains("left out"), "{}", run.stdout);
}

/// A short recording of a healthy machine, of which half contradicts what too little of the other half has taught.
#[test]
fn a_short_recording_is_said_to_be_short_and_no_cylinder_to_be_ill() {
    let yard = Yard::new();
    let log = yard.path("short.log");
    let config = "config/e-type-simulated.toml";
    // Of the first machine the trial's part is too short for any cylinder, of the second for two of them.
    for seed in ["1", "7"] {
        let call = ["simulate", "--config", config, "--duration", "180", "--seed", seed];
        tertius(&[&call[..], &["--output", &log, "--force"]].concat()).ok();
        let run = yard.commission(&[&log], &[]).failed(1, &["nothing was written"]);
        let mut lines = run.stdout.lines();
        let first = lines.next().expect("a verdict");
        assert!(first.ends_with("is not fit for use: the recording is too short"), "{first}");
        let why = lines.find(|line| line.starts_with("  ")).expect("a reason");
        assert_eq!(
            why,
            "  the recording is too short: 2.8 min of it could be judged, and 9 min are needed; record a quarter of an \
             hour of the machine at work"
        );
        let text = &run.stdout;
        assert!(
            text.contains("record for longer; a quarter of an hour at work is enough"),
            "{text}"
        );
        assert!(!text.contains("no cylinder has enough data"), "{text}");
        assert!(!text.contains("not a recording of a healthy cylinder"), "{text}");
        assert!(text.contains("cylinder 6 is refused (calibrate): 2.8 min are too few"), "{text}");
    }
}

#[test]
fn what_cannot_teach_is_refused_in_words_and_nothing_is_written() {
    let yard = Yard::new();
    let before = yard.read("config.toml");
    let refused = |log: &str, words: &[&str]| {
        let run = yard.commission(&[log], &[]).failed(1, &["nothing was written"]);
        let first = run.stdout.lines().next().expect("a line");
        assert!(first.contains("is not fit for use"), "{first}");
        assert!(words.iter().all(|word| run.stdout.contains(word)), "{}", run.stdout);
        yard.is_untouched(&before);
    };
    let short = yard.simulate("short.log", ROUGH, 20, &[]);
    refused(&short, &["no cylinder has enough data to judge: at least 50 s", "what to do:"]);
    let still = yard.simulate("still.log", ["0.01,8", "1"], 90, &[]);
    refused(&still, &["record it in motion"]);
    // C2 at a tenth, as a wrong DBC has it.
    let sound = yard.simulate("sound.log", ROUGH, 60, &[]);
    let dbc = yard.read("e-type.dbc");
    yard.0.write("e-type.dbc", wrong(&dbc));
    refused(&sound, &["check unit, factor and offset of both in the DBC"]);
}

/// As a glob gives them that also finds a copy: evidence would count twice.
/// The model that is best for all is then as bad for each of them, and says nothing against the five that follow their own.
#[test]
fn one_cylinder_with_a_wrong_command_is_no_machine_without_observers() {
    let yard = Yard::new();
    let log =
        yard.recording("healthy.log", &["step,cylinder=1,sensor=control_speed,at=150,size=0.3"]);
    let before = yard.read("config.toml");
    let run = yard.commission(&[&log], &[]).failed(1, &["nothing was written"]);
    assert!(run.stdout.contains("the model does not follow its command"), "{}", run.stdout);
    yard.is_untouched(&before);
}

#[test]
fn what_was_recorded_twice_at_the_same_time_is_refused() {
    let yard = Yard::new();
    let before = yard.read("config.toml");
    let log = yard.simulate("once.log", ROUGH, 60, &[]);
    let text = fs::read_to_string(&log).expect("it was written");
    let copy = yard.0.write("copy.log", &text);
    let overlapping = yard.0.write("overlapping.log", moved(&text, 30));
    for logs in [[&*log, &*copy], [&*log, &*log], [&*log, &*overlapping]] {
        yard.commission(&logs, &[]).failed(2, &["recordings overlap, one is named twice"]);
        yard.is_untouched(&before);
    }
    // A sender whose clock is a second ahead of the others' is not meant: all others are then earlier than it.
    let ahead = text.lines().map(|line| match line.contains(" 181#") {
        true => moved(line, 1),
        false => format!("{line}\n"),
    });
    let ahead = yard.0.write("ahead.log", ahead.collect::<String>());
    let run = yard.commission(&[&ahead], &[]);
    assert!(!run.stderr.contains("overlap"), "{}", run.stderr);
}

/// The DBC with each C2 at a tenth of its length.
fn wrong(dbc: &str) -> String {
    let mut of_c2 = false;
    let mut text = String::new();
    for line in dbc.lines() {
        if let Some(message) = line.strip_prefix("BO_ ") {
            of_c2 = message.contains("_C2");
        }
        let scaled = line.replace("(0.00010850694444444444,-1.5)", "(1.0850694444444444e-5,-0.15)");
        text += if of_c2 { &scaled } else { line };
        text.push('\n');
    }
    assert_ne!(text, dbc);
    text
}

#[test]
fn a_configuration_that_exists_is_not_written_over() {
    let yard = Yard::new();
    let short = yard.simulate("short.log", ROUGH, 20, &[]);
    let taken = yard.0.write("taken.toml", "# mine\n");
    yard.commission(&[&short], &["--output", &taken]).failed(2, &["taken.toml", "--force"]);
    assert_eq!(yard.read("taken.toml"), "# mine\n");
    let call = ["--output", &taken, "--dry-run"];
    yard.commission(&[&short], &call).failed(2, &["cannot be used with"]);
}

/// Two recordings a day apart: a day without frames is no time that was tried, and no place for a fault.
#[test]
fn a_night_between_two_recordings_counts_as_a_minute() {
    let yard = Yard::new();
    let day = |name: &str, of: [&str; 2], later: i64| {
        let log = yard.simulate("day.log", of, HALF, &["--force"]);
        let text = fs::read_to_string(log).expect("it was written");
        yard.0.write(name, moved(&text, later))
    };
    let logs = [day("first.log", ROUGH, 0), day("second.log", ["2.5,8", "33"], 86_400)];
    let run = yard.commission(&[&logs[0], &logs[1]], &["--dry-run"]).ok();
    for words in [
        "learnt from all 5.0 min recorded in",
        "the pause of 24.0 h after 150.0 s counts as a minute",
    ] {
        assert!(run.stdout.contains(words), "{words}: {}", run.stdout);
    }
    assert!(run.stdout.contains("step of 1 mm 0.0") && run.stdout.contains("(24 of 24 found"));
}
