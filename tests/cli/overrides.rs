//! Values of single keys for one call, from the command line and from the environment.

use std::fs;
use tertius_testing::support::{E_TYPE, Run, Scratch, command, recording, tertius, top};

const DEFAULT: &str = "config/e-type.toml";

/// Checks the default configuration with variables of the environment and further arguments.
fn check(variables: &[(&str, &str)], arguments: &[&str]) -> Run {
    let output = command(&[&["check", DEFAULT], arguments].concat())
        .envs(variables.iter().copied())
        .output()
        .expect("the program starts");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    Run { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}

fn judged_by(run: &Run) -> &str {
    run.stdout.lines().find(|line| line.starts_with("judged by ")).expect("it says so")
}

#[test]
fn the_command_line_beats_the_environment_and_that_the_file() {
    let plain = check(&[], &[]).ok();
    assert!(!plain.stdout.contains("overrides in force"), "{}", plain.stdout);
    let variable = [("TERTIUS_FDE__HIGH", "0.003"), ("TERTIUS_BUS__INTERFACE", "can1")];
    let both = check(&variable, &["--set", "fde.high=0.002"]).ok();
    let told = "\noverrides in force, which are not in the file\n  TERTIUS_BUS__INTERFACE=can1\n  --set fde.high=0.002\n";
    assert!(both.stdout.contains(told), "{}", both.stdout);
    let line = check(&[("TERTIUS_BUS__INTERFACE", "can1")], &["--set", "fde.high=0.002"]).ok();
    assert_eq!(judged_by(&both), judged_by(&line));
    let environment = check(&variable, &[]).ok();
    assert_ne!(judged_by(&environment), judged_by(&both));
    assert_ne!(judged_by(&plain), judged_by(&environment));
    // These mean something else, and none of a configuration.
    let others = check(&[("TERTIUS_TOKEN", "x"), ("TERTIUS_PYTHON", "y")], &[]).ok();
    assert_eq!(others.stdout, plain.stdout);
}

#[test]
fn the_identity_is_that_of_a_file_with_the_same_values() {
    let scratch = Scratch::new();
    fs::create_dir(scratch.path("config")).expect("a folder");
    fs::create_dir(scratch.path("dbc")).expect("a folder");
    fs::copy(top().join("dbc/e-type.dbc"), scratch.path("dbc/e-type.dbc"))
        .expect("it can be copied");
    let text = fs::read_to_string(top().join(DEFAULT)).expect("it ships");
    let text = text.replace("high = 1.0e-3", "high = 0.002").replace("\"can0\"", "\"can1\"");
    let changed = tertius(&["check", &scratch.write("config/e-type.toml", text)], b"").ok();
    let set = check(&[], &["--set", "fde.high=2e-3", "--set", "bus.interface=can1"]).ok();
    assert_eq!(judged_by(&set), judged_by(&changed));
}

#[test]
fn unknown_keys_are_refused_with_the_nearest() {
    check(&[("TERTIUS_BUS__INTERFAC", "can1")], &[]).failed(
        2,
        &[
            "TERTIUS_BUS__INTERFAC=can1: there is no key `TERTIUS_BUS__INTERFAC`",
            "the nearest known key is `TERTIUS_BUS__INTERFACE`",
        ],
    );
    let words =
        ["--set fde.hihg=1: there is no key `fde.hihg`", "the nearest known key is `fde.high`"];
    check(&[], &["--set", "fde.hihg=1"]).failed(2, &words);
    let words = ["--set bus.dbc=none.dbc: the DBC config/none.dbc cannot be read"];
    check(&[], &["--set", "bus.dbc=none.dbc"]).failed(2, &words);
    check(&[], &["--set", "fde.high"]).failed(2, &["expected KEY=VALUE"]);
    let list = ["[[cylinder]] is a list of tables, of which no key can be overridden"];
    check(&[], &["--set", "cylinder.theta=[1]"]).failed(2, &list);
}

#[test]
fn a_replay_is_judged_by_the_values_that_are_set() {
    let log = recording("e-type-faults.log.zst");
    let replayed = |config: &str, set: &[&str]| {
        let call = ["replay", &log, "--config", config, "--format", "jsonl"];
        tertius(&[&call, set].concat(), b"").ok().stdout
    };
    let scratch = Scratch::new();
    let config = scratch.config(&[("[bus]", "[comparator]\nbound = 0.01\n\n[bus]")]);
    let set = ["--set", "comparator.bound=0.01"];
    assert_eq!(replayed(E_TYPE, &set), replayed(&config, &[]));
    assert_ne!(replayed(E_TYPE, &set), replayed(E_TYPE, &[]));

    // The text says which values are not those of the file.
    let text =
        tertius(&[&["replay", &log, "--config", E_TYPE][..], &set].concat(), b"").ok().stdout;
    assert!(
        text.contains("e-type.toml, with --set comparator.bound=0.01: configuration "),
        "{text}"
    );
}

#[test]
fn every_command_that_takes_a_configuration_takes_values_for_it() {
    let help = tertius(&["--help"], b"").ok().stdout;
    let (_, commands) = help.split_once("Commands:\n").expect("it lists them");
    // A description goes on in lines that are indented further.
    let names = commands.lines().take_while(|line| !line.is_empty());
    let names = names.filter_map(|line| line.strip_prefix("  ").filter(|it| !it.starts_with(' ')));
    let names = names.filter_map(|line| line.split_whitespace().next());
    let mut counted = 0;
    for name in names.filter(|name| *name != "help") {
        let help = tertius(&[name, "--help"], b"").ok().stdout;
        let takes = help.contains("--config <FILE>") || name == "check";
        // `demo` and others have one built in, or none.
        assert_eq!(help.contains("--set <KEY=VALUE>"), takes, "{name}");
        counted += usize::from(takes);
    }
    assert!(counted >= 13, "{counted}");
}
