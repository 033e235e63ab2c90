//! A gateway on the embedded bus whose telemetry is served, and someone who asks for it.

use serde_json::Value;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use tertius::alarm::{OwnFrame, State, Warning};
use tertius::appliance::http::{Desk, Server};
use tertius::appliance::telemetry::Recorder;
use tertius::appliance::telemetry::clock::Clock as Watch;
use tertius::bus::embedded::{Clock, EmbeddedBus, Endpoint, ManualClock};
use tertius::bus::{Identifiers, Port, PortError, UnrestrictedPort};
use tertius::estimate::Estimate;
use tertius::frame::Frame;
use tertius::incident::Incident;
use tertius::live::gateway::{Gateway, Journal};
use tertius::monitor::Record;
use tertius::time::{Span, Timestamp};
use tertius_testing::machine::{self, gateway_of, monitor};
use tertius_testing::oracle;

/// Both clocks stand until they are moved. The system's is that of the bus.
#[derive(Clone)]
pub struct Hands {
    pub bus: ManualClock,
    uptime: Arc<AtomicU64>,
}

impl Hands {
    pub fn new() -> Self {
        let bus = ManualClock::new(Timestamp::from_nanos(machine::START));
        Self { bus, uptime: Arc::default() }
    }

    /// Time passes for all.
    pub fn pass(&self, span: Span) {
        self.bus.advance(span);
        self.uptime.fetch_add(span.as_nanos().unsigned_abs(), Ordering::SeqCst);
    }
}

impl Watch for Hands {
    fn uptime(&self) -> Duration {
        Duration::from_nanos(self.uptime.load(Ordering::SeqCst))
    }

    fn system(&self) -> Timestamp {
        self.bus.now()
    }
}

/// Writes the telemetry, and keeps what it should say.
pub struct Witness {
    pub recorder: Recorder,
    pub records: Vec<Record>,
    pub raised: Vec<Warning>,
    pub warnings: usize,
    pub warning_frames: usize,
}

impl Journal for Witness {
    fn record(&mut self, record: &Record) {
        self.recorder.record(record);
        self.records.push(*record);
    }

    fn warning(&mut self, warning: &Warning) {
        self.recorder.warning(warning);
        self.warnings += 1;
        self.raised.extend((warning.state == State::Raised).then_some(*warning));
    }

    fn incident(&mut self, incident: &Incident) {
        self.recorder.incident(incident);
    }

    fn estimate(&mut self, cylinder: u8, estimate: Option<&Estimate>) {
        self.recorder.estimate(cylinder, estimate);
    }

    fn sent(&mut self, frame: &OwnFrame, _: Timestamp) {
        self.recorder.sent(frame);
        self.warning_frames += usize::from(frame.as_frame().id.value() == 0x2D1);
    }
}

pub fn gateway() -> Gateway {
    gateway_of(monitor(), 0.05)
}

pub struct Bench {
    pub hands: Hands,
    pub bus: EmbeddedBus,
    pub gateway: Gateway,
    pub port: Endpoint,
    pub witness: Witness,
    pub server: Server,
}

impl Bench {
    /// Everything is there, and nothing has been told of it yet.
    pub fn new() -> Self {
        let hands = Hands::new();
        let bus = EmbeddedBus::new(Clock::Manual(hands.bus.clone()));
        let port = bus.open(&Identifiers::All, 4096).expect("the bus is up");
        let recorder = Recorder::new(Arc::new(hands.clone()));
        let listen = "127.0.0.1:0".parse().expect("an address");
        let server = Server::start(listen, &recorder, Desk::default(), None)
            .expect("loopback has a free port");
        let (records, raised) = (Vec::new(), Vec::new());
        let witness = Witness { recorder, records, raised, warnings: 0, warning_frames: 0 };
        Self { hands, bus, gateway: gateway(), port, witness, server }
    }

    pub fn turn(&mut self) -> Result<(), PortError> {
        let turn = self.gateway.turn(&mut self.port, Duration::ZERO, &mut self.witness);
        match turn {
            Ok(_) => self.witness.recorder.turned(&self.gateway, &self.port),
            Err(_) => self.witness.recorder.closed(&self.gateway, &self.port),
        }
        turn.map(drop)
    }

    /// Puts `frames` on the bus at their times; the gateway has a turn `delay` after each.
    pub fn run(&mut self, frames: &[Frame], delay: Span) {
        let mut machine = self.bus.open_unrestricted(&Identifiers::All, 64).expect("up");
        for frame in frames {
            let ahead = frame.timestamp.since(self.hands.bus.now());
            self.hands.pass(ahead);
            machine.send_unrestricted(frame).expect("the bus is up");
            self.hands.pass(delay);
            self.turn().expect("the bus is up");
            machine.receive(Duration::ZERO, &mut |_| {}).expect("the bus is up");
        }
    }

    pub fn ask(&self, path: &str) -> Answer {
        ask(&self.server, &format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n"))
    }

    /// The answer to Prometheus, which accepts OpenMetrics.
    pub fn scrape(&self) -> Answer {
        let accept = "Accept: application/openmetrics-text;version=1.0.0,text/plain;q=0.5";
        ask(&self.server, &format!("GET /metrics HTTP/1.1\r\nHost: localhost\r\n{accept}\r\n\r\n"))
    }

    pub fn health(&self) -> (u16, Value) {
        let answer = self.ask("/health");
        (answer.code, serde_json::from_str(&answer.body).expect("it is JSON"))
    }

    pub fn metrics(&self) -> Metrics {
        let answer = self.scrape();
        assert_eq!(answer.code, 200);
        let kind = "content-type: application/openmetrics-text; version=1.0.0; charset=utf-8";
        assert!(answer.head.contains(kind), "{}", answer.head);
        Metrics::parse(&answer.body)
    }
}

pub struct Answer {
    pub code: u16,
    pub head: String,
    pub body: String,
}

/// Sends `request` and reads until the server closes.
pub fn ask(server: &Server, request: &str) -> Answer {
    let mut stream = TcpStream::connect(server.address()).expect("it listens");
    stream.set_read_timeout(Some(Duration::from_secs(60))).expect("a time limit");
    stream.write_all(request.as_bytes()).expect("it reads");
    let mut text = String::new();
    stream.read_to_string(&mut text).expect("it answers and closes");
    Answer::new(&text)
}

impl Answer {
    /// The answer in `text`.
    pub fn new(text: &str) -> Self {
        let (head, body) = text.split_once("\r\n\r\n").expect("a head and a body");
        let code =
            head.split(' ').nth(1).and_then(|code| code.parse().ok()).expect("a status code");
        let is_in_chunks = head.lines().any(|line| line == "transfer-encoding: chunked");
        let body = if is_in_chunks { whole(body) } else { body.to_owned() };
        Self { code, head: head.to_owned(), body }
    }
}

/// A body out of its chunks.
fn whole(mut chunks: &str) -> String {
    let mut body = String::new();
    while let Some((length, rest)) = chunks.split_once("\r\n") {
        let length = usize::from_str_radix(length, 16).expect("the length of a chunk");
        if length == 0 {
            return body;
        }
        body += &rest[..length];
        chunks = rest[length..].strip_prefix("\r\n").expect("the end of a chunk");
    }
    panic!("the body was cut off after {} bytes", body.len());
}

/// Samples as Prometheus' own parser reads them.
pub struct Metrics(Vec<Value>);

impl Metrics {
    fn parse(text: &str) -> Self {
        let samples = oracle::run("openmetrics.py", &[], text);
        Self(serde_json::from_str(&samples).expect("the oracle writes JSON"))
    }

    pub fn samples(&self) -> &[Value] {
        &self.0
    }

    /// The sample `name` whose labels are `labels`, written `key=value`.
    pub fn find(&self, name: &str, labels: &[&str]) -> Option<f64> {
        let has = |sample: &&Value| {
            let known = sample["labels"].as_object().expect("labels are an object");
            let fits = |label: &&str| {
                let (key, value) = label.split_once('=').expect("key=value");
                known.get(key).is_some_and(|known| known == value)
            };
            sample["name"] == name && known.len() == labels.len() && labels.iter().all(fits)
        };
        self.0.iter().find(has).map(|sample| sample["value"].as_f64().expect("a number"))
    }

    #[track_caller]
    pub fn get(&self, name: &str, labels: &[&str]) -> f64 {
        self.find(name, labels).unwrap_or_else(|| panic!("{name}{labels:?} is not there"))
    }

    /// How many samples there are of `name`.
    pub fn count(&self, name: &str) -> usize {
        self.0.iter().filter(|sample| sample["name"] == name).count()
    }
}
