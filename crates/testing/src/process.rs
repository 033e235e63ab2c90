//! Programs that a test runs, and recordings for them.

pub use crate::top;

use crate::program;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};
use tertius::bus::{LogWriter, Recording, Source};
use tertius::frame::{Frame, Id};

/// A process that does not outlive the test.
pub struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        self.kill();
    }
}

impl Running {
    /// Starts `program`, whose output and errors go to the end of the file `out`.
    pub fn start(program: &str, arguments: &[&str], out: &Path) -> Self {
        let file = File::options().create(true).append(true).open(out).expect("the folder is ours");
        let child = Command::new(program)
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(file.try_clone().expect("a file can be shared"))
            .stderr(file)
            .spawn();
        Self(child.unwrap_or_else(|error| panic!("{program}: {error}")))
    }

    /// Starts a gateway of the configuration `config` on the embedded bus, where it plays `log`, and returns it with
    /// the address of its page.
    pub fn gateway(config: &str, log: &str) -> (Self, String) {
        let child = Command::new(program())
            .args(["run", "--config", config, "--play", log])
            .stdin(Stdio::null())
            .stderr(Stdio::piped())
            .spawn();
        let mut child = child.expect("it starts");
        let lines = BufReader::new(child.stderr.take().expect("it is piped")).lines();
        let running = Self(child);
        let mut lines = lines.map_while(Result::ok);
        let page = lines.find_map(|line| Some(line.split_once("page: ")?.1.to_owned()));
        let page = page.expect("it tells where its page is");
        let url = page.split("/,").next().expect("an address").to_owned();
        // Whoever does not read it blocks it.
        std::thread::spawn(move || lines.for_each(drop));
        (running, url)
    }

    pub fn id(&self) -> u32 {
        self.0.id()
    }

    pub fn signal(&self, name: &str) {
        let pid = self.0.id().to_string();
        let sent = Command::new("kill").args(["-s", name, &pid]).status();
        assert!(sent.expect("kill runs").success());
    }

    /// As SIGKILL does: nothing can be said any more.
    pub fn kill(&mut self) {
        // It may have ended by itself.
        _ = self.0.kill();
        _ = self.0.wait();
    }

    pub fn end(&mut self) -> ExitStatus {
        let mut status = None;
        wait_for("a program's end", || {
            status = self.0.try_wait().expect("it is our child");
            status.is_some()
        });
        status.expect("it has ended")
    }
}

/// Waits, at most 30 s, for what other processes do.
#[track_caller]
pub fn wait_for(what: &str, mut done: impl FnMut() -> bool) {
    let started = Instant::now();
    while !done() {
        assert!(started.elapsed() < Duration::from_secs(30), "{what} took more than 30 s");
        // What is waited for may need the only processor that there is.
        std::thread::sleep(Duration::from_millis(5));
    }
}

pub fn said(log: &Path, text: &str) -> bool {
    std::fs::read_to_string(log).is_ok_and(|log| log.contains(text))
}

/// The configuration of the recorded machine, on `interface`, in `folder`.
pub fn configuration(folder: &Path, interface: &str) -> PathBuf {
    let text = std::fs::read_to_string(top().join("tests/recordings/e-type.toml")).expect("ships");
    let dbc = top().join("dbc/e-type.dbc");
    let text = text
        .replace("\"can0\"", &format!("{interface:?}"))
        .replace("\"../../dbc/e-type.dbc\"", &format!("{dbc:?}"));
    let path = folder.join("machine.toml");
    std::fs::write(&path, text).expect("the folder is ours");
    path
}

/// The frames of e-type-faults from `from` to `to` seconds.
pub fn excerpt(from: f64, to: f64) -> Vec<Frame> {
    let path = top().join("tests/recordings/e-type-faults.log.zst");
    let mut recording = Recording::open(&[path], Default::default()).expect("it ships");
    let (mut frames, mut first) = (Vec::new(), None);
    while let Some(frame) = recording.next_frame().expect("it is sound") {
        let t = frame.timestamp.since(*first.get_or_insert(frame.timestamp)).as_seconds();
        if t >= to {
            break;
        }
        if t >= from {
            frames.push(frame.clone());
        }
    }
    frames
}

/// Writes a recording.
pub fn write<'a>(path: &Path, interface: &str, frames: impl IntoIterator<Item = &'a Frame>) {
    let mut writer = LogWriter::new(Vec::new(), interface);
    frames.into_iter().for_each(|frame| writer.write(frame).expect("memory takes it"));
    std::fs::write(path, writer.into_inner()).expect("the folder is ours");
}

pub fn read(path: &Path) -> Vec<Frame> {
    let mut recording = Recording::open(&[path], Default::default()).expect("it was written");
    let mut frames = Vec::new();
    while let Some(frame) = recording.next_frame().expect("it can be read") {
        frames.push(frame.clone());
    }
    assert_eq!(recording.statistics().bad_lines, 0);
    frames
}

/// What is on the wire: identifiers and payloads.
pub fn wire(frames: &[Frame]) -> Vec<(Id, Vec<u8>)> {
    frames.iter().map(|frame| (frame.id, frame.data().to_vec())).collect()
}
