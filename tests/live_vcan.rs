//! `tertius run` on a real SocketCAN: a recording is played on vcan0 while candump listens, and what
//! the gateway sent is what `tertius replay` says of candump's log.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use tertius::bus::socket::{Options, SocketPort};
use tertius::bus::{Identifiers, Recording, Sent, Source, Unrestricted, UnrestrictedPort};
use tertius::frame::{Frame, Id};
use tertius::time::Timestamp;

const TERTIUS: &str = env!("CARGO_BIN_EXE_tertius");

/// A process that does not outlive the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        _ = self.0.kill();
        _ = self.0.wait();
    }
}

impl Running {
    fn signal(&self, name: &str) {
        let pid = self.0.id().to_string();
        assert!(
            Command::new("kill").args(["-s", name, &pid]).status().expect("kill runs").success()
        );
    }
}

fn top() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The configuration of the simulated machine, on vcan0.
fn configuration(folder: &Path) -> PathBuf {
    let text = std::fs::read_to_string(top().join("tests/recordings/e-type.toml")).expect("ships");
    let dbc = top().join("dbc/e-type.dbc");
    let text = text
        .replace("\"can0\"", "\"vcan0\"")
        .replace("\"../../dbc/e-type.dbc\"", &format!("{dbc:?}"));
    let path = folder.join("machine.toml");
    std::fs::write(&path, text).expect("the folder is ours");
    path
}

/// The frames of e-type-faults from `from` to `to` seconds.
fn excerpt(from: f64, to: f64) -> Vec<Frame> {
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

fn wait_for(what: &str, mut done: impl FnMut() -> bool) {
    let started = Instant::now();
    while !done() {
        assert!(started.elapsed() < Duration::from_secs(20), "{what} took more than 20 s");
        std::thread::yield_now();
    }
}

fn now() -> Timestamp {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).expect("it is after 1970");
    Timestamp::from_nanos(i64::try_from(since.as_nanos()).expect("and before 2262"))
}

/// Plays `frames` in their own time.
fn play(port: &mut dyn UnrestrictedPort, frames: &[Frame]) {
    let (first, start) = (frames[0].timestamp, now());
    for frame in frames {
        let due = frame.timestamp.since(first);
        wait_for("a frame's turn", || now().since(start) >= due);
        wait_for("room in the queue", || matches!(port.send_unrestricted(frame), Ok(Sent::Taken)));
    }
}

/// What is on the wire of the gateway's own frames, in a candump log.
fn own_frames(log: &Path) -> Vec<(Id, Vec<u8>)> {
    let mut recording = Recording::open(&[log], Default::default()).expect("it was written");
    let mut frames = Vec::new();
    while let Some(frame) = recording.next_frame().expect("candump writes sound lines") {
        if !frame.id.is_extended() && matches!(frame.id.value(), 0x1D1 | 0x2D1 | 0x3D1) {
            frames.push((frame.id, frame.data().to_vec()));
        }
    }
    frames
}

fn start(program: &str, arguments: &[&str], out: &Path) -> Running {
    let file = std::fs::File::create(out).expect("the folder is ours");
    let child = Command::new(program)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(file.try_clone().expect("a file can be shared"))
        .stderr(file)
        .spawn();
    Running(child.unwrap_or_else(|error| panic!("{program}: {error}")))
}

fn said(log: &Path, text: &str) -> bool {
    std::fs::read_to_string(log).is_ok_and(|log| log.contains(text))
}

#[test]
fn what_it_sends_live_is_what_a_replay_of_the_simultaneous_candump_says() {
    let folder = tempfile::tempdir().expect("there is room");
    let path = |name: &str| folder.path().join(name);
    let config = configuration(folder.path());
    let config = config.to_str().expect("temporary folders have plain names");
    let dump = start("candump", &["-L", "vcan0"], &path("bus.log"));
    let gateway = start(TERTIUS, &["run", "--config", config], &path("gateway.log"));
    wait_for("the gateway's start", || said(&path("gateway.log"), "open: vcan0"));
    let nothing = Options { identifiers: Identifiers::Only(vec![]), ..Options::default() };
    let mut machine = Unrestricted::<SocketPort>::open("vcan0", &nothing).expect("vcan0 is up");
    // candump says nothing when it is ready; its first line shows it.
    wait_for("candump's start", || {
        let hello =
            Frame::new(now(), Id::standard(0x7FF).expect("ok"), tertius::frame::Kind::Data, &[]);
        machine.send_unrestricted(&hello).expect("vcan0 is up");
        said(&path("bus.log"), "7FF")
    });
    // Steps of 1.25 mm at 60 s; they end at 65 s.
    play(&mut machine, &excerpt(57.0, 66.5));
    gateway.signal("TERM");
    wait_for("the end", || said(&path("gateway.log"), "stopped"));
    wait_for("candump's last line", || said(&path("bus.log"), "1D1#"));
    drop((gateway, dump));

    let bus = path("bus.log");
    let warnings = path("warnings.log");
    let replay = Command::new(TERTIUS)
        .args(["replay", bus.to_str().expect("plain"), "--config", config, "--format", "jsonl"])
        .arg("--warnings")
        .arg(&warnings)
        .output()
        .expect("it runs");
    assert!(replay.status.success(), "{}", String::from_utf8_lossy(&replay.stderr));
    let lines = String::from_utf8(replay.stdout).expect("JSON is UTF-8");
    assert!(lines.contains("\"detector\":\"fde1\""), "the step was found: {lines}");

    let (mut live, replayed) = (own_frames(&bus), own_frames(&warnings));
    // The last is that it stops, which no recording knows.
    let last = live.pop().expect("it sent at least its status");
    assert_eq!((last.0.value(), last.1[6] >> 3 & 0b111), (0x1D1, 4), "its last words");
    assert!(live.len() > 90, "{} frames", live.len());
    // After the machine's last frame the gateway goes on to say that it lives; a recording that has
    // ended says no more.
    let common = live.len().min(replayed.len());
    assert!(replayed.len() - common <= 1, "{} {}", live.len(), replayed.len());
    assert!(live[..common] == replayed[..common], "live and replay differ");
    assert!(live[common..].iter().all(|(id, _)| id.value() == 0x1D1));
}

#[test]
fn it_survives_its_interface_and_a_bad_configuration() {
    let folder = tempfile::tempdir().expect("there is room");
    let path = |name: &str| folder.path().join(name);
    let config = configuration(folder.path());
    let text = std::fs::read_to_string(&config).expect("just written");
    std::fs::write(&config, text.replace("\"vcan0\"", "\"vcan7\"")).expect("ours");
    let ip = |arguments: &[&str]| {
        assert!(Command::new("ip").args(arguments).status().expect("ip runs").success());
    };
    let log = path("gateway.log");
    let times =
        |text: &str| std::fs::read_to_string(&log).map_or(0, |log| log.matches(text).count());
    let name = config.to_str().expect("plain").to_owned();
    let gateway = start(TERTIUS, &["run", "--config", &name], &log);
    wait_for("it to miss its interface", || times("no interface vcan7") == 1);
    ip(&["link", "add", "dev", "vcan7", "type", "vcan"]);
    wait_for("it to see the interface down", || times("is down") == 1);
    ip(&["link", "set", "up", "vcan7"]);
    wait_for("it to open the interface", || times("open: vcan7") == 1);
    ip(&["link", "set", "down", "vcan7"]);
    ip(&["link", "set", "up", "vcan7"]);
    wait_for("it to open it again", || times("open: vcan7") == 2);
    ip(&["link", "delete", "vcan7"]);
    ip(&["link", "add", "dev", "vcan7", "type", "vcan"]);
    ip(&["link", "set", "up", "vcan7"]);
    wait_for("it to open the new one", || times("open: vcan7") == 3);

    let sound = std::fs::read_to_string(&config).expect("still there");
    std::fs::write(&config, sound.replace("cylinders = 6", "cylinders = 66")).expect("ours");
    gateway.signal("HUP");
    wait_for("the refusal", || times("the old one goes on") == 1);
    assert!(times("machine.cylinders") == 1, "with its reason");
    std::fs::File::create(&config)
        .and_then(|mut file| file.write_all(sound.as_bytes()))
        .expect("ours");
    gateway.signal("HUP");
    wait_for("the new configuration", || times("was read again") == 1);
    wait_for("it to open the interface for it", || times("open: vcan7") == 4);
    gateway.signal("TERM");
    wait_for("the end", || times("stopped") == 1);
    ip(&["link", "delete", "vcan7"]);
}
