//! The flight recorder: an incident leaves a folder whose replay says the same to the byte, and nothing that befalls
//! the disk changes what is sent.

use super::live_gateway::gateway_of;
use serde_json::value::RawValue;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tertius::alarm::{OwnFrame, Warning};
use tertius::appliance::flight::{FlightPlan, FlightRecorder, MANIFEST, STATE_FILE};
use tertius::appliance::telemetry::Telemetry;
use tertius::appliance::telemetry::clock::SystemClock;
use tertius::bus::embedded::{Clock, EmbeddedBus, ManualClock};
use tertius::bus::{Identifiers, UnrestrictedPort};
use tertius::config::{Fingerprints, MachineNames};
use tertius::frame::{Frame, Id, Kind};
use tertius::incident::Incident;
use tertius::live::gateway::Journal;
use tertius::time::{Span, Timestamp};
use tertius_testing::machine::{Cycle, design_of_default, monitor};
use tertius_testing::process::{configuration, excerpt, read, write};
use tertius_testing::program;

fn tertius(arguments: &[&str]) -> Output {
    Command::new(program()).args(arguments).output().expect("it runs")
}

fn plain(path: &Path) -> &str {
    path.to_str().expect("temporary folders have plain names")
}

/// The folders in a folder, sorted by name.
fn folders(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("it is there").path()).collect();
    paths.sort();
    paths
}

#[derive(serde::Deserialize)]
struct Manifest {
    cause: String,
    incident: Option<u32>,
    frames: u64,
    lost: u64,
    complete: bool,
    lines: Vec<Box<RawValue>>,
}

fn manifest(folder: &Path) -> Manifest {
    let text = fs::read_to_string(folder.join(MANIFEST)).expect("every recording has one");
    serde_json::from_str(&text).expect("it is JSON")
}

/// The lines of a replay that tell of incident `number`.
fn replayed(folder: &Path, number: u32) -> Vec<String> {
    let output = tertius(&["replay", plain(folder), "--format", "jsonl"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    let of_it = format!(r#""incident":{number},"state":"#);
    text.lines().filter(|line| line.contains(&of_it)).map(str::to_owned).collect()
}

/// The gateway of the recorded machine, for which `frames` are played, with a recorder.
fn record(folder: &Path, frames: &[Frame], keys: &str) -> PathBuf {
    let (log, config) = (folder.join("bus.log"), configuration(folder, "virtual"));
    write(&log, "can0", frames);
    let text = fs::read_to_string(&config).expect("it was written");
    fs::write(&config, format!("{text}\n[recorder]\nfolder = \"recordings\"\n{keys}"))
        .expect("ours");
    let run = ["run", "--config", plain(&config), "--play", plain(&log), "--speed", "max"];
    let output = tertius(&run);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    folder.join("recordings")
}

/// Steps of C1 at 60 and 75 s, each for 5 s. The recording is so short that the recorder has room for all of it, however
/// late its worker is.
#[test]
fn the_folder_of_an_incident_replays_to_the_same_incident() {
    let top = tempfile::tempdir().expect("there is room");
    let recordings = record(top.path(), &excerpt(44.0, 70.0), "before = 4\nafter = 7\n");
    let found = folders(&recordings);
    let [folder] = found.as_slice() else { panic!("one incident, not {found:?}") };
    assert!(plain(folder).ends_with("20231114T221420Z-cylinder-1-incident-1"), "{folder:?}");
    // As on another computer: nothing of the machine is where it was.
    let elsewhere = top.path().join("elsewhere");
    fs::rename(folder, &elsewhere).expect("the folder is ours");
    fs::remove_file(top.path().join("machine.toml")).expect("the folder is ours");
    let told = manifest(&elsewhere);
    assert_eq!((told.cause.as_str(), told.incident, told.lost), ("incident", Some(1), 0));
    assert!(told.complete && elsewhere.join(STATE_FILE).is_file());
    let lines: Vec<&str> = told.lines.iter().map(|line| line.get()).collect();
    assert!(lines[0].contains(r#""state":"opened""#), "{lines:?}");
    assert_eq!(replayed(&elsewhere, 1), lines);
    let frames = read(&elsewhere.join("frames.log.zst"));
    assert_eq!(frames.len() as u64, told.frames);
    // From at most the time between two states before, until a block after.
    let (first, last) = (frames[0].timestamp, frames[frames.len() - 1].timestamp);
    let [begin, end] = [1_700_000_060.0 - first.as_seconds(), last.as_seconds() - 1_700_000_060.0];
    assert!((4.0..16.0).contains(&begin) && (7.0..9.0).contains(&end), "{begin} {end}");
    assert!(frames.iter().any(|frame| frame.id.value() == 0x2D1), "the gateway's own are in it");
    let page = tertius(&["replay", plain(&elsewhere)]);
    assert!(String::from_utf8_lossy(&page.stdout).contains("step"));
}

#[test]
fn a_recording_has_the_values_that_were_set_and_with_others_it_begins_anew() {
    let top = tempfile::tempdir().expect("there is room");
    let (log, config) = (top.path().join("bus.log"), configuration(top.path(), "can0"));
    write(&log, "can0", &excerpt(50.0, 63.0));
    let run = ["run", "--config", plain(&config), "--play", plain(&log), "--speed", "max"];
    let set = ["--set", "bus.interface=virtual", "--set", "recorder.folder=recordings"];
    let output = tertius(&[&run[..], &set, &["--set", "comparator.bound=0.00145"]].concat());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    assert!(said.contains("with --set bus.interface=virtual --set recorder.folder"), "{said}");

    let folder = &folders(&top.path().join("recordings"))[0];
    let machine = fs::read_to_string(folder.join("machine.toml")).expect("it is there");
    assert!(machine.contains("bound = 0.00145"), "{machine}");
    let lines: Vec<String> =
        manifest(folder).lines.iter().map(|line| line.get().to_owned()).collect();
    // The values are those in the folder, so that its state fits, and they may be given once more.
    assert_eq!(replayed(folder, 1)[..lines.len()], lines);
    let replay = ["replay", plain(folder), "--format", "jsonl"];
    let again = tertius(&[&replay[..], &["--set", "comparator.bound=0.00145"]].concat());
    assert_eq!(again.stdout, tertius(&replay).stdout);
    // With others the state of the folder would be refused.
    let other = tertius(&[&replay[..], &["--set", "comparator.bound=0.01"]].concat());
    assert!(other.status.success(), "{}", String::from_utf8_lossy(&other.stderr));
    assert_ne!(other.stdout, again.stdout);
}

#[test]
fn a_state_that_was_changed_is_refused_with_a_way_out() {
    let top = tempfile::tempdir().expect("there is room");
    let recordings = record(top.path(), &excerpt(50.0, 63.0), "");
    let folder = &folders(&recordings)[0];
    assert!(!manifest(folder).complete, "the gateway stopped before");
    let state = folder.join(STATE_FILE);
    let mut bytes = fs::read(&state).expect("it is there");
    bytes[1000] ^= 1;
    fs::write(&state, bytes).expect("the folder is ours");
    let output = tertius(&["replay", plain(folder)]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("--config FOLDER/machine.toml"), "{said}");
    let config = folder.join("machine.toml");
    assert!(tertius(&["replay", plain(folder), "--config", plain(&config)]).status.success());
    let output = tertius(&["replay", plain(&recordings)]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("the configuration is missing"), "{said}");
}

/// A gateway on the embedded bus with a recorder, and what it has told and sent.
struct Recorded {
    flight: FlightRecorder,
    incidents: Vec<Incident>,
    warnings: Vec<Warning>,
    sent: Vec<Frame>,
}

impl Journal for Recorded {
    fn frame(&mut self, frame: &Frame) {
        self.flight.frame(frame);
    }

    fn warning(&mut self, warning: &Warning) {
        self.warnings.push(*warning);
    }

    fn incident(&mut self, incident: &Incident) {
        self.flight.incident(incident);
        self.incidents.push(*incident);
    }

    fn sent(&mut self, frame: &OwnFrame, at: Timestamp) {
        self.flight.sent(frame, at);
        self.sent.push(frame.as_frame().clone());
    }
}

fn plan(folder: &Path) -> FlightPlan {
    FlightPlan {
        folder: folder.to_owned(),
        before: Span::from_seconds(5.0),
        after: Span::from_seconds(2.0),
        size: 10_000_000,
        machine: "made by hand".to_owned(),
        names: MachineNames::default(),
        fingerprints: Fingerprints::default(),
        interfaces: vec!["can0".to_owned()],
        files: Vec::new(),
        design: design_of_default().checksum(),
    }
}

/// Runs `frames` through a gateway that records by `plan`; `then` is done before it stops.
fn run(frames: &[Frame], plan: Option<FlightPlan>, then: impl FnOnce(&FlightRecorder)) -> Recorded {
    let telemetry = Arc::new(Telemetry::new(&SystemClock::new()));
    let clock = ManualClock::new(frames[0].timestamp);
    let bus = EmbeddedBus::new(Clock::Manual(clock.clone()));
    let mut port = bus.open(&Identifiers::All, 4096).expect("the bus is up");
    let mut machine = bus.open_unrestricted(&Identifiers::Only(Vec::new()), 1).expect("up");
    let mut gateway = gateway_of(monitor(), 0.05);
    let flight = FlightRecorder::new(&telemetry);
    let (incidents, warnings, sent) = (Vec::new(), Vec::new(), Vec::new());
    let mut recorded = Recorded { flight, incidents, warnings, sent };
    recorded.flight.follow(plan, gateway.monitor());
    for frame in frames {
        clock.set(frame.timestamp);
        machine.send_unrestricted(frame).expect("the bus is up");
        gateway.turn(&mut port, Duration::ZERO, &mut recorded).expect("the bus is up");
        recorded.flight.turned(&gateway);
    }
    then(&recorded.flight);
    recorded.flight.finish();
    recorded
}

/// 16 s, with a step of C1 at 8 s.
fn traffic() -> Vec<Frame> {
    let cycles = (0..800).flat_map(|k| {
        let offset = if (400..500).contains(&k) { 30 } else { 0 };
        Cycle { offset, ..Cycle::new(k) }.frames()
    });
    cycles.collect()
}

#[test]
fn neither_a_recorder_nor_its_disk_changes_what_is_sent() {
    let top = tempfile::tempdir().expect("there is room");
    let frames = traffic();
    let without = run(&frames, None, |_| {});
    assert!(!without.incidents.is_empty());
    let [good, file] = ["recordings", "file"].map(|name| top.path().join(name));
    fs::write(&file, "not a folder").expect("the folder is ours");
    let no_room = FlightPlan { size: 10, ..plan(&top.path().join("small")) };
    for plan in [plan(&good), plan(&file), no_room] {
        let with = run(&frames, Some(plan), |_| {});
        assert_eq!(with.warnings, without.warnings);
        assert_eq!(with.incidents, without.incidents);
        assert_eq!(with.sent, without.sent);
    }
    let opened = without.incidents.iter().filter(|it| it.progress.name() == "opened").count();
    assert_eq!(folders(&good).len(), opened);
    assert!(folders(&top.path().join("small")).is_empty());
}

#[test]
fn what_is_asked_for_has_all_that_was_on_the_bus() {
    let top = tempfile::tempdir().expect("there is room");
    let mut frames: Vec<Frame> = (0..300).flat_map(|k| Cycle::new(k).frames()).collect();
    // What the monitor does not use.
    let other = Id::extended(0x12345).expect("29 bits");
    let stamp = frames[frames.len() - 1].timestamp;
    frames.push(Frame::new(stamp, other, Kind::Data, &[1, 2, 3]));
    let recorded = run(&frames, Some(plan(top.path())), |flight| {
        flight.demand().store(true, Ordering::Relaxed);
    });
    let found = folders(top.path());
    let [folder] = found.as_slice() else { panic!("one recording, not {found:?}") };
    assert!(plain(folder).ends_with("-on-demand"), "{folder:?}");
    let told = manifest(folder);
    assert_eq!((told.cause.as_str(), told.incident, told.lost), ("on demand", None, 0));
    let found = read(&folder.join("frames.log.zst"));
    let is_own = |frame: &&Frame| [0x1D1, 0x2D1, 0x3D1].contains(&frame.id.value());
    let (own, theirs): (Vec<&Frame>, Vec<&Frame>) = found.iter().partition(is_own);
    assert!(theirs == frames.iter().collect::<Vec<_>>(), "{} of {}", theirs.len(), frames.len());
    assert_eq!(own.len(), recorded.sent.len());
}
