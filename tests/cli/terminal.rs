//! What others wrote reaches the terminal as text: nothing in it moves the cursor, sets a colour or turns the writing.

use std::fs;
use tertius_testing::support::{Run, Scratch, between, changed, recorded, recording, tertius, top};

/// Clears the screen, sets the title, and turns the direction of writing; as ESC and as the one character of C1.
const EVIL: &str = "\u{1b}[2J\u{1b}]0;owned\u{7}\u{9b}31m\u{202e}\u{2066}";

/// The run, of which nothing acts on a terminal, but which shows that `EVIL` was there.
#[track_caller]
fn harmless(run: Run) -> Run {
    let text = format!("{}{}", run.stdout, run.stderr);
    let turns = |c: char| matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let acts = |c: char| (c.is_control() && c != '\n') || turns(c);
    assert!(!text.contains(acts), "{text:?}");
    assert!(text.contains("\\u"), "{text}");
    run
}

fn check(config: &str) -> Run {
    tertius(&["check", config], b"")
}

#[test]
fn lines_of_a_configuration_are_shown_as_text() {
    let scratch = Scratch::new();
    let evil = format!("[machine] # {EVIL}\ncylinders = 999 # {EVIL}\n");
    // Not TOML, and TOML with a wrong value: both are shown with their lines.
    let run = harmless(check(&scratch.write("raw.toml", &evil)).failed(2, &[]));
    assert!(run.stderr.contains("raw.toml"), "{}", run.stderr);
    let bidi = "[machine]\nname = 7 # \u{202e}\u{202a}\n";
    let run =
        check(&scratch.write("bidi.toml", bidi)).failed(2, &["\\u202e\\u202a", "machine.name"]);
    assert!(!run.stderr.contains('\u{202e}'), "{}", run.stderr);
}

#[test]
fn names_in_a_dbc_are_shown_as_text() {
    let scratch = Scratch::new();
    let state = "monitored_states = [\"engaged\"]";
    let config = scratch.config(&[(state, "monitored_states = [\"unknown one\"]")]);
    let dbc = fs::read_to_string(top().join("dbc/e-type.dbc")).expect("it ships");
    let name = format!("2 \"{EVIL}\" 3 \"engaged\"");
    scratch.write("e-type.dbc", changed(&dbc, &[("2 \"neutral\" 3 \"engaged\"", &name)]));
    harmless(check(&config).failed(2, &["unknown one"]));
}

#[test]
fn names_of_files_and_arguments_are_shown_as_text() {
    harmless(check(&format!("missing{EVIL}.toml")).failed(2, &["missing"]));
    harmless(tertius(&["check", &format!("--{EVIL}")], b"").failed(2, &["unexpected argument"]));
    let config = format!("missing{EVIL}.toml");
    let log = recording("hanging-load.log.gz");
    harmless(tertius(&["replay", &log, "--config", &config], b"").failed(2, &["missing"]));
}

#[test]
fn what_a_replay_prints_is_text_in_every_format() {
    let scratch = Scratch::new();
    let config = scratch.config(&[("[\"engaged\"]", "[\"neutral\"]")]);
    let dbc = fs::read_to_string(top().join("dbc/e-type.dbc")).expect("it ships");
    let name = format!("2 \"neutral\" 3 \"{EVIL}\"");
    scratch.write("e-type.dbc", changed(&dbc, &[("2 \"neutral\" 3 \"engaged\"", &name)]));
    let log = between(&recorded("e-type-faults.log.zst"), 40.0, 60.0);
    // A bad line and a frame of another interface tell their places, too.
    let log = scratch.write(&format!("{EVIL}.log"), log + "(1700000060.1) can0 nothing\n");
    for format in ["human", "jsonl"] {
        let call = ["replay", &log, "--config", &config, "--format", format];
        let run = harmless(tertius(&call, b"").failed(1, &[]));
        let shown = "3 (\\u001b[2J\\u001b]0;owned\\u0007\\u009b31m\\u202e\\u2066)";
        assert!(run.stdout.contains(shown), "{}", run.stdout);
        let is_told = |name: &str| run.stdout.contains(name);
        assert!(format == "jsonl" || is_told("\\u2066.log:"), "{}", run.stdout);
    }
    let run = tertius(&["replay", &log, "--config", &config, "--format", "jsonl"], b"");
    let reason = run.summary()["reasons"].to_string();
    assert!(run.summary()["reasons"][0].as_str().is_some_and(|it| it.contains(EVIL)), "{reason}");
}

#[test]
fn what_an_eds_says_is_shown_as_text() {
    let scratch = Scratch::new();
    let config = super::canopen::config(&scratch, &[]);
    let eds = super::canopen::shipped("dbc/encoder.eds");
    let wrong = eds.replace("DataType=", &format!("DataType={EVIL}"));
    scratch.write("encoder.eds", wrong);
    harmless(check(&config).failed(2, &["DataType is"]));
    // A value in a message is quoted. The name of an object stands as it is.
    let named = eds.replace("ParameterName=", &format!("ParameterName={EVIL}"));
    scratch.write("encoder.eds", named);
    let run = harmless(check(&config).ok());
    let shown =
        "(\\u001b[2J\\u001b]0;owned\\u0007\\u009b31m\\u202e\\u2066Position value channel 1;";
    assert!(run.stdout.contains(shown), "{}", run.stdout);
}

#[test]
fn a_fleet_is_shown_as_text() {
    let scratch = Scratch::new();
    let fleet = scratch.write("fleet.toml", format!("[[machine]]\nname = \"{EVIL}\"\n"));
    harmless(tertius(&["fleet", "plan", &fleet], b"").failed(2, &["fleet.toml"]));
    let config = top().join("config/e-type.toml").display().to_string();
    let text = format!(
        "[[machine]]\nname = \"A\u{202e}\"\nconfig = {config:?}\nrecordings = [\"s3://x/\\u001b[2J\"]\n"
    );
    let fleet = scratch.write("fleet.toml", text);
    for format in ["human", "jsonl", "shell"] {
        let run = harmless(tertius(&["fleet", "plan", &fleet, "--format", format], b"").ok());
        assert!(run.stdout.contains("\\u202e"), "{}", run.stdout);
    }
}
