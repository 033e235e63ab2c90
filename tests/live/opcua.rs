//! What the ship's own systems read over OPC UA is what the gateway's frames say at the same time.

use crate::metrics_support::Bench;
use crate::modbus::{self, CYLINDERS, DELAY, Values, cases, cycles, offset, same, sent};
use serde_json::{Map, Value, json};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;
use tertius::appliance::outputs::StateServer;
use tertius::appliance::outputs::opcua::{NAMESPACE, OpcuaServer};
use tertius::appliance::telemetry::points::{Point, PointKind, Points};
use tertius::appliance::telemetry::snapshot::Snapshot;
use tertius::bus::Identifiers;
use tertius::time::Span;
use tertius_testing::machine::{estimating, gateway_of};
use tertius_testing::oracle::{self, Peer};

/// Longest wait for what has to come.
const PATIENCE: Duration = Duration::from_secs(60);

fn served(bench: &Bench) -> OpcuaServer {
    let listen = "127.0.0.1:0".parse().expect("an address");
    OpcuaServer::start(listen, &bench.witness.recorder).expect("a free port")
}

fn url(server: &OpcuaServer) -> String {
    format!("opc.tcp://{}/", server.address())
}

/// What a client reads.
fn read(server: &OpcuaServer, what: &str) -> Value {
    let answer = oracle::run("opcua.py", &[what, &url(server)], "");
    serde_json::from_str(&answer).expect("JSON")
}

/// The values in words of Modbus, in which what is not known has a number of its own.
fn as_registers(read: &Value) -> Value {
    let values = read["values"].as_object().expect("variables");
    let register = |(name, it): (&String, &Value)| {
        let is_good = it["status"] == "Good";
        assert_eq!(it["value"].is_null(), !is_good, "{name}: {it}");
        assert!(is_good || it["status"].as_str().is_some_and(|it| it.starts_with("Bad")), "{it}");
        let is_state = ["c1", "c2", "lamp"].iter().any(|end| name.ends_with(end));
        let is_real = ["r1", "r2", "r3", "estimate", "sigma"].iter().any(|end| name.ends_with(end));
        let missing = match (is_real, is_state) {
            (true, _) => Value::Null,
            (_, true) => json!(0),
            _ => json!(65_535),
        };
        (name.clone(), if is_good { it["value"].clone() } else { missing })
    };
    Value::Object(values.iter().map(register).collect::<Map<String, Value>>())
}

#[test]
fn a_client_reads_what_the_frames_say() {
    let mut bench = Bench::new();
    bench.gateway = gateway_of(estimating(), 0.9);
    let mut listener = bench.bus.open(&Identifiers::All, 1 << 18).expect("the bus is up");
    let server = served(&bench);
    bench.witness.recorder.opened();
    let mut moments = Vec::new();
    for (name, happens, expected) in cases() {
        happens(&mut bench);
        let heard = bench.hands.bus.now();
        bench.hands.pass(Span::from_nanos(1000));
        let now = bench.hands.bus.now();
        let read = read(&server, "values");
        let values = Values(as_registers(&read));
        if !expected.is_heard {
            for (point, it) in read["values"].as_object().expect("variables") {
                let is_of_now = ["r1", "r2", "r3", "estimate", "sigma", "_c1", "_c2", "lamp"];
                if is_of_now.iter().any(|end| point.ends_with(end)) {
                    assert_eq!(it["status"], "BadNoCommunication", "{name}: {point}: {it}");
                }
            }
        }
        let stamp = read["values"]["condition"]["source"].as_i64().expect("a time stamp");
        let latest = if expected.is_heard { heard } else { now };
        let age = latest.as_nanos() / 1000 - stamp;
        assert!((0..20_000).contains(&age), "{name}: {age} µs before the newest frame");
        assert!(values.whole("cylinders") == 6 || name == "nothing was heard yet", "{name}");
        moments.push((name, values, expected, now.as_nanos() / 1000));
    }
    let frames = sent(&mut listener);
    for (name, values, expected, now) in &moments {
        same(name, values, expected, &frames, *now);
    }
}

/// The nodes are those of the document, nothing can be written, and the server says where it is.
#[test]
fn the_nodes_are_as_documented_and_cannot_be_changed() {
    let bench = Bench::new();
    let server = served(&bench);
    let read = read(&server, "nodes");
    assert_eq!(read["namespace"], NAMESPACE);
    assert_eq!(read["endpoints"], json!([[url(&server), "None"]]));
    let points = Points::new(&Snapshot::unknown(CYLINDERS));
    let listed = read["values"].as_object().expect("variables");
    assert_eq!(listed.len(), points.all().count());
    for Point { name, unit, kind, meaning, .. } in points.all() {
        let found = &listed[name];
        assert_eq!(found["meaning"], *meaning, "{name}");
        assert_eq!(found["unit"], unit.symbol(), "{name}");
        assert_eq!(found["writable"], false, "{name}");
        let choices = match kind {
            PointKind::Choice(names) => json!(names),
            _ => Value::Null,
        };
        assert_eq!(found["choices"], choices, "{name}");
        let kind = match (found["unit"].as_str(), kind) {
            (_, PointKind::Choice(_)) => "MultiStateDiscreteType",
            (Some(""), _) => "BaseDataVariableType",
            _ => "AnalogUnitType",
        };
        assert_eq!(found["type"], kind, "{name}");
        let owner = name.get(..10).filter(|it| it.starts_with("cylinder_")).unwrap_or_default();
        assert_eq!(found["owner"], owner, "{name}");
    }
    for (place, attempt) in read["attempts"].as_array().expect("a list").iter().enumerate() {
        let refusal = attempt.as_str().expect("a word");
        assert!(refusal.starts_with("Bad") || refusal.contains("Bad"), "{place}: {refusal}");
    }
}

/// A client that follows what happens.
struct Follower {
    peer: Peer,
    /// Lines that came before what was looked for.
    earlier: RefCell<VecDeque<Value>>,
}

impl Follower {
    fn new(server: &OpcuaServer) -> Self {
        let peer = Peer::start("opcua.py", &["follow", &url(server)]);
        let follower = Self { peer, earlier: RefCell::default() };
        follower.find("ready");
        follower
    }

    /// The next of a kind; between kinds there is no order.
    #[track_caller]
    fn find(&self, kind: &str) -> Value {
        let mut earlier = self.earlier.borrow_mut();
        if let Some(place) = earlier.iter().position(|line| line.get(kind).is_some()) {
            return earlier.remove(place).expect("it is there")[kind].clone();
        }
        loop {
            let line = self.peer.next_line();
            match line.get(kind) {
                Some(found) => return found.clone(),
                None => earlier.push_back(line),
            }
        }
    }

    /// Waits until the condition of the machine has this number.
    #[track_caller]
    fn wait(&self, condition: u64) {
        while self.find("change").as_u64() != Some(condition) {}
    }

    /// Asks for what stands.
    fn refresh(&mut self) -> Value {
        self.peer.tell("refresh");
        self.find("refresh")
    }
}

#[test]
fn an_alarm_begins_is_refreshed_and_ends() {
    let mut bench = Bench::new();
    let mut listener = bench.bus.open(&Identifiers::All, 1 << 18).expect("the bus is up");
    let server = served(&bench);
    bench.witness.recorder.opened();
    bench.run(&cycles(0..120), DELAY);
    let follower = Follower::new(&server);
    follower.wait(0);
    bench.run(&offset(120..150, 30), DELAY);
    let begun = follower.find("event");
    let frames = sent(&mut listener);
    let warned = frames.iter().find(|it| it.is_warning_of(2)).expect("a frame");
    // The frame is on the bus at the end of the gateway's turn.
    let turned = begun["Time"].as_i64().expect("a time") + DELAY.as_nanos() / 1000;
    assert_eq!(turned, warned.micros, "{begun}");
    let condition = begun["NodeId"].as_str().expect("a condition").to_owned();
    for (field, value) in [
        ("SourceName", json!("cylinder_2")),
        ("ActiveState/Id", json!(true)),
        ("ActiveState", json!("Active")),
        ("Retain", json!(true)),
        ("Quality", json!("Good")),
        ("AckedState/Id", json!(true)),
        ("EnabledState/Id", json!(true)),
        ("SuppressedOrShelved", json!(false)),
        ("EventType", json!("i=2915")),
    ] {
        assert_eq!(begun[field], value, "{field} in {begun}");
    }
    let message = begun["Message"].as_str().expect("words");
    assert!(message.starts_with("cylinder 2, C1, "), "{message}");
    let severity = begun["Severity"].as_u64().expect("a number");
    assert_eq!(severity, 100 + 200 * warned.level(), "as the level of {message}");
    follower.wait(2);

    // Who comes later asks for what stands, and gets the same change.
    let mut later = Follower::new(&server);
    assert_eq!(later.refresh(), "None");
    let around = [later.find("event"), later.find("event"), later.find("event")];
    let types = around.each_ref().map(|it| it["EventType"].as_str().expect("a type"));
    assert_eq!(types, ["i=2787", "i=2915", "i=2788"]);
    let newest = follower_newest(&follower, &begun);
    assert_eq!(around[1]["EventId"], newest["EventId"]);
    assert_eq!(around[1]["NodeId"], *condition);
    // A second one at once is refused, as it would be told to all.
    assert_eq!(later.refresh(), "BadRefreshInProgress");

    bench.run(&cycles(150..900), DELAY);
    loop {
        let event = follower.find("event");
        if event["EventType"] == "i=2915" && event["ActiveState/Id"] == false {
            assert_eq!(event["NodeId"], *condition);
            assert_eq!(event["Retain"], false);
            assert_ne!(event["EventId"], begun["EventId"]);
            break;
        }
    }
    follower.wait(0);
}

/// The newest event of an alarm before those of a refresh.
fn follower_newest(follower: &Follower, begun: &Value) -> Value {
    let mut newest = begun.clone();
    loop {
        let event = follower.find("event");
        if event["EventType"] != "i=2915" {
            return newest;
        }
        newest = event;
    }
}

/// What a peer that says `from` is answered until the connection ends.
fn said(server: &OpcuaServer, from: &[u8]) -> Vec<u8> {
    let mut stream = TcpStream::connect(server.address()).expect("it listens");
    stream.set_read_timeout(Some(PATIENCE)).expect("a time limit");
    _ = stream.write_all(from);
    _ = stream.shutdown(std::net::Shutdown::Write);
    let mut answer = Vec::new();
    _ = stream.read_to_end(&mut answer);
    answer
}

/// The first message of a client.
fn hello(server: &OpcuaServer) -> Vec<u8> {
    let url = url(server);
    let mut bytes = b"HELF".to_vec();
    bytes.extend((32 + url.len() as u32).to_le_bytes());
    for number in [0, 65_535, 65_535, 0, 0, url.len() as u32] {
        bytes.extend(u32::to_le_bytes(number));
    }
    bytes.extend(url.as_bytes());
    bytes
}

/// The acknowledgement of a hello, on a connection that stays open.
fn greeted(server: &OpcuaServer) -> Option<TcpStream> {
    let mut stream = TcpStream::connect(server.address()).expect("it listens");
    stream.set_read_timeout(Some(PATIENCE)).expect("a time limit");
    let mut answer = [0; 4];
    let is_answered =
        stream.write_all(&hello(server)).is_ok() && stream.read_exact(&mut answer).is_ok();
    (is_answered && answer == *b"ACKF").then_some(stream)
}

#[test]
fn peers_that_talk_nonsense_flood_or_hang_stop_neither_others_nor_the_gateway() {
    let mut bench = Bench::new();
    let server = served(&bench);
    bench.witness.recorder.opened();
    for bad in [
        &b"GET / HTTP/1.1\r\nHost: here\r\n\r\n"[..],
        &[0xFF; 300],
        b"HELF\x04\0\0\0",
        b"HELF\0\0\0\x01",
        b"MSGF\x18\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0",
        b"OPNF\x10\0\0\0\0\0\0\0\xFF\xFF\xFF\x7F",
    ] {
        assert!(!said(&server, bad).starts_with(b"ACK"), "{bad:?}");
        assert!(greeted(&server).is_some(), "after {bad:?}");
    }
    // One sends half a message; others send many after their hello and read nothing.
    let mut hung = TcpStream::connect(server.address()).expect("it listens");
    hung.write_all(&hello(&server)[..9]).expect("it reads");
    let flood = b"MSGF\x18\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0".repeat(1000);
    let flooding: Vec<TcpStream> = (0..3).filter_map(|_| greeted(&server)).collect();
    for mut stream in &flooding {
        _ = stream.write_all(&flood);
    }
    for round in 0..5 {
        bench.run(&modbus::cycles(round * 10..round * 10 + 10), DELAY);
        assert!(greeted(&server).is_some());
    }
    assert_eq!(bench.metrics().get("tertius_cycles_total", &[]), 50.0);
    drop((hung, flooding));
    // Beyond the most clients the next ones are closed without a word, and a place that is given back is free again.
    let places = || {
        let greeted: Vec<Option<TcpStream>> = (0..12).map(|_| greeted(&server)).collect();
        greeted.into_iter().flatten().count()
    };
    assert!((0..10_000).any(|_| places() == 8), "eight places, which are free again");
    assert!((0..10_000).any(|_| greeted(&server).is_some()));
}
