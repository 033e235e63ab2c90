//! docs/CLI.md is the help of every command, word for word.
//!
//! `UPDATE_GOLDEN=1 cargo test --test cli cli_document` writes it anew.

use std::{env, fs};
use tertius_testing::support::{tertius, top};

const PATH: &str = "docs/CLI.md";

const HEAD: &str = "\
<!-- Written by `UPDATE_GOLDEN=1 cargo test --test cli cli_document` -->
# The command line

What `--help` says of each command, word for word. The package has the same as man pages (`man tertius-replay`).
[COMMANDS.md](COMMANDS.md) explains what the commands are for, and [OUTPUTS.md](OUTPUTS.md) what they write.
";

/// The names below `Commands:` in a help; empty if the command has no others below it.
fn commands(help: &str) -> Vec<&str> {
    let (_, list) = help.split_once("Commands:\n").unwrap_or_default();
    let lines = list.lines().take_while(|line| !line.is_empty());
    // A description goes on in lines that are indented further.
    let names = lines.filter_map(|line| line.strip_prefix("  ").filter(|it| !it.starts_with(' ')));
    names.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help").collect()
}

/// The section of the command with this path, and those of the commands below it.
fn sections(path: &[&str]) -> String {
    let help = tertius(&[path, &["--help"]].concat(), b"").ok().stdout;
    let lines: Vec<&str> = help.lines().map(str::trim_end).collect();
    let call = [&["tertius"], path].concat().join(" ");
    let mut text = format!("\n## `{call}`\n\n```text\n{}\n```\n", lines.join("\n").trim_end());
    for name in commands(&help) {
        text += &sections(&[path, &[name]].concat());
    }
    text
}

#[test]
fn the_document_is_what_the_commands_say_of_themselves() {
    let expected = HEAD.to_owned() + &sections(&[]);
    assert!(expected.matches("\n## ").count() > 15, "the commands were not found");
    let path = top().join(PATH);
    if env::var_os("UPDATE_GOLDEN").is_some_and(|value| value == "1") {
        return fs::write(path, expected).expect("it can be written");
    }
    let found = fs::read_to_string(path).unwrap_or_default();
    let differs = found.lines().zip(expected.lines()).find(|(found, expected)| found != expected);
    assert!(
        found == expected,
        "{PATH} is not what the commands say: {differs:?}; write it anew: \
         UPDATE_GOLDEN=1 cargo test --test cli cli_document"
    );
}

/// The tables of docs/COMMANDS.md, which are written by hand.
#[test]
fn the_commands_and_the_options_of_a_replay_are_explained() {
    let document = fs::read_to_string(top().join("docs/COMMANDS.md")).expect("it is there");
    let rows = document.lines().filter(|line| line.starts_with("| `")).collect::<Vec<_>>();
    let is_explained = |name: &str| {
        let word = |row: &&str| row.split(['`', ' ', ',']).any(|word| word == name);
        rows.iter().any(|row| word(&row.split('|').nth(1).unwrap_or_default()))
    };
    let help = tertius(&["--help"], b"").ok().stdout;
    let names = commands(&help);
    let missing: Vec<&str> = names.into_iter().filter(|name| !is_explained(name)).collect();
    assert!(missing.is_empty(), "docs/COMMANDS.md has no line for {missing:?}");
    let help = tertius(&["replay", "--help"], b"").ok().stdout;
    let lines = help.lines().map(str::trim_start).filter(|line| line.starts_with("--"));
    let options: Vec<&str> = lines.filter_map(|line| line.split_whitespace().next()).collect();
    assert!(options.len() > 12, "{options:?}");
    // Of all commands that read a configuration.
    let general = |option: &&str| ["--config", "--set"].contains(option);
    let missing = options.into_iter().filter(|it| !general(it) && !is_explained(it));
    let missing: Vec<&str> = missing.collect();
    assert!(missing.is_empty(), "docs/COMMANDS.md has no line for {missing:?} of `replay`");
}
