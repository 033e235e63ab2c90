//! `tertius run` and its HTTP, as a user meets them.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, ChildStderr, Command, Stdio};

/// A gateway whose interface never comes.
struct Running {
    child: Child,
    log: BufReader<ChildStderr>,
}

impl Running {
    fn start(config: &Path) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_tertius"))
            .args(["run", "--config"])
            .arg(config)
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts");
        let log = BufReader::new(child.stderr.take().expect("standard error is piped"));
        Self { child, log }
    }

    /// The next line of the log that has `text` in it.
    fn said(&mut self, text: &str) -> String {
        let mut all = String::new();
        loop {
            let mut line = String::new();
            let read = self.log.read_line(&mut line).expect("the log is UTF-8");
            all.push_str(&line);
            assert!(read > 0, "it ended without saying {text:?}:\n{all}");
            if line.contains(text) {
                return line;
            }
        }
    }

    fn signal(&self, signal: &str) {
        let pid = self.child.id().to_string();
        let sent = Command::new("kill").args([signal, &pid]).status().expect("kill runs");
        assert!(sent.success());
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        _ = self.child.kill();
        _ = self.child.wait();
    }
}

/// The shipped configuration, listening on `listen`.
fn write(folder: &Path, listen: &str) -> std::path::PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("config/e-type.toml")).expect("it is there");
    let dbc = root.join("dbc/e-type.dbc");
    let text = text
        .replace("\"can0\"", "\"no-such-can\"")
        .replace("../dbc/e-type.dbc", dbc.to_str().expect("the path is UTF-8"))
        .replace("127.0.0.1:9481", listen);
    let path = folder.join("machine.toml");
    std::fs::write(&path, text).expect("the folder is ours");
    path
}

#[test]
fn health_is_there_before_the_interface_and_moves_with_a_reload() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut running = Running::start(&write(folder.path(), "127.0.0.1:0"));
    let line = running.said("telemetry: http://127.0.0.1:");
    let address = line.split("http://").nth(1).and_then(|rest| rest.split('/').next());
    let address = address.expect("an address").to_owned();
    let mut stream = TcpStream::connect(&address).expect("it listens");
    stream.write_all(b"GET /health HTTP/1.1\r\nHost: localhost\r\n\r\n").expect("it reads");
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("it answers");
    assert!(answer.starts_with("HTTP/1.1 503 "), "{answer}");
    assert!(answer.contains(r#""status":"down","reason":"the interface is not open"#), "{answer}");
    // One that is taken: it stays where it was, and says what to do.
    let taken = TcpListener::bind("127.0.0.1:0").expect("a free port");
    write(folder.path(), &taken.local_addr().expect("it is bound").to_string());
    running.signal("-HUP");
    let line = running.said("no telemetry over HTTP on");
    assert!(line.contains("need a port each") && line.contains(&address), "{line}");
    write(folder.path(), "off");
    running.signal("-HUP");
    running.said("telemetry over HTTP is now off");
    running.signal("-TERM");
    assert_eq!(running.child.wait().expect("it ends").code(), Some(0));
}

#[test]
fn a_port_that_is_taken_does_not_stop_the_gateway() {
    let folder = tempfile::tempdir().expect("a folder");
    let taken = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let listen = taken.local_addr().expect("it is bound").to_string();
    let mut running = Running::start(&write(folder.path(), &listen));
    let line = running.said("no telemetry over HTTP on");
    assert!(line.contains(&listen) && line.contains("Several gateways on one computer"), "{line}");
    running.said("no bus");
    running.signal("-TERM");
    assert_eq!(running.child.wait().expect("it ends").code(), Some(0));
}

#[test]
fn an_address_that_is_none_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = Command::new(env!("CARGO_BIN_EXE_tertius"))
        .args(["run", "--config"])
        .arg(write(folder.path(), "localhost"))
        .output()
        .expect("it starts");
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("`http.listen` is") && said.contains("127.0.0.1:9481"), "{said}");
}
