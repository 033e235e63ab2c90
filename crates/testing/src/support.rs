//! What the tests of the built program share: its runs, and recordings made from the kept ones.

pub use crate::top;

use crate::program;
use serde_json::Value;
use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;
use toml::{Table, Value as Toml};

/// The configuration of the `e-type-*` recordings.
pub const E_TYPE: &str = "tests/recordings/e-type.toml";
/// The configuration of `hanging-load`.
pub const HANGING_LOAD: &str = "tests/recordings/hanging-load.toml";

/// What a run of the program left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Run {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Run {
    /// The same, if the program said that it did what it was asked.
    #[track_caller]
    pub fn ok(self) -> Self {
        assert_eq!(self.code, Some(0), "{}\n{}", self.stdout, self.stderr);
        self
    }

    /// The same, if the program ended with `code` and told a person each of `words`.
    #[track_caller]
    pub fn failed(self, code: i32, words: &[&str]) -> Self {
        assert_eq!(self.code, Some(code), "{}\n{}", self.stdout, self.stderr);
        // A long line is wrapped, which is not what is tested.
        let said = unwrapped(&self.stderr);
        for word in words {
            assert!(said.contains(&unwrapped(word)), "{word:?} is not in\n{}", self.stderr);
        }
        assert!(!said.contains("panicked"), "{}", self.stderr);
        self
    }

    /// The lines of JSON on standard output.
    pub fn lines(&self) -> Vec<Value> {
        self.stdout.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
    }

    /// The last line, which is the summary.
    pub fn summary(&self) -> Value {
        let last = self.lines().pop().expect("a last line");
        assert_eq!(last["type"], "summary");
        last
    }

    /// The reports of incidents among the lines.
    pub fn incidents(&self) -> Vec<Value> {
        self.lines().into_iter().filter(|line| line["type"] == "incident").collect()
    }

    /// The warnings among the lines.
    pub fn warnings(&self) -> Vec<Value> {
        self.lines().into_iter().filter(|line| line["type"] == "warning").collect()
    }
}

/// Without what a terminal's frame and its width do to a message.
fn unwrapped(text: &str) -> String {
    text.chars().filter(|c| !c.is_whitespace() && !"│╭╰─·".contains(*c)).collect()
}

/// Runs the program at the repository's top with `input` on its standard input.
pub fn tertius(arguments: &[&str], input: &[u8]) -> Run {
    tertius_in_pieces(arguments, input, &mut || usize::MAX)
}

/// As [`tertius()`], the input written in pieces of the sizes that `size` gives.
pub fn tertius_in_pieces(
    arguments: &[&str],
    input: &[u8],
    size: &mut (impl FnMut() -> usize + Send),
) -> Run {
    let mut child = command(arguments).stdin(Stdio::piped()).spawn().expect("the program starts");
    let mut stdin = child.stdin.take().expect("standard input is piped");
    let output = std::thread::scope(|scope| {
        scope.spawn(move || {
            let mut rest = input;
            while !rest.is_empty() {
                let (piece, behind) = rest.split_at(size().clamp(1, rest.len()));
                // A program that refuses its call does not read its input: that is no error here.
                if stdin.write_all(piece).is_err() {
                    return;
                }
                rest = behind;
            }
        });
        child.wait_with_output().expect("its output")
    });
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    Run { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}

/// The program at the repository's top, its outputs piped and nothing on its standard input.
pub fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(program());
    command.args(arguments).current_dir(top());
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Replays `logs` in lines of JSON.
pub fn replay(logs: &[&str], config: &str, options: &[&str]) -> Run {
    let mut arguments = vec!["replay", "--config", config, "--format", "jsonl"];
    arguments.extend(options);
    arguments.extend(logs);
    tertius(&arguments, b"")
}

/// The path of a kept recording, from the top.
pub fn recording(name: &str) -> String {
    format!("tests/recordings/{name}")
}

/// The lines of a kept recording, not compressed.
pub fn recorded(name: &str) -> String {
    let file = File::open(top().join(recording(name))).expect("the recording is there");
    let mut text = String::new();
    match Path::new(name).extension().and_then(|extension| extension.to_str()) {
        Some("zst") => zstd::Decoder::new(file).expect("zstd").read_to_string(&mut text),
        Some("gz") => flate2::read::GzDecoder::new(file).read_to_string(&mut text),
        _ => { file }.read_to_string(&mut text),
    }
    .expect("it is whole");
    text
}

/// The lines of `log` from `begin` to `end`, in seconds after 1700000000.
pub fn between(log: &str, begin: f64, end: f64) -> String {
    let inside = |line: &&str| (begin..end).contains(&seconds(line));
    log.split_inclusive('\n').filter(inside).collect()
}

/// The time of a line of `candump -l`, in seconds after 1700000000.
pub fn seconds(line: &str) -> f64 {
    let (whole, fraction) = line[1..18].split_once('.').expect("a decimal point");
    let number = |text: &str| text.parse::<i64>().expect("digits");
    (number(whole) - 1_700_000_000) as f64 + number(fraction) as f64 / 1e6
}

/// A directory that goes when the test ends.
pub struct Scratch(TempDir);

impl Scratch {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary directory"))
    }

    /// The path of `name` in it.
    pub fn path(&self, name: &str) -> String {
        let path: PathBuf = self.0.path().join(name);
        path.into_os_string().into_string().expect("UTF-8")
    }

    /// Writes a file, and returns its path.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        let path = self.path(name);
        fs::write(&path, content).expect("it can be written");
        path
    }

    /// Reads a text file of it.
    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).expect("it is there")
    }

    /// A configuration beside a DBC: the recordings' own with `changes` of text, each found once.
    pub fn config(&self, changes: &[(&str, &str)]) -> String {
        self.write("e-type.dbc", fs::read(top().join("dbc/e-type.dbc")).expect("the DBC"));
        let text = fs::read_to_string(top().join(E_TYPE)).expect("the configuration");
        let text = changed(&text, &[("../../dbc/e-type.dbc", "e-type.dbc")]);
        self.write("e-type.toml", changed(&text, changes))
    }
}

/// `text` with `changes`, each of which is there exactly once.
#[track_caller]
pub fn changed(text: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text.to_owned(), |text, (from, to)| {
        assert_eq!(text.matches(from).count(), 1, "{from:?} is not once in the text");
        text.replace(from, to)
    })
}

/// Puts the tables of a learning command into a configuration; those of a cylinder by their number.
pub fn merge(into: &mut Table, tables: &Table) {
    for (key, value) in tables {
        match (into.get_mut(key), value) {
            (Some(Toml::Table(into)), Toml::Table(from)) => merge(into, from),
            (Some(Toml::Array(into)), Toml::Array(from)) if key == "cylinder" => {
                for table in from.iter().filter_map(Toml::as_table) {
                    let same = |known: &&mut Toml| known.get("n") == table.get("n");
                    match into.iter_mut().find(same).and_then(Toml::as_table_mut) {
                        Some(known) => merge(known, table),
                        None => into.push(Toml::Table(table.clone())),
                    }
                }
            }
            _ => _ = into.insert(key.clone(), value.clone()),
        }
    }
}

/// SplitMix64: the same numbers in every run, and no more than the tests need.
pub struct Seeded(pub u64);

impl Seeded {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform below `limit`.
    pub fn below(&mut self, limit: u64) -> u64 {
        self.next() % limit
    }

    /// True in `share` of the cases.
    pub fn chance(&mut self, share: f64) -> bool {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64 <= share
    }
}
