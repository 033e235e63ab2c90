//! What the configuration's tests share.

use tertius::config::parse;

/// The example of the interface's description, as it stands there.
pub const EXAMPLE: &str = include_str!("example.toml");

/// The example with one text replaced.
pub fn broken(from: &str, to: &str) -> String {
    assert_eq!(EXAMPLE.matches(from).count(), 1, "{from:?} is not once in the example");
    EXAMPLE.replace(from, to)
}

/// What is said about a text, as lines.
pub fn refusal(text: &str) -> Vec<String> {
    match parse("machine.toml", text) {
        Ok(_) => panic!("accepted:\n{text}"),
        Err(error) => error.to_string().lines().map(str::to_owned).collect(),
    }
}

/// A mistake is refused with one problem that begins with `start` and contains the help `help`.
#[track_caller]
pub fn refused(from: &str, to: &str, start: &str, help: &str) {
    let lines = refusal(&broken(from, to));
    assert_eq!(lines.len(), 1, "{lines:#?}");
    let expected = format!("machine.toml:{start}");
    assert!(lines[0].starts_with(&expected), "\n   found {}\nexpected {expected}", lines[0]);
    assert!(lines[0].contains(help), "\n   found {}\nexpected {help}", lines[0]);
}
