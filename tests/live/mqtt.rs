//! What a subscriber of the ship's broker gets, and what becomes of it while the broker is away.

use crate::metrics_support::Bench;
use serde_json::Value;
use std::fs;
use std::net::TcpListener;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tempfile::TempDir;
use tertius::appliance::outputs::mqtt::{Authority, MqttPlan, MqttPublisher};
use tertius::appliance::store::{Cause, Clerk, EventKind, StorePlan, StoreReader};
use tertius::appliance::telemetry::Recorder;
use tertius::appliance::telemetry::clock::SystemClock;
use tertius::appliance::telemetry::exposition::exposition;
use tertius::config::MachineNames;
use tertius::frame::Frame;
use tertius::incident::Incident;
use tertius::monitor::Monitor;
use tertius::time::Span;
use tertius_testing::broker::{Broker, Message, Subscriber};
use tertius_testing::certificates;
use tertius_testing::machine::{Collected, Cycle, monitor};
use tertius_testing::process::{Running, configuration, wait_for};
use tertius_testing::program;

/// How long the gateway takes for its turn.
const DELAY: Span = Span::from_nanos(30_000);

/// Time between attempts to connect.
const PAUSES: [Duration; 2] = [Duration::from_millis(20); 2];

/// What is published to `broker`, as in docs/MQTT.md.
pub fn plan(broker: &Broker, store: Option<&Path>) -> MqttPlan {
    MqttPlan {
        host: "localhost".to_owned(),
        port: broker.port,
        topic: "ship/gangway".to_owned(),
        login: None,
        authority: None,
        period: Duration::from_secs(2),
        store: store.map(Path::to_owned),
        sparkplug: None,
    }
}

/// Compares the state in a message with what a master reads over Modbus.
#[track_caller]
pub fn says_the_same(name: &str, state: &Value, read: &Value) {
    let number = |names: &[&str], word: &Value| match word.as_str() {
        Some(word) => names.iter().position(|it| *it == word).expect("a known name") as u64,
        None => 65_535,
    };
    let whole = |register: &str| read[register].as_u64().expect("a number");
    let status = ["ok", "unknown", "degraded", "down"];
    let modes = ["starting", "monitoring", "gated", "degraded", "stopping"];
    assert_eq!(state["online"], true, "{name}");
    for (register, said) in [
        ("condition", number(&status, &state["status"])),
        ("mode", number(&modes, &state["mode"])),
        ("level", state["level_number"].as_u64().expect("a number")),
        ("warnings_standing", state["warnings_standing"].as_u64().expect("a number")),
        ("incidents_open", state["incidents"].as_array().expect("a list").len() as u64),
        ("platform_state", state["platform_state"].as_u64().unwrap_or(65_535)),
        ("cycles", state["cycles"].as_u64().expect("a number")),
    ] {
        assert_eq!(said, whole(register), "{name}: {register}");
    }
    let cylinders = state["cylinders"].as_array().expect("a list");
    assert_eq!(cylinders.len() as u64, whole("cylinders"), "{name}");
    for (number_of, cylinder) in (1..).zip(cylinders) {
        let register = |what: &str| format!("cylinder_{number_of}_{what}");
        for which in ["c1", "c2"] {
            let states = ["unknown", "healthy", "suspect", "faulty"];
            let said = number(&states, &cylinder[which]["state"]);
            assert_eq!(said, whole(&register(which)), "{name}: {}", register(which));
            let lamps = [
                "unknown",
                "good",
                "maintenance_required",
                "out_of_specification",
                "check_function",
                "failure",
            ];
            let said = number(&lamps, &cylinder[which]["lamp"]);
            let lamp = register(&format!("{which}_lamp"));
            assert_eq!(said, whole(&lamp), "{name}: {lamp}");
        }
        for what in ["r1", "r2", "r3", "estimate", "sigma"] {
            let said = cylinder[format!("{what}_m")].as_f64();
            let found = read[register(what)].as_f64();
            // Over Modbus they have the seven digits of an f32.
            let apart = said.zip(found).map(|(said, found)| (said - found).abs());
            let same = apart.map_or(said.is_none() && found.is_none(), |apart| apart < 1e-7);
            assert!(same, "{name}: {}: {said:?} {found:?}", register(what));
        }
    }
}

pub fn publisher(plan: MqttPlan, recorder: &Recorder) -> MqttPublisher {
    MqttPublisher::with_pauses(plan, recorder, PAUSES).expect("there are threads")
}

/// Frames of cycles with C1 of cylinder 2 so many counts off.
fn cycles(range: std::ops::Range<i64>, offset: u16) -> Vec<Frame> {
    range.flat_map(|k| Cycle { offset, ..Cycle::new(k) }.frames()).collect()
}

/// A store that is written, and what is written into it.
pub struct Kept {
    folder: TempDir,
    pub recorder: Recorder,
    pub clerk: Clerk,
    /// Incidents of a machine whose C1 stepped and came back.
    pub incidents: Vec<Incident>,
}

impl Kept {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().expect("there is room");
        let recorder = Recorder::new(Arc::new(SystemClock::new()));
        let clerk = Clerk::new(recorder.telemetry());
        let mut seen = Collected::default();
        let mut monitor: Monitor = monitor();
        let frames = [cycles(0..100, 0), cycles(100..150, 30), cycles(150..800, 0)].concat();
        frames.iter().for_each(|frame| monitor.take(frame, &mut seen));
        let mut kept = Self { folder, recorder, clerk, incidents: seen.incidents };
        kept.begin();
        kept
    }

    pub fn path(&self) -> std::path::PathBuf {
        self.folder.path().join("kept.events")
    }

    fn begin(&mut self) {
        let plan = StorePlan {
            path: self.path(),
            size: 8_000_000,
            days: 100,
            machine: "a machine".to_owned(),
            names: MachineNames::default(),
            configuration: "01234567".to_owned(),
            sample_time: 0.02,
        };
        self.clerk.begin(Some(plan), Cause::Start, false);
    }

    /// What happens in a minute: an incident that opens and closes, and the bus that is lost and comes again.
    pub fn minute(&mut self, minute: u32) {
        for incident in self.incidents.clone() {
            let incident = Incident { number: 100 * minute + incident.number, ..incident };
            self.clerk.incident(&incident);
        }
        self.clerk.event(EventKind::BusLost, || format!("minute {minute}: no answer"));
        self.clerk.event(EventKind::BusOpened, || format!("minute {minute}: open"));
        self.clerk.turned();
    }

    /// Everything of the store, as it stands on the disk: by its own numbers.
    pub fn news(&self) -> Vec<Value> {
        let reader = StoreReader::open(&self.path()).expect("it was written");
        let news = reader.news(|_| 0, 100_000).expect("it can be read");
        news.iter().map(|entry| serde_json::to_value(entry).expect("JSON")).collect()
    }

    /// The same, once so many are there.
    pub fn at_least(&self, count: usize) -> Vec<Value> {
        loop {
            let is_there = StoreReader::open(&self.path()).is_ok();
            let news = if is_there { self.news() } else { Vec::new() };
            if news.len() >= count {
                return news;
            }
            std::thread::yield_now();
        }
    }
}

fn number(message: &Value) -> i64 {
    message["number"].as_i64().expect("a number")
}

/// What a subscriber that drops doubles gets until the news `last`, and how many doubles it dropped.
fn received(subscriber: &mut Subscriber, from: i64, last: i64) -> (Vec<Value>, usize) {
    let (mut news, mut doubles, mut newest) = (Vec::new(), 0, from);
    while newest < last {
        let Message { payload, .. } = subscriber.find(|it| it.topic == "ship/gangway/events");
        if number(&payload) > newest {
            newest = number(&payload);
            news.push(payload);
        } else {
            doubles += 1;
        }
    }
    (news, doubles)
}

/// The metric `tertius_mqtt_NAME`; `None` if it is absent.
fn metric(recorder: &Recorder, name: &str) -> Option<f64> {
    let text = exposition(recorder.telemetry(), &**recorder.clock()).expect("a text");
    let value = |line: &str| line.strip_prefix(&format!("tertius_mqtt_{name} "))?.parse().ok();
    text.lines().find_map(value)
}

#[test]
fn an_hour_without_the_broker_loses_nothing_and_changes_no_order() {
    let folder = tempfile::tempdir().expect("there is room");
    let mut broker = Broker::start(folder.path(), "");
    let mut kept = Kept::new();
    let plan = plan(&broker, Some(&kept.path()));
    let mut subscriber = broker.subscribe("ship/gangway/#", &[]);
    assert_eq!(["up", "events_waiting"].map(|it| metric(&kept.recorder, it)), [None; 2]);
    let first = publisher(plan.clone(), &kept.recorder);
    subscriber.find(|it| it.topic == "ship/gangway/state");
    (0..10).for_each(|minute| kept.minute(minute));
    let each = kept.incidents.len() + 2;
    let so_far = kept.at_least(1 + each * 10);
    assert!(so_far.len() > 40, "more than may come twice");
    let (news, doubles) = received(&mut subscriber, 0, so_far.len() as i64);
    assert_eq!((&news, doubles), (&so_far, 0));

    // An hour of events while the broker is away, in the middle of which the gateway is started anew.
    broker.stop();
    (10..40).for_each(|minute| kept.minute(minute));
    kept.at_least(1 + each * 40);
    drop(first);
    let _second = publisher(plan, &kept.recorder);
    (40..70).for_each(|minute| kept.minute(minute));
    let all = kept.at_least(1 + each * 70);
    let metric = |name: &str| metric(&kept.recorder, name).expect("it is there");
    // What the broker has not said that it has may come twice.
    let waiting = all.len() - so_far.len();
    wait_for("the count of what waits", || {
        (waiting..=waiting + 16).contains(&(metric("events_waiting") as usize))
    });
    assert_eq!(metric("up"), 0.0);
    assert!(metric("failures_total") > 1.0 && metric("connections_total") == 1.0);
    broker.restart();
    let last = all.len() as i64;
    let (news, doubles) = received(&mut subscriber, so_far.len() as i64, last);
    assert_eq!(news, all[so_far.len()..]);
    assert!(doubles <= 16, "{doubles} came twice, more than are on their way at once");
    wait_for("the last acknowledgement", || metric("events_waiting") == 0.0);
    let counts = ["up", "connections_total", "refused_total"].map(metric);
    assert_eq!(counts, [1.0, 2.0, 0.0]);
    let sent = metric("events_sent_total") as usize;
    assert!((all.len()..=all.len() + 16).contains(&sent), "{sent} of {}", all.len());
    assert!(metric("acknowledged_total") >= all.len() as f64);
    assert!(all.iter().map(number).eq(1..=last), "one number after the other");

    // What the subscriber gets says what happened: each incident opens before it closes, with its own number.
    let of = |minute: u32| {
        let start = format!("minute {minute}:");
        let begins = |it: &&Value| it["text"].as_str().is_some_and(|it| it.starts_with(&start));
        news.iter().filter(begins).count()
    };
    assert!((10..70).all(|minute| of(minute) == 2));
    let incidents: Vec<&Value> = news.iter().filter(|it| it["kind"] == "incident").collect();
    assert_eq!(incidents.len(), 60 * kept.incidents.len());
    assert_eq!(incidents[0]["progress"], "opened");
    assert_eq!((&incidents[0]["suspect"], &incidents[0]["cylinder"]), (&"c1".into(), &2.into()));
    kept.clerk.finish();
}

#[test]
fn a_will_takes_the_place_of_a_state_that_nobody_renews() {
    let folder = tempfile::tempdir().expect("there is room");
    let broker = Broker::start(folder.path(), "");
    let mut bench = Bench::new();
    bench.witness.recorder.opened();
    bench.run(&cycles(0..120, 0), DELAY);
    let mut subscriber = broker.subscribe("ship/#", &[]);
    let running = publisher(plan(&broker, None), &bench.witness.recorder);
    let state = subscriber.find(|it| it.payload["online"] == true);
    assert_eq!(
        (state.topic.as_str(), &state.payload["status"]),
        ("ship/gangway/state", &"ok".into())
    );
    // Who comes later gets it, too.
    let retained = broker.subscribe("ship/gangway/state", &[]).next();
    assert!(retained.retained);
    assert_eq!(retained.payload["cylinders"].as_array().map(Vec::len), Some(6));
    // A change is told before the period is over, and the will once the gateway is gone.
    bench.run(&cycles(120..140, 30), DELAY);
    let changed = subscriber.find(|it| it.payload["status"] != "ok");
    assert_eq!(changed.payload["cylinders"][1]["c1"]["state"], "faulty");
    drop(running);
    let gone = subscriber.find(|it| it.payload["online"] == false);
    assert_eq!(
        (gone.topic.as_str(), &gone.payload["status"]),
        ("ship/gangway/state", &"unknown".into())
    );
    let retained = broker.subscribe("ship/+/state", &[]).next();
    assert!(retained.retained);
    assert_eq!(retained.payload, gone.payload);
}

#[test]
fn a_broker_that_asks_for_a_password_gets_it_encrypted() {
    let folder = tempfile::tempdir().expect("there is room");
    let place = |name: &str| folder.path().join(name);
    let (authority, files) = certificates::certify_by_authority(folder.path());
    // What mosquitto_sub asks of a certificate is its own affair: it comes by another way.
    let free = TcpListener::bind("127.0.0.1:0").and_then(|free| free.local_addr());
    let plain = free.expect("a free port").port().to_string();
    let more = format!(
        "allow_anonymous false\npassword_file {}\ncertfile {}\nkeyfile {}\nlistener {plain} 127.0.0.1\n",
        place("users").display(),
        files.certificate.display(),
        files.key.display()
    );
    Broker::user(&place("users"), "gateway", "right one");
    let broker = Broker::start(folder.path(), &more);
    let bench = Bench::new();
    fs::write(place("password"), "wrong one\n").expect("the folder is ours");
    certificates::allow(&place("password"), 0o600);
    let plan = MqttPlan {
        login: Some(("gateway".to_owned(), place("password"))),
        authority: Some(Authority::File(authority.into())),
        ..plan(&broker, None)
    };
    let _running = publisher(plan, &bench.witness.recorder);
    while !broker.log().contains("not authorised") {
        std::thread::yield_now();
    }
    fs::write(place("password"), "right one\n").expect("the folder is ours");
    let login = ["-p", &plain, "-u", "gateway", "-P", "right one"];
    let mut subscriber = broker.subscribe("ship/gangway/state", &login);
    assert_eq!(subscriber.next().payload["online"], true);
}

/// Read anew for each connection, too: a computer that comes to trust the broker needs no restart of the gateway.
#[test]
fn a_broker_that_the_computer_trusts_needs_no_file() {
    let folder = tempfile::tempdir().expect("there is room");
    let other = tempfile::tempdir().expect("there is room");
    let place = |name: &str| folder.path().join(name).display().to_string();
    let (authority, files) = certificates::certify_by_authority(folder.path());
    let (stranger, _) = certificates::certify_by_authority(other.path());
    let free = TcpListener::bind("127.0.0.1:0").and_then(|free| free.local_addr());
    let plain = free.expect("a free port").port().to_string();
    let more = format!(
        "certfile {}\nkeyfile {}\nlistener {plain} 127.0.0.1\n",
        files.certificate.display(),
        files.key.display()
    );
    let broker = Broker::start(folder.path(), &more);
    let config = configuration(folder.path(), "no-such-can");
    let text = fs::read_to_string(&config).expect("it was written");
    let mqtt = format!(
        "{text}\n[http]\nlisten = \"off\"\n[mqtt]\nbroker = \"localhost:{}\"\nauthority = \"system\"\n",
        broker.port
    );
    fs::write(&config, mqtt).expect("the folder is ours");
    let trusted = place("trusted.pem");
    fs::copy(&stranger, &trusted).expect("the folder is ours");
    let (variable, said) = (format!("SSL_CERT_FILE={trusted}"), folder.path().join("said"));
    let config = config.display().to_string();
    let call = [&variable, program(), "run", "--config", &config];
    let _running = Running::start("env", &call, &said);
    wait_for("the gateway's refusal", || {
        fs::read_to_string(&said).unwrap_or_default().contains("no encrypted connection")
    });
    fs::copy(&authority, &trusted).expect("the folder is ours");
    let mut subscriber = broker.subscribe("tertius/state", &["-p", &plain]);
    assert_eq!(subscriber.find(|it| it.payload["online"] == true).payload["status"], "down");
}

/// A broker that takes connections and never says a word, and none at all.
#[test]
fn a_broker_that_hangs_is_nothing_to_the_data_path() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let mut bench = Bench::new();
    let plan = MqttPlan {
        host: "127.0.0.1".to_owned(),
        port: listener.local_addr().expect("it has one").port(),
        topic: "ship/gangway".to_owned(),
        login: None,
        authority: None,
        period: Duration::from_secs(1),
        store: None,
        sparkplug: None,
    };
    let running = publisher(plan, &bench.witness.recorder);
    let (hung, _) = listener.accept().expect("it connects");
    bench.witness.recorder.opened();
    bench.run(&cycles(0..50, 0), DELAY);
    assert_eq!(bench.metrics().get("tertius_cycles_total", &[]), 50.0);
    drop((running, hung));
}
