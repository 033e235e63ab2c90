//! A gateway, a machine and a listener on a vcan interface of a test's own.

pub use crate::process::{Running, excerpt, wait_for};

use crate::{process, program};
use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::TempDir;
use tertius::bus::socket::{Options, SocketPort};
use tertius::bus::{Identifiers, Sent, Unrestricted, UnrestrictedPort};
use tertius::frame::{Frame, Id, Kind};
use tertius::time::Timestamp;

pub fn run(program: &str, arguments: &[&str]) {
    let output = Command::new(program).args(arguments).output();
    let output = output.unwrap_or_else(|error| panic!("{program}: {error}"));
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{program} {arguments:?}: {complaint}");
}

pub fn ip(arguments: &[&str]) {
    run("ip", arguments);
}

/// Tests take turns: there may be one processor, and a gateway that starves is late with reason.
static TURN: Mutex<()> = Mutex::new(());

/// A vcan interface with a configuration of the default machine on it.
pub struct Bench {
    pub interface: &'static str,
    folder: TempDir,
    _turn: MutexGuard<'static, ()>,
}

impl Bench {
    /// `interface` has at most 15 characters. It is not there yet.
    pub fn new(interface: &'static str) -> Self {
        let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
        let folder = tempfile::tempdir().expect("there is room");
        let bench = Self { interface, folder, _turn: turn };
        process::configuration(bench.folder.path(), interface);
        bench
    }

    /// The same, with its interface up.
    pub fn up(interface: &'static str) -> Self {
        let bench = Self::new(interface);
        bench.create();
        ip(&["link", "set", "up", interface]);
        bench
    }

    pub fn create(&self) {
        ip(&["link", "add", "dev", self.interface, "type", "vcan"]);
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The same as text.
    pub fn name(&self, name: &str) -> String {
        self.path(name).to_str().expect("temporary folders have plain names").to_owned()
    }

    pub fn configuration(&self) -> String {
        fs::read_to_string(self.path("machine.toml")).expect("it was written")
    }

    pub fn configure(&self, text: &str) {
        fs::write(self.path("machine.toml"), text).expect("the folder is ours");
    }

    /// Starts a gateway and waits until it has opened the interface once more.
    pub fn gateway(&self) -> Running {
        let opened = format!("open: {}", self.interface);
        let before = self.said(&opened);
        let gateway = self.start_gateway();
        wait_for("the gateway's start", || self.said(&opened) > before);
        gateway
    }

    pub fn start_gateway(&self) -> Running {
        let config = self.name("machine.toml");
        Running::start(program(), &["run", "--config", &config], &self.path("gateway.log"))
    }

    /// How often the gateway said `text`.
    pub fn said(&self, text: &str) -> usize {
        fs::read_to_string(self.path("gateway.log")).map_or(0, |log| log.matches(text).count())
    }

    /// Starts candump into `bus.log`, and waits until it listens.
    pub fn candump(&self) -> Running {
        // Its usual receive buffer holds a fifth of a second, less than a busy box may take.
        let arguments = ["-r", "16777216", "-L", self.interface];
        let dump = Running::start("candump", &arguments, &self.path("bus.log"));
        let mut hello = self.machine();
        let id = Id::standard(0x7FF).expect("eleven bits");
        // It says nothing when it is ready; its first line shows it.
        wait_for("candump's start", || {
            let frame = Frame::new(Timestamp::default(), id, Kind::Data, &[]);
            assert_eq!(hello.send_unrestricted(&frame).expect("it is up"), Sent::Taken);
            fs::read_to_string(self.path("bus.log")).is_ok_and(|log| log.contains("7FF"))
        });
        dump
    }

    /// A port that sends whatever it is given, and hears nothing.
    pub fn machine(&self) -> Unrestricted<SocketPort> {
        let nothing = Options { identifiers: Identifiers::Only(vec![]), ..Options::default() };
        Unrestricted::<SocketPort>::open(self.interface, &nothing).expect("the interface is up")
    }

    /// Plays `frames` in their own time, by canplayer.
    pub fn play(&self, frames: &[Frame]) {
        self.write(frames);
        run("canplayer", &["-I", &self.name("played.log")]);
    }

    /// Plays `frames` until what is waited for has come.
    pub fn play_until(&self, frames: &[Frame], what: &str, done: impl FnMut() -> bool) {
        self.write(frames);
        let arguments = ["-I", &self.name("played.log")];
        let _player = Running::start("canplayer", &arguments, &self.path("player.log"));
        wait_for(what, done);
    }

    fn write(&self, frames: &[Frame]) {
        process::write(&self.path("played.log"), self.interface, frames);
    }

    /// Stops the gateway, and waits until candump has its last status.
    pub fn stop(&self, gateway: Running) {
        gateway.signal("TERM");
        wait_for("the end", || self.said("stopped") == 1);
        wait_for("its stopping status", || {
            let own = self.own_lines();
            wire(&own).last().and_then(|it| Status::read(it)).is_some_and(|it| it.mode() == 4)
        });
    }

    /// What candump saw of the gateway's own frames, as lines of a log.
    pub fn own_lines(&self) -> Vec<String> {
        let log = fs::read_to_string(self.path("bus.log")).expect("candump wrote");
        let own = |line: &&str| ["1D1#", "2D1#", "3D1#"].iter().any(|id| line.contains(id));
        log.lines().filter(own).map(str::to_owned).collect()
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        // A test may have deleted it; a controller cannot be.
        _ = Command::new("ip").args(["link", "delete", self.interface]).output();
    }
}

/// What is on the wire of a log's line: identifier and payload.
pub fn wire(lines: &[String]) -> Vec<&str> {
    lines.iter().map(|line| line.rsplit(' ').next().expect("a line has words")).collect()
}

/// The payload of an Fd_Status on the wire.
pub struct Status(u64);

impl Status {
    /// `None` if it is another frame.
    pub fn read(wire: &str) -> Option<Self> {
        let data = wire.strip_prefix("1D1#")?;
        let bits = u64::from_str_radix(data, 16).expect("candump writes hexadecimal digits");
        Some(Self(bits.swap_bytes()))
    }

    pub fn healthy(&self) -> usize {
        (0..12).filter(|i| self.0 >> (24 + 2 * i) & 0b11 == 1).count()
    }

    pub fn mode(&self) -> u64 {
        self.0 >> 51 & 0b111
    }
}
