//! What others wrote reaches the terminal as text: nothing in it moves the cursor, sets a colour or turns the writing.

use std::fs;
use tertius_testing::support::{Run, Scratch, changed, recording, tertius, top};

/// Clears the screen, sets the title, and turns the direction of writing; as ESC and as the one character of C1.
const EVIL: &str = "\u{1b}[2J\u{1b}]0;owned\u{7}\u{9b}31m\u{202e}";

/// The run, of which nothing acts on a terminal, but which shows that `EVIL` was there.
#[track_caller]
fn harmless(run: Run) -> Run {
    let text = format!("{}{}", run.stdout, run.stderr);
    let acts = |c: char| (c.is_control() && c != '\n') || ('\u{202a}'..='\u{202e}').contains(&c);
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
