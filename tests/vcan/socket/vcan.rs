//! Interfaces of a test's own, so that tests do not hear each other.

use std::process::Command;

use tertius::bus::socket::{Options, SocketPort};
use tertius::bus::{Identifiers, Unrestricted};

/// A vcan interface that lasts as long as this does.
pub struct Vcan(&'static str);

impl Vcan {
    /// Up, ready for CAN FD. `name` has at most 15 characters.
    pub fn new(name: &'static str) -> Self {
        let vcan = Self(name);
        vcan.create();
        vcan
    }

    pub fn create(&self) {
        ip(&["link", "add", "dev", self.0, "mtu", "72", "type", "vcan"]);
        self.up();
    }

    pub fn up(&self) {
        ip(&["link", "set", "up", self.0]);
    }

    pub fn down(&self) {
        ip(&["link", "set", "down", self.0]);
    }

    pub fn delete(&self) {
        ip(&["link", "delete", self.0]);
    }

    pub fn open(&self, options: &Options) -> SocketPort {
        SocketPort::open(self.0, options).unwrap()
    }

    /// Receives all.
    pub fn open_all(&self) -> SocketPort {
        self.open(&Options::default())
    }

    /// The machine's side: sends whatever it is given, and hears nothing.
    pub fn machine(&self) -> Unrestricted<SocketPort> {
        let options = Options { identifiers: Identifiers::Only(Vec::new()), ..Options::default() };
        Unrestricted::open(self.0, &options).unwrap()
    }
}

impl Drop for Vcan {
    fn drop(&mut self) {
        // A test may have deleted it.
        let _ = Command::new("ip").args(["link", "delete", self.0]).output();
    }
}

pub fn ip(arguments: &[&str]) {
    run("ip", arguments);
}

/// Runs a program that must succeed.
pub fn run(program: &str, arguments: &[&str]) {
    let output = Command::new(program).args(arguments).output();
    let output = output.unwrap_or_else(|error| panic!("cannot run {program}: {error}"));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{program} {arguments:?}: {said}");
}
