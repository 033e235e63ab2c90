//! An MQTT broker, mosquitto, and a subscriber of it.

use crate::oracle::top;
use crate::process::Running;
use serde_json::Value;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Longest wait for what has to come.
const PATIENCE: Duration = Duration::from_secs(60);

/// The broker's program, which is installed on first use.
fn mosquitto() -> &'static Path {
    static MOSQUITTO: OnceLock<PathBuf> = OnceLock::new();
    MOSQUITTO.get_or_init(|| {
        let output =
            Command::new(top().join("scripts/mosquitto")).stderr(Stdio::inherit()).output();
        let output = output.expect("scripts/mosquitto starts");
        assert!(output.status.success(), "scripts/mosquitto failed; its reasons are above");
        let path = String::from_utf8(output.stdout).expect("a path in UTF-8");
        PathBuf::from(path.trim_end())
    })
}

/// A broker on a port of its own, which can be stopped and started again.
pub struct Broker {
    folder: PathBuf,
    pub port: u16,
    running: Option<Running>,
}

impl Broker {
    /// Starts a broker that keeps its files in `folder`; `more` are further lines of its configuration.
    ///
    /// # Panics
    /// If it does not start.
    pub fn start(folder: &Path, more: &str) -> Self {
        let free = TcpListener::bind("127.0.0.1:0").expect("loopback has a free port");
        let port = free.local_addr().expect("it has an address").port();
        drop(free);
        let plain = if more.contains("allow_anonymous") { "" } else { "allow_anonymous true\n" };
        // Started as root, it would become another user, who may not read the folder.
        let kept = folder.display();
        let config = format!(
            "listener {port} 127.0.0.1\nuser root\npersistence true\npersistence_location {kept}/\n\
             max_queued_messages 0\n{plain}{more}"
        );
        fs::write(folder.join("mosquitto.conf"), config).expect("the folder is ours");
        let mut broker = Self { folder: folder.to_owned(), port, running: None };
        broker.restart();
        broker
    }

    /// Makes `file` a file of users with this one.
    ///
    /// # Panics
    /// If mosquitto_passwd does not.
    pub fn user(file: &Path, name: &str, password: &str) {
        let made = Command::new(mosquitto().with_file_name("mosquitto_passwd"));
        let fallback = |mut command: Command| {
            command.args(["-b", "-c"]).arg(file).args([name, password]).status()
        };
        let status = fallback(made).or_else(|_| fallback(Command::new("mosquitto_passwd")));
        assert!(status.expect("mosquitto_passwd starts").success());
    }

    /// Starts it, with what it has kept.
    ///
    /// # Panics
    /// If it does not start.
    pub fn restart(&mut self) {
        let config = self.folder.join("mosquitto.conf");
        let log = self.folder.join("mosquitto.log");
        let program = mosquitto().to_str().expect("UTF-8");
        let arguments = ["-c", config.to_str().expect("UTF-8")];
        self.running = Some(Running::start(program, &arguments, &log));
        let started = Instant::now();
        while TcpStream::connect(("127.0.0.1", self.port)).is_err() {
            let said = fs::read_to_string(&log).unwrap_or_default();
            assert!(started.elapsed() < PATIENCE, "mosquitto does not listen: {said}");
            std::thread::yield_now();
        }
    }

    /// Ends it; what its sessions wait for is kept.
    ///
    /// # Panics
    /// If it does not run.
    pub fn stop(&mut self) {
        let mut running = self.running.take().expect("it runs");
        running.signal("TERM");
        running.end();
    }

    /// What it has logged.
    ///
    /// # Panics
    /// If it was never started.
    pub fn log(&self) -> String {
        fs::read_to_string(self.folder.join("mosquitto.log")).expect("it was started")
    }

    /// Subscribes to `topic` with QoS 1 and a session that outlives both ends; `more` are further options of mosquitto_sub.
    ///
    /// # Panics
    /// If mosquitto_sub does not start.
    pub fn subscribe(&self, topic: &str, more: &[&str]) -> Subscriber {
        _ = mosquitto();
        let port = self.port.to_string();
        let child = Command::new("mosquitto_sub")
            .args([
                "-V",
                "5",
                "-h",
                "localhost",
                "-p",
                &port,
                "-q",
                "1",
                "-t",
                topic,
                "-F",
                "%r %t %p",
            ])
            .args(["-c", "-i", &format!("watcher-{}", topic.len()), "-x", "86400"])
            .args(more)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn();
        let mut child = child.expect("mosquitto_sub starts");
        let out = BufReader::new(child.stdout.take().expect("it is piped"));
        let (told, messages) = channel();
        std::thread::spawn(move || {
            for line in out.lines().map_while(Result::ok) {
                if told.send(Message::new(&line)).is_err() {
                    return;
                }
            }
        });
        Subscriber { child, messages }
    }
}

/// A message as a subscriber gets it.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// Whether the broker kept it for whoever comes.
    pub retained: bool,
    pub topic: String,
    pub payload: Value,
}

impl Message {
    fn new(line: &str) -> Self {
        let mut parts = line.splitn(3, ' ');
        let mut next = || parts.next().expect("retained, topic, payload").to_owned();
        let (retained, topic) = (next() == "1", next());
        let payload = serde_json::from_str(&next()).expect("JSON");
        Self { retained, topic, payload }
    }
}

/// mosquitto_sub.
pub struct Subscriber {
    child: Child,
    messages: Receiver<Message>,
}

impl Subscriber {
    /// The next message.
    ///
    /// # Panics
    /// If none comes.
    pub fn next(&mut self) -> Message {
        match self.messages.recv_timeout(PATIENCE) {
            Ok(message) => message,
            Err(RecvTimeoutError::Timeout) => panic!("no message for {PATIENCE:?}"),
            Err(RecvTimeoutError::Disconnected) => {
                let mut said = String::new();
                let errors = self.child.stderr.as_mut().expect("it is piped");
                _ = errors.read_to_string(&mut said);
                panic!("mosquitto_sub has ended: {said}")
            }
        }
    }

    /// The next message for which `is` holds.
    ///
    /// # Panics
    /// If none comes.
    pub fn find(&mut self, is: impl Fn(&Message) -> bool) -> Message {
        loop {
            let message = self.next();
            if is(&message) {
                return message;
            }
        }
    }
}

impl Drop for Subscriber {
    fn drop(&mut self) {
        // It may have ended by itself.
        _ = self.child.kill();
        _ = self.child.wait();
    }
}
