//! What the ship's own systems read over Modbus TCP and MQTT is what the gateway's frames say at the same time.

use crate::metrics_support::Bench;
use crate::mqtt;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;
use tertius::appliance::outputs::StateServer;
use tertius::appliance::outputs::modbus::ModbusServer;
use tertius::appliance::outputs::mqtt::{MqttPlan, MqttPublisher};
use tertius::bus::embedded::{BusState, Endpoint};
use tertius::bus::{Identifiers, Port};
use tertius::frame::Frame;
use tertius::time::Span;
use tertius_testing::broker::Broker;
use tertius_testing::machine::{Cycle, estimating, gateway_of};
use tertius_testing::oracle;
use tertius_testing::support::Scratch;

const STATUS: u64 = 0x1D1;
const WARNING: u64 = 0x2D1;
const ESTIMATE: u64 = 0x3D1;

/// How long the gateway takes for its turn.
pub const DELAY: Span = Span::from_nanos(30_000);

pub const CYLINDERS: usize = 6;

pub fn cycles(range: std::ops::Range<i64>) -> Vec<Frame> {
    offset(range, 0)
}

/// With C1 of cylinder 2 so many counts off.
pub fn offset(range: std::ops::Range<i64>, offset: u16) -> Vec<Frame> {
    range.flat_map(|k| Cycle { offset, ..Cycle::new(k) }.frames()).collect()
}

/// With the platform in state 1, *settled*.
fn settled(range: std::ops::Range<i64>) -> Vec<Frame> {
    let frames = cycles(range).into_iter();
    let state = |frame: Frame| match frame.id.value() {
        0x1C1 => Frame::new(frame.timestamp, frame.id, frame.kind, &[1, 0, 0, frame.data()[3]]),
        _ => frame,
    };
    frames.map(state).collect()
}

/// Without C2 of cylinder 3.
fn without_one(range: std::ops::Range<i64>) -> Vec<Frame> {
    cycles(range).into_iter().filter(|frame| frame.id.value() != 0x193).collect()
}

/// What a master has to find beside what the frames say.
#[derive(Default)]
pub struct Expected {
    condition: u64,
    mode: u64,
    /// Suspect of the open incident of a cylinder.
    incident: Option<(u8, u64)>,
    /// Whether the machine was heard within the last second.
    pub is_heard: bool,
}

/// A moment: its name, what happens until then, and what is expected.
pub type Case = (&'static str, fn(&mut Bench), Expected);

pub fn cases() -> Vec<Case> {
    let heard = |condition, mode, incident| Expected { condition, mode, incident, is_heard: true };
    let silent = |mode| Expected { condition: 2, mode, incident: Some((3, 2)), is_heard: false };
    vec![
        (
            "nothing was heard yet",
            |bench| bench.turn().expect("the bus is up"),
            Expected { condition: 1, mode: 65_535, incident: None, is_heard: false },
        ),
        ("not judged yet", |bench| bench.run(&cycles(0..20), DELAY), heard(1, 0, None)),
        ("healthy", |bench| bench.run(&cycles(20..120), DELAY), heard(0, 1, None)),
        (
            "C1 is 3.3 mm off",
            |bench| bench.run(&offset(120..150, 30), DELAY),
            heard(2, 1, Some((2, 1))),
        ),
        ("it is back", |bench| bench.run(&cycles(150..900), DELAY), heard(0, 1, None)),
        (
            "the platform is settled",
            |bench| bench.run(&settled(900..950), DELAY),
            heard(1, 2, None),
        ),
        (
            "a transducer is silent",
            |bench| bench.run(&without_one(950..1050), DELAY),
            heard(2, 3, Some((3, 2))),
        ),
        (
            "the machine is silent",
            |bench| {
                for _ in 0..70 {
                    bench.hands.pass(Span::from_seconds(0.02));
                    bench.turn().expect("the bus is up");
                }
            },
            silent(3),
        ),
        (
            "the bus is gone",
            |bench| {
                bench.bus.set_state(BusState::Gone);
                bench.turn().expect_err("the bus is gone");
            },
            Expected { condition: 3, ..silent(65_535) },
        ),
    ]
}

/// A frame of the gateway's, as cantools reads it.
pub struct Sent {
    pub micros: i64,
    id: u64,
    signals: Value,
}

impl Sent {
    /// Whether it warns of the cylinder `cylinder`.
    #[cfg(feature = "opcua")]
    pub fn is_warning_of(&self, cylinder: u64) -> bool {
        self.id == WARNING && self.raw("Cylinder") == cylinder
    }

    /// Its alarm level.
    #[cfg(feature = "opcua")]
    pub fn level(&self) -> u64 {
        self.raw("Level")
    }

    fn raw(&self, name: &str) -> u64 {
        self.signals[name].as_u64().unwrap_or_else(|| panic!("{name} in {}", self.signals))
    }
}

/// What the gateway has sent, as cantools reads it.
pub fn sent(listener: &mut Endpoint) -> Vec<Sent> {
    let mut log = String::new();
    while {
        let mut some = false;
        let received = listener.receive(Duration::ZERO, &mut |frame| {
            some = true;
            if [STATUS, WARNING, ESTIMATE].contains(&u64::from(frame.id.value())) {
                let nanos = frame.timestamp.as_nanos();
                let (seconds, micros) = (nanos / 1_000_000_000, nanos / 1000 % 1_000_000);
                _ = write!(log, "({seconds}.{micros:06}) can0 {:03X}#", frame.id.value());
                frame.data().iter().for_each(|byte| _ = write!(log, "{byte:02X}"));
                log.push('\n');
            }
        });
        received.is_ok() && some
    } {}
    let scratch = Scratch::new();
    let path = scratch.path("sent.log");
    fs::write(&path, log).expect("the folder is ours");
    let frames = oracle::run("gateway.py", &["dbc/e-type.dbc", &path], "");
    let frames: Vec<(i64, u64, String, bool, Value)> = serde_json::from_str(&frames).expect("JSON");
    let sent = |(micros, id, _, _, signals)| Sent { micros, id, signals };
    frames.into_iter().map(sent).collect()
}

/// What a master reads.
pub struct Values(pub Value);

impl Values {
    pub fn read(server: &ModbusServer) -> Self {
        let port = server.address().port().to_string();
        let arguments = [port.as_str(), "docs/modbus.csv", &CYLINDERS.to_string()];
        let answer = oracle::run("modbus.py", &arguments, "");
        let answer: Value = serde_json::from_str(&answer).expect("JSON");
        // No such address, and no such function.
        assert_eq!(answer["beyond"], serde_json::json!([2, 2, 2, 2]));
        assert_eq!(answer["attempts"], serde_json::json!([1, 1, 1, 1, 1, 1, 1, 1]));
        Self(answer["values"].clone())
    }

    #[track_caller]
    pub fn whole(&self, name: &str) -> u64 {
        self.0[name].as_u64().unwrap_or_else(|| panic!("{name}: {}", self.0[name]))
    }

    #[track_caller]
    fn real(&self, name: &str) -> Option<f64> {
        assert!(self.0.get(name).is_some(), "{name}");
        self.0[name].as_f64()
    }
}

/// How often a warning was raised, by cylinder and detector, in frames that also repeat what stands.
fn raised<'a>(frames: impl Iterator<Item = &'a Sent>) -> BTreeMap<(u64, u64), u64> {
    let mut standing = BTreeMap::new();
    let mut raised = BTreeMap::new();
    for frame in frames.filter(|frame| frame.id == WARNING) {
        let of = (frame.raw("Cylinder"), frame.raw("Detector"));
        let stands = frame.raw("Raised") == 1;
        // Of the plausibility checks, one can stand of each reading.
        let place = if of.1 == 4 { frame.raw("Suspect") } else { 0 };
        let before = standing.insert((of, place), stands).unwrap_or_default();
        *raised.entry(of).or_default() += u64::from(stands && !before);
    }
    raised
}

#[track_caller]
pub fn same(name: &str, values: &Values, expected: &Expected, frames: &[Sent], now: i64) {
    assert_eq!(values.whole("condition"), expected.condition, "{name}");
    assert_eq!(values.whole("mode"), expected.mode, "{name}");
    let newest = |id: u64, is: &dyn Fn(&Sent) -> bool| {
        frames.iter().rfind(|it| it.id == id && it.micros <= now && is(it))
    };
    let status = newest(STATUS, &|_| true);
    let standing = status.map_or([0, 0], |it| [it.raw("Level"), it.raw("ActiveWarnings")]);
    assert_eq!([values.whole("level"), values.whole("warnings_standing")], standing, "{name}");
    // On a bus that is gone, the newest one says nothing of now.
    let is_down = expected.condition == 3;
    let fresh = status.filter(|it| !is_down && now - it.micros < 1_000_000);
    if let Some(status) = fresh {
        assert_eq!(values.whole("mode"), status.raw("Mode"), "{name}");
    }
    let warned = raised(frames.iter().filter(|it| it.micros <= now));
    for cylinder in 1..=CYLINDERS {
        let of = |what: &str| format!("cylinder_{cylinder}_{what}");
        for which in ["c1", "c2"] {
            let said = fresh.filter(|_| expected.is_heard);
            let signal = format!("Cyl{cylinder}_{}_State", which.to_uppercase());
            let said = said.map_or(0, |it| it.raw(&signal));
            assert_eq!(values.whole(&of(which)), said, "{name}: {}", of(which));
            // Of the lamps, good and failure mean the same as healthy and faulty.
            let lamp = [Some(0), Some(1), None, Some(5)][said as usize];
            let shown = values.whole(&of(&format!("{which}_lamp")));
            assert!(lamp.is_none_or(|lamp| lamp == shown), "{name}: {}: {shown}", of(which));
        }
        let own = |it: &Sent| it.raw("Cylinder") == cylinder as u64;
        let estimate = newest(ESTIMATE, &own).filter(|it| now - it.micros < 40_000);
        match estimate.filter(|it| it.raw("Valid") == 1) {
            Some(estimate) => {
                let metres = estimate.raw("Position") as f64 * 3.0 / 27_648.0 - 1.5;
                let read = values.real(&of("estimate")).expect("it is valid");
                assert!((read - metres).abs() < 1.5 / 27_648.0 + 1e-7, "{name}: {read} {metres}");
                let (sigma, read) =
                    (estimate.raw("Sigma") as f64 * 1e-6, values.real(&of("sigma")));
                let beyond = sigma - read.expect("it is valid");
                assert!((-1e-9..1e-6 + 1e-9).contains(&beyond), "{name}: {read:?} {sigma}");
            }
            None => assert_eq!(values.real(&of("estimate")), None, "{name}"),
        }
        for (number, detector) in [(1, "fde1"), (2, "fde2"), (3, "fde3"), (4, "plausibility")] {
            let count = warned.get(&(cylinder as u64, number)).copied().unwrap_or_default();
            assert_eq!(
                values.whole(&of(&format!("raised_{detector}"))),
                count,
                "{name}: {cylinder}"
            );
        }
        let suspect = expected.incident.filter(|(of, _)| usize::from(*of) == cylinder);
        let suspect = suspect.map_or(65_535, |(_, suspect)| suspect);
        assert_eq!(values.whole(&of("incident_suspect")), suspect, "{name}: cylinder {cylinder}");
        assert_eq!(values.whole(&of("incident")) == 0, suspect == 65_535, "{name}: {cylinder}");
    }
}

#[test]
fn a_master_reads_what_the_frames_say() {
    let mut bench = Bench::new();
    bench.gateway = gateway_of(estimating(), 0.9);
    let mut listener = bench.bus.open(&Identifiers::All, 1 << 18).expect("the bus is up");
    let listen = "127.0.0.1:0".parse().expect("an address");
    let server = ModbusServer::start(listen, &bench.witness.recorder).expect("a free port");
    let folder = tempfile::tempdir().expect("there is room");
    let broker = Broker::start(folder.path(), "");
    let mut subscriber = broker.subscribe("ship/gangway/state", &[]);
    let plan = MqttPlan { period: Duration::from_millis(500), ..mqtt::plan(&broker, None) };
    let _publisher = MqttPublisher::start(plan, &bench.witness.recorder).expect("a thread");
    bench.witness.recorder.opened();
    let mut moments = Vec::new();
    for (name, happens, expected) in cases() {
        happens(&mut bench);
        // A time at which nothing happens any more, by which the state of this moment is known.
        bench.hands.pass(Span::from_nanos(1000));
        let values = Values::read(&server);
        let now = bench.hands.bus.now().as_seconds();
        let state = subscriber.find(|it| it.payload["at_s"] == now).payload;
        mqtt::says_the_same(name, &state, &values.0);
        moments.push((name, values, expected, bench.hands.bus.now().as_nanos() / 1000));
    }
    let frames = sent(&mut listener);
    assert!(frames.iter().filter(|it| it.id == ESTIMATE).count() > 1000);
    assert!(frames.iter().filter(|it| it.id == WARNING).count() > 4);
    for (name, values, expected, now) in &moments {
        same(name, values, expected, &frames, *now);
    }
}

/// A client that has `from` to say, and what it is answered until the connection ends.
fn said(server: &ModbusServer, from: &[u8]) -> Vec<u8> {
    let mut stream = TcpStream::connect(server.address()).expect("it listens");
    stream.set_read_timeout(Some(Duration::from_secs(60))).expect("a time limit");
    stream.write_all(from).expect("it reads");
    stream.shutdown(std::net::Shutdown::Write).expect("it is open");
    let mut answer = Vec::new();
    _ = stream.read_to_end(&mut answer);
    answer
}

/// A request for the register `map_version`.
const REQUEST: [u8; 12] = [0, 7, 0, 0, 0, 6, 1, 4, 0, 0, 0, 1];

#[test]
fn what_is_no_request_ends_its_own_connection_only() {
    let mut bench = Bench::new();
    let listen = "127.0.0.1:0".parse().expect("an address");
    let server = ModbusServer::start(listen, &bench.witness.recorder).expect("a free port");
    bench.witness.recorder.opened();
    let good = [0, 7, 0, 0, 0, 5, 1, 4, 2, 0, 1];
    for bad in [
        &[0xFF; 300][..],
        b"GET / HTTP/1.1\r\nHost: here\r\n\r\n",
        // Another protocol, a length of zero, a length that is never reached, a function without its fields.
        &[0, 7, 0, 9, 0, 6, 1, 4, 0, 0, 0, 1],
        &[0, 7, 0, 0, 0, 0, 1, 4, 0, 0, 0, 1],
        &[0, 7, 0, 0, 0xFF, 0xFF, 1, 4, 0, 0, 0, 1],
        &[0, 7, 0, 0, 0, 2, 1, 4],
        // More registers than a request may ask for, and none.
        &[0, 7, 0, 0, 0, 6, 1, 4, 0, 0, 0, 126],
        &[0, 7, 0, 0, 0, 6, 1, 4, 0, 0, 0, 0],
    ] {
        assert_ne!(said(&server, bad), good, "{bad:?}");
        assert_eq!(said(&server, &REQUEST), good, "after {bad:?}");
    }
    bench.run(&cycles(0..10), DELAY);
    let metrics = bench.metrics();
    assert_eq!(metrics.get("tertius_cycles_total", &[]), 10.0);
    // Of what is a request, the two for too many and for no registers were refused.
    let counts = ["connections", "turned_away", "answers", "refused"];
    let counts = counts.map(|it| metrics.get(&format!("tertius_modbus_{it}_total"), &[]));
    assert_eq!(counts, [16.0, 0.0, 8.0, 2.0]);
}

#[test]
fn clients_that_hang_or_flood_stop_neither_others_nor_the_gateway() {
    let mut bench = Bench::new();
    let listen = "127.0.0.1:0".parse().expect("an address");
    let server = ModbusServer::start(listen, &bench.witness.recorder).expect("a free port");
    bench.witness.recorder.opened();
    let connect = || TcpStream::connect(server.address()).expect("it listens");
    // One sends half a request; others send many and read nothing.
    let mut hung = connect();
    hung.write_all(&REQUEST[..5]).expect("it reads");
    let flooding: Vec<TcpStream> = (0..3).map(|_| connect()).collect();
    for mut stream in &flooding {
        stream.write_all(&REQUEST.repeat(1000)).expect("it fits into the socket");
    }
    for round in 0..5 {
        bench.run(&cycles(round * 10..round * 10 + 10), DELAY);
        assert_eq!(said(&server, &REQUEST).len(), 11);
    }
    assert_eq!(bench.metrics().get("tertius_cycles_total", &[]), 50.0);
    // Beyond the most clients the next ones are closed without a word, and a place that is given back is free again.
    let more: Vec<TcpStream> = (0..20).map(|_| connect()).collect();
    let answered = |mut stream: &TcpStream| {
        stream.set_read_timeout(Some(Duration::from_secs(60))).expect("a time limit");
        let mut answer = [0; 11];
        stream.write_all(&REQUEST).is_ok() && stream.read_exact(&mut answer).is_ok()
    };
    assert_eq!(more.iter().filter(|stream| answered(stream)).count(), 4);
    drop(more);
    let again = (0..10_000).any(|_| said(&server, &REQUEST).len() == 11);
    assert!(again, "places are free again");
}
