//! Runs the oracles in Python, which are in `tests/oracle`.

pub use crate::top;

use serde_json::Value;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::OnceLock;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

/// Longest wait for a line of a peer.
const PATIENCE: Duration = Duration::from_secs(60);

/// The interpreter of the project's virtual environment, which is made on first use.
///
/// # Panics
/// If it cannot be had: a comparison that cannot run has failed.
pub fn python() -> &'static Path {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| {
        let output = Command::new(top().join("scripts/oracle-python"))
            .stderr(Stdio::inherit())
            .output()
            .expect("scripts/oracle-python starts");
        assert!(output.status.success(), "scripts/oracle-python failed; its reasons are above");
        let path = String::from_utf8(output.stdout).expect("a path in UTF-8");
        PathBuf::from(path.trim_end())
    })
}

/// Runs `tests/oracle/{script}` at the repository's top with `input` on its standard input, and
/// returns what it wrote to its standard output.
///
/// # Panics
/// If it does not end with success; what it wrote to standard error is in the message.
pub fn run(script: &str, arguments: &[&str], input: &str) -> String {
    let mut child = Command::new(python())
        .arg(top().join("tests/oracle").join(script))
        .args(arguments)
        .current_dir(top())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the interpreter starts");
    let mut stdin = child.stdin.take().expect("standard input is piped");
    let input = input.to_owned();
    // A thread of its own, so that neither side waits on a full pipe. A script that fails early
    // closes its end, and then its own message counts, not ours.
    let writer = std::thread::spawn(move || drop(stdin.write_all(input.as_bytes())));
    let output = child.wait_with_output().expect("the script's output");
    writer.join().expect("the writer does not panic");
    assert!(
        output.status.success(),
        "{script} failed ({}):\n{}",
        output.status,
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).expect("the script writes UTF-8")
}

/// A script that goes on beside the test: it writes lines of JSON, and reads what it is told. It ends with this.
pub struct Peer {
    child: Child,
    stdin: ChildStdin,
    lines: Receiver<Value>,
}

impl Peer {
    /// Starts `tests/oracle/{script}`.
    ///
    /// # Panics
    /// If it does not start.
    pub fn start(script: &str, arguments: &[&str]) -> Self {
        let mut child = Command::new(python())
            .arg(top().join("tests/oracle").join(script))
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the interpreter starts");
        let out = BufReader::new(child.stdout.take().expect("it is piped"));
        let (told, lines) = channel();
        std::thread::spawn(move || {
            for line in out.lines().map_while(Result::ok) {
                let line = serde_json::from_str(&line).expect("JSON");
                if told.send(line).is_err() {
                    return;
                }
            }
        });
        let stdin = child.stdin.take().expect("it is piped");
        Self { child, stdin, lines }
    }

    /// The next line.
    ///
    /// # Panics
    /// If it does not come within a minute.
    #[track_caller]
    pub fn next_line(&self) -> Value {
        self.lines.recv_timeout(PATIENCE).expect("it comes in time")
    }

    /// Tells it a line.
    ///
    /// # Panics
    /// If it does not read any more.
    #[track_caller]
    pub fn tell(&mut self, line: &str) {
        writeln!(self.stdin, "{line}").expect("it reads");
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        _ = self.child.kill();
        _ = self.child.wait();
    }
}
