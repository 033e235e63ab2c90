//! What the gateway tells of itself over HTTP is what happened, and nobody who asks disturbs it.

use crate::metrics_support::{Bench, ask, gateway};
use std::io::Read;
use std::net::TcpStream;
use std::time::Duration;
use tertius::alarm::{OwnFrame, Warning};
use tertius::appliance::http::{Desk, Server};
use tertius::bus::embedded::{BusState, EmbeddedBus};
use tertius::bus::socket::{ControllerState, LinkState};
use tertius::bus::{Identifiers, Port};
use tertius::frame::{Frame, Id, Kind};
use tertius::live::gateway::{Gateway, Journal};
use tertius::live::supervisor::{self, Opener, Request, Surroundings};
use tertius::time::{Span, Timestamp};
use tertius_testing::machine::{self, Cycle, MS};
use tertius_testing::oracle;

/// How long the gateway takes for its turn.
const DELAY: Span = Span::from_nanos(30_000);

fn cycles(range: std::ops::Range<i64>) -> Vec<Frame> {
    range.flat_map(|k| Cycle::new(k).frames()).collect()
}

/// A transducer that steps and comes back, lost, foreign, repeated and error frames.
fn eventful() -> Vec<Frame> {
    let kept = (0..400).filter(|k| !(150..160).contains(k));
    let frames = kept.flat_map(|k| {
        let offset = if (230..260).contains(&k) { 30 } else { 0 };
        Cycle { offset, ..Cycle::new(k) }.frames()
    });
    let mut frames: Vec<Frame> =
        frames.enumerate().filter(|(i, _)| i % 101 != 0).map(|(_, frame)| frame).collect();
    let strange = |at: Timestamp, id, kind| {
        Frame::new(at, Id::standard(id).expect("eleven bits"), kind, &[0; 8])
    };
    for at in [900, 2100, 5000] {
        let time = frames[at].timestamp;
        let again = frames[at].clone();
        let error = strange(time, 4, Kind::Error);
        frames.splice(at..at, [error, strange(time, 0x7FF, Kind::Data), again]);
    }
    frames
}

#[test]
fn the_figures_are_what_the_monitor_counted() {
    let mut bench = Bench::new();
    bench.witness.recorder.opened();
    bench.run(&eventful(), DELAY);
    let metrics = bench.metrics();
    let counts = *bench.gateway.monitor().counts();
    let port = bench.port.counts();
    let outbox = *bench.gateway.outbox().counts();
    assert!(counts.incomplete > 50 && counts.missing == 10 && counts.ignored == 6);
    for (name, expected) in [
        ("frames_received", port.received),
        ("error_frames", 3),
        ("frames_used", counts.used),
        ("frames_ignored", counts.ignored),
        ("frames_dropped", port.dropped),
        ("frames_malformed", port.malformed),
        ("frames_unstamped", port.unstamped),
        ("frames_refused", port.refused),
        ("frames_sent", port.sent),
        ("frames_too_old", outbox.too_old),
        ("frames_crowded_out", outbox.crowded_out),
        ("frames_held_back", outbox.held_back),
        ("statuses_superseded", outbox.superseded),
        ("estimates_outdated", outbox.outdated),
        ("cycles", counts.cycles),
        ("cycles_incomplete", counts.incomplete),
        ("cycles_missing", counts.missing),
        ("frames_late", counts.late),
        ("frames_repeated", counts.repeated),
        ("frames_contradicting", counts.contradicting),
        ("frames_short", counts.short),
        ("sync_doubted_seconds", counts.sync_doubted),
        ("frames_imitated", 0),
        ("frames_held", counts.held),
        ("signals_bad", counts.bad_signals),
        ("status_unnamed", counts.unnamed_status_bits),
        ("frames_backwards", counts.backwards),
        ("time_jumps", counts.time_jumps),
        ("turns", port.received),
        ("port_opens", 1),
        ("port_losses", 0),
        ("port_reconnects", 0),
    ] {
        assert_eq!(metrics.get(&format!("tertius_{name}_total"), &[]), expected as f64, "{name}");
    }
    assert_eq!(port.received, counts.used + counts.ignored);
    let described = |sample: &serde_json::Value| {
        let help = sample["help"].as_str().unwrap_or_default();
        help.len() > 5 && help.ends_with('.') && sample["type"] != "unknown"
    };
    assert!(metrics.samples().iter().all(described));
    assert_eq!(metrics.get("tertius_build_info", &["version=0.1.0"]), 1.0);
    assert_eq!(metrics.get("tertius_start_time_seconds", &[]), machine::START as f64 / 1e9);
}

#[test]
fn warnings_and_residuals_are_told_by_cylinder() {
    let mut bench = Bench::new();
    bench.witness.recorder.opened();
    // Until just after the step, so that its warnings stand.
    let frames = eventful();
    let end = frames.iter().position(|f| f.timestamp.as_nanos() > machine::START + 4_800 * MS);
    bench.run(&frames[..end.expect("it lasts eight seconds")], DELAY);
    let metrics = bench.metrics();
    let raised = &bench.witness.raised;
    assert!(raised.len() >= 2, "{raised:?}");
    for n in 1..=6_u8 {
        for detector in ["fde1", "fde2", "fde3", "plausibility"] {
            let labels = [&*format!("cylinder={n}"), &format!("detector={detector}")];
            let said = raised.iter().filter(|w| w.cylinder == n && w.detector.name() == detector);
            let told = metrics.get("tertius_warnings_raised_total", &labels);
            assert_eq!(told, said.count() as f64, "{labels:?}");
        }
        let own: Vec<_> = bench.witness.records.iter().filter(|r| r.cylinder == n).collect();
        for (i, name) in ["r1", "r2", "r3"].iter().enumerate() {
            let labels = [&*format!("cylinder={n}"), &format!("residual={name}")];
            let sizes: Vec<f64> =
                own.iter().filter_map(|record| record.residuals[i]).map(f64::abs).collect();
            assert!(sizes.len() > 100, "{labels:?}");
            let newest = own.last().and_then(|record| record.residuals[i]).map(f64::abs);
            assert_eq!(metrics.find("tertius_residual_meters", &labels), newest, "{labels:?}");
            let name = |part: &str| format!("tertius_residual_size_meters_{part}");
            assert_eq!(metrics.get(&name("count"), &labels), sizes.len() as f64);
            let sum: f64 = sizes.iter().sum();
            assert!((metrics.get(&name("sum"), &labels) - sum).abs() <= 1e-12 * sum);
            for (bound, le) in [(1e-4, "0.0001"), (1e-3, "0.001"), (f64::INFINITY, "inf")] {
                let within = sizes.iter().filter(|size| **size <= bound).count();
                let labels = [labels[0], labels[1], &format!("le={le}")];
                assert_eq!(metrics.get(&name("bucket"), &labels), within as f64, "{labels:?}");
            }
        }
    }
    let told = metrics.get("tertius_warnings_standing", &[]);
    let state = |c: &str, state: &str| {
        let labels = ["cylinder=2", &format!("transducer={c}"), &format!("state={state}")];
        metrics.get("tertius_transducer_state", &labels)
    };
    assert!(told >= 2.0 && metrics.get("tertius_alarm_level", &[]) >= 1.0);
    assert_eq!((state("c1", "faulty"), state("c1", "healthy")), (1.0, 0.0));
    assert_eq!(metrics.count("tertius_transducer_state"), 60);
    assert_eq!(metrics.get("tertius_mode", &["mode=monitoring"]), 1.0);
    assert_eq!(metrics.count("tertius_mode"), 5);
    let (code, health) = bench.health();
    assert_eq!((code, &health["status"]), (200, &"degraded".into()), "{health}");
    assert_eq!(health["warnings_standing"], told);
    let incident = &health["incidents"][0];
    assert_eq!(
        (&incident["cylinder"], &incident["suspect"]),
        (&2.into(), &"c1".into()),
        "{health}"
    );
    let reason = health["reason"].as_str().expect("words");
    assert!(reason.starts_with("cylinder 2, C1, "), "{reason}");
    let open = metrics.get("tertius_incidents_open", &["cylinder=2"]);
    assert_eq!(open as usize, health["incidents"].as_array().expect("a list").len());
    assert!(metrics.get("tertius_incidents_opened_total", &["cylinder=2"]) >= open);
}

/// Clients that know only the older format get that, with the same samples.
#[test]
fn the_older_format_has_the_same_samples() {
    let mut bench = Bench::new();
    bench.witness.recorder.opened();
    bench.run(&cycles(0..120), DELAY);
    let (old, new) = (bench.ask("/metrics"), bench.scrape());
    assert!(old.head.contains("content-type: text/plain; version=0.0.4"), "{}", old.head);
    let samples = |text: &str| {
        let samples = text.lines().filter(|line| !line.starts_with('#'));
        samples.map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(samples(&old.body), samples(&new.body));
    let types: Vec<&str> = old.body.lines().filter(|line| line.starts_with("# TYPE")).collect();
    assert!(types.contains(&"# TYPE tertius_build_info gauge"), "{types:?}");
    assert!(types.contains(&"# TYPE tertius_cycles_total counter"), "{types:?}");
    let number = new.body.lines().filter(|line| line.starts_with("# TYPE")).count();
    assert_eq!(types.len(), number);
    assert!(!old.body.contains("# EOF") && !old.body.contains("# UNIT"));
}

#[test]
fn latency_is_that_of_caused_warnings_alone() {
    let mut bench = Bench::new();
    bench.witness.recorder.opened();
    bench.run(&eventful(), DELAY);
    let metrics = bench.metrics();
    let (warnings, frames) = (bench.witness.warnings, bench.witness.warning_frames);
    assert!(frames > warnings, "some of them were repetitions");
    assert_eq!(metrics.get("tertius_warning_latency_seconds_count", &[]), warnings as f64);
    // Each was handed over in the turn after the frame that caused it, or after a deadline.
    let at_once = metrics.get("tertius_warning_latency_seconds_bucket", &["le=5e-05"]);
    assert!(at_once >= 2.0, "{at_once}");
    assert_eq!(metrics.get("tertius_warning_latency_seconds_bucket", &["le=2.5e-05"]), 0.0);
}

#[test]
fn health_claims_nothing_without_evidence() {
    let mut bench = Bench::new();
    let expect = |bench: &Bench, code: u16, status: &str, reason: &str| {
        let (found, health) = bench.health();
        assert_eq!((found, health["status"].as_str()), (code, Some(status)), "{health}");
        assert!(health["reason"].as_str().is_some_and(|r| r.contains(reason)), "{health}");
        health
    };
    let closed = expect(&bench, 503, "down", "not open");
    assert_eq!((&closed["bus"], &closed["seconds_since_turn"]), (&"closed".into(), &().into()));
    bench.witness.recorder.opened();
    expect(&bench, 503, "down", "has not started");
    bench.turn().expect("the bus is up");
    expect(&bench, 200, "unknown", "no frame of the machine yet");
    bench.run(&cycles(0..20), DELAY);
    let starting = expect(&bench, 200, "unknown", "not everything has been judged yet");
    assert_eq!(starting["mode"], "starting");
    bench.run(&cycles(20..120), DELAY);
    let sound = expect(&bench, 200, "ok", "no warning stands");
    assert_eq!((&sound["mode"], &sound["bus"]), (&"monitoring".into(), &"open".into()));
    // The data path goes on, the machine does not.
    for _ in 0..70 {
        bench.hands.pass(Span::from_seconds(0.02));
        bench.turn().expect("the bus is up");
    }
    let quiet = expect(&bench, 200, "unknown", "no frame of the machine for 1.4 s");
    assert_eq!(quiet["seconds_since_turn"], 0.0);
    // Nothing goes on.
    bench.run(&cycles(200..320), DELAY);
    expect(&bench, 200, "ok", "");
    bench.hands.pass(Span::from_seconds(1.0));
    expect(&bench, 200, "ok", "");
    bench.hands.pass(Span::from_nanos(1));
    let dead = expect(&bench, 503, "down", "has not turned for 1.0 s");
    assert_eq!(dead["mode"], serde_json::Value::Null);
}

#[track_caller]
fn assert_nothing_known(bench: &Bench) {
    assert_eq!(bench.metrics().count("tertius_residual_meters"), 0);
    assert_no_transducer_known(bench);
}

#[track_caller]
fn assert_no_transducer_known(bench: &Bench) {
    let metrics = bench.metrics();
    for sample in metrics.samples().iter().filter(|s| s["name"] == "tertius_transducer_state") {
        let unknown = sample["labels"]["state"] == "unknown";
        assert_eq!(sample["value"], f64::from(u8::from(unknown)), "{sample}");
    }
    assert_eq!(metrics.count("tertius_transducer_state"), 60);
}

#[test]
fn residuals_and_health_vanish_with_the_evidence() {
    let known = || {
        let mut bench = Bench::new();
        bench.witness.recorder.opened();
        bench.run(&cycles(0..120), DELAY);
        let metrics = bench.metrics();
        assert_eq!(metrics.count("tertius_residual_meters"), 18);
        let labels = ["cylinder=1", "transducer=c1", "state=healthy"];
        assert_eq!(metrics.get("tertius_transducer_state", &labels), 1.0);
        bench
    };
    // The data path stands still.
    let bench = known();
    bench.hands.pass(Span::from_seconds(1.01));
    assert_nothing_known(&bench);
    assert_eq!(bench.metrics().get("tertius_mode", &["mode=monitoring"]), 0.0);
    // The bus falls quiet.
    let mut bench = known();
    for _ in 0..20 {
        bench.hands.pass(Span::from_seconds(0.1));
        bench.turn().expect("the bus is up");
    }
    assert_nothing_known(&bench);
    // The port is lost, and comes again without anything to judge by.
    let mut bench = known();
    bench.bus.set_state(BusState::Down);
    bench.turn().expect_err("the bus is down");
    assert_nothing_known(&bench);
    assert_eq!(bench.metrics().get("tertius_bus_up", &[]), 0.0);
    assert_eq!(bench.health().0, 503);
    bench.bus.set_state(BusState::Up);
    bench.port = bench.bus.open(&Identifiers::All, 4096).expect("it is up again");
    bench.witness.recorder.opened();
    // For longer than an observer predicts over.
    bench.hands.pass(Span::from_seconds(1.0));
    let later = bench.hands.bus.now().since(Timestamp::from_nanos(machine::START));
    let k = later.as_nanos() / (20 * MS) + 1;
    bench.run(&cycles(k..k + 6), DELAY);
    assert_no_transducer_known(&bench);
    assert_eq!(bench.health().1["status"], "degraded");
    // One transducer falls silent: its residuals go, the others stay.
    let mut bench = known();
    let silent: Vec<Frame> =
        cycles(120..130).into_iter().filter(|frame| frame.id.value() != 0x183).collect();
    bench.run(&silent, DELAY);
    let metrics = bench.metrics();
    let residual = |n: u8, name: &str| {
        let labels = [&*format!("cylinder={n}"), &format!("residual={name}")];
        metrics.find("tertius_residual_meters", &labels)
    };
    assert_eq!((residual(3, "r1"), residual(3, "r3")), (None, None));
    assert!(residual(3, "r2").is_some() && residual(4, "r1").is_some());
}

#[test]
fn totals_go_on_over_losses_and_reloads() {
    let mut bench = Bench::new();
    bench.witness.recorder.opened();
    let mut received = 0;
    for (life, start) in [0, 100, 200].into_iter().enumerate() {
        bench.run(&cycles(start..start + 50), DELAY);
        received += bench.port.counts().received;
        let metrics = bench.metrics();
        assert_eq!(metrics.get("tertius_frames_received_total", &[]), received as f64);
        assert_eq!(metrics.get("tertius_frames_used_total", &[]), received as f64);
        assert_eq!(metrics.get("tertius_port_losses_total", &[]), life.min(1) as f64);
        assert_eq!(metrics.get("tertius_port_reconnects_total", &[]), life.min(1) as f64);
        assert_eq!(metrics.get("tertius_port_opens_total", &[]), (life + 1) as f64);
        if life == 0 {
            bench.bus.set_state(BusState::Gone);
            bench.turn().expect_err("the bus is gone");
            bench.bus.set_state(BusState::Up);
        } else {
            bench.gateway = gateway();
            bench.witness.recorder.reloaded();
        }
        bench.port = bench.bus.open(&Identifiers::All, 4096).expect("it is up");
        bench.witness.recorder.opened();
    }
    bench.witness.recorder.refused();
    let metrics = bench.metrics();
    let reloads = |result| metrics.get("tertius_configuration_reloads_total", &[result]);
    assert_eq!((reloads("result=accepted"), reloads("result=refused")), (2.0, 1.0));
}

#[test]
fn the_link_is_told_as_the_kernel_tells_it() {
    let bench = Bench::new();
    let telemetry = bench.witness.recorder.telemetry().clone();
    assert_eq!(bench.metrics().count("tertius_controller_state"), 0);
    let link = LinkState {
        index: 3,
        up: true,
        mtu: Some(16),
        bit_rate: Some(500_000),
        sample_point: None,
        data_bit_rate: None,
        state: Some(ControllerState::Passive),
        transmit_errors: Some(128),
        receive_errors: Some(7),
        restart_ms: Some(100),
        queue_length: Some(10),
    };
    telemetry.link(&link);
    let metrics = bench.metrics();
    let state = |state| metrics.get("tertius_controller_state", &[state]);
    assert_eq!((state("state=error-passive"), state("state=bus-off")), (1.0, 0.0));
    assert_eq!(metrics.get("tertius_controller_transmit_errors", &[]), 128.0);
    assert_eq!(metrics.get("tertius_controller_receive_errors", &[]), 7.0);
    assert_eq!(metrics.get("tertius_link_up", &[]), 1.0);
    assert_eq!(bench.health().1["controller"], "error-passive");
    telemetry.link_unknown();
    assert_eq!(bench.metrics().find("tertius_link_up", &[]), None);
}

#[test]
fn slow_clients_stop_neither_others_nor_the_gateway() {
    let mut bench = Bench::new();
    bench.witness.recorder.opened();
    // More than there may be, and one that sends half a request.
    let slow: Vec<TcpStream> =
        (0..40).map(|_| TcpStream::connect(bench.server.address()).expect("it listens")).collect();
    for round in 0..20 {
        bench.run(&cycles(round * 10..round * 10 + 10), DELAY);
        assert_eq!(bench.ask("/health").code, 200);
    }
    assert_eq!(bench.metrics().get("tertius_cycles_total", &[]), 200.0);
    // The oldest gave way: its connection ends without an answer.
    let mut oldest = &slow[0];
    oldest.set_read_timeout(Some(Duration::from_secs(60))).expect("a time limit");
    let mut rest = Vec::new();
    assert!(oldest.read_to_end(&mut rest).is_err() || rest.is_empty());
}

#[test]
fn only_what_there_is_is_answered_and_only_without_a_body() {
    let bench = Bench::new();
    let listing = bench.ask("/");
    assert!(listing.body.contains("/health") && listing.body.contains("/metrics"));
    assert_eq!(bench.ask("/etc/passwd").code, 404);
    let request = |request: &str| ask(&bench.server, request).code;
    assert_eq!(request("POST /health HTTP/1.1\r\nHost: localhost\r\n\r\n"), 405);
    assert_eq!(request("GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 3\r\n\r\nabc"), 413);
    let long = format!("GET / HTTP/1.1\r\nHost: localhost\r\nLong: {}\r\n\r\n", "x".repeat(9000));
    assert_eq!(request(&long), 431);
    // A port that is taken is an error with which the gateway goes on.
    let taken =
        Server::start(bench.server.address(), &bench.witness.recorder, Desk::default(), None);
    assert_eq!(taken.expect_err("it is taken").kind(), std::io::ErrorKind::AddrInUse);
}

#[test]
fn a_server_ends_with_its_owner() {
    let Bench { server, witness, .. } = Bench::new();
    let address = server.address();
    drop(server);
    // It ends on its own thread; its address is free once it has.
    let again = (0..10_000).find_map(|_| {
        std::thread::yield_now();
        TcpStream::connect(address)
            .is_err()
            .then(|| Server::start(address, &witness.recorder, Desk::default(), None))
    });
    again.expect("it ends").expect("its address is free");
}

/// A bus that is lost again and again, always for the same reason and before any frame came.
struct Flapping {
    bus: EmbeddedBus,
    bench: Bench,
    left: u32,
}

struct Door(EmbeddedBus);

impl Opener for Door {
    fn open(&mut self) -> Result<Box<dyn Port>, String> {
        self.0.set_state(BusState::Up);
        match self.0.open(&Identifiers::All, 64) {
            Ok(port) => Ok(Box::new(port)),
            Err(error) => Err(error.to_string()),
        }
    }
}

impl Journal for Flapping {
    fn warning(&mut self, warning: &Warning) {
        self.bench.witness.warning(warning);
    }

    fn sent(&mut self, frame: &OwnFrame, at: Timestamp) {
        self.bench.witness.sent(frame, at);
    }
}

impl Surroundings for Flapping {
    fn request(&mut self) -> Request {
        if self.left == 0 { Request::Stop } else { Request::GoOn }
    }

    fn wait(&mut self, _: Duration) {
        let up = self.bench.metrics().get("tertius_bus_up", &[]);
        assert_eq!(up, 0.0, "while a port is waited for");
    }

    fn opened(&mut self, _: &dyn Port) {
        self.bench.witness.recorder.opened();
        self.left -= 1;
        self.bus.set_state(BusState::Down);
    }

    fn lost(&mut self, _: &str) {}

    fn report_not_sent(&mut self, reason: &str) {
        assert_eq!((self.left, reason), (0, "the interface is not open"));
    }

    fn closed(&mut self, gateway: &Gateway, port: &dyn Port) {
        self.bench.witness.recorder.closed(gateway, port);
    }

    fn turned(&mut self, _: &Gateway, _: &dyn Port) {}

    fn reload(&mut self, _: &Gateway) -> Option<(Gateway, Box<dyn Opener>)> {
        None
    }
}

#[test]
fn every_loss_is_told_also_where_the_log_is_silent() {
    let bench = Bench::new();
    let bus = bench.bus.clone();
    let mut flapping = Flapping { bus: bus.clone(), bench, left: 4 };
    supervisor::run(gateway(), Box::new(Door(bus)), &mut flapping);
    let metrics = flapping.bench.metrics();
    let total = |name: &str| metrics.get(&format!("tertius_port_{name}_total"), &[]);
    assert_eq!((total("opens"), total("losses"), total("reconnects")), (4.0, 4.0, 3.0));
}

/// What Prometheus sees of `bench` at four times, 5 s apart; `pass` lets them pass.
fn scraped(bench: &mut Bench, mut pass: impl FnMut(&mut Bench, i64)) -> Vec<serde_json::Value> {
    let mut scrapes = Vec::new();
    for turn in 0..4 {
        if turn > 0 {
            pass(bench, turn);
        }
        let t = bench.hands.bus.now().as_nanos() as f64 / 1e9;
        let text = bench.scrape().body;
        scrapes.push(serde_json::json!({ "t": t, "up": true, "text": text }));
    }
    scrapes
}

/// A gateway that judges a sound machine.
fn judging() -> Bench {
    let mut bench = Bench::new();
    bench.witness.recorder.opened();
    bench.run(&cycles(0..120), DELAY);
    bench
}

/// 5 s of the machine, its transducer off by `offset` counts.
fn machine_goes_on(bench: &mut Bench, turn: i64, offset: u16) {
    let range = 120 + 250 * (turn - 1)..120 + 250 * turn;
    let frames = range.flat_map(|k| Cycle { offset, ..Cycle::new(k) }.frames());
    bench.run(&frames.collect::<Vec<_>>(), DELAY);
}

/// `scrapes` with `to` for `from` in those behind the first.
fn later(scrapes: &[serde_json::Value], from: &str, to: &str) -> Vec<serde_json::Value> {
    let mut scrapes = scrapes.to_vec();
    for scrape in &mut scrapes[1..] {
        let text = scrape["text"].as_str().expect("a text");
        assert_eq!(text.matches(from).count(), 1, "{from:?} is not once in the text");
        scrape["text"] = text.replace(from, to).into();
    }
    scrapes
}

#[test]
fn the_documented_alerts_fire_in_their_cases_and_are_silent_without() {
    let healthy = scraped(&mut judging(), |bench, turn| machine_goes_on(bench, turn, 0));
    let faulty = scraped(&mut judging(), |bench, turn| machine_goes_on(bench, turn, 30));
    let still = scraped(&mut judging(), |bench, _| bench.hands.pass(Span::from_seconds(5.0)));
    let quiet = scraped(&mut judging(), |bench, _| {
        for _ in 0..50 {
            bench.hands.pass(Span::from_seconds(0.1));
            bench.turn().expect("the bus is up");
        }
    });
    let mut lost = judging();
    lost.bus.set_state(BusState::Down);
    lost.turn().expect_err("the bus is down");
    let lost = scraped(&mut lost, |bench, _| bench.hands.pass(Span::from_seconds(5.0)));
    let gone: Vec<_> =
        (0..4).map(|turn| serde_json::json!({ "t": 5 * turn, "up": false })).collect();
    let history = scraped(&mut judging(), |bench, turn| {
        machine_goes_on(bench, turn, 0);
        bench.witness.recorder.telemetry().history_written(false);
    });
    let drift = "# TYPE tertius_stop_earliest_months_until_maintenance gauge\n";
    let due =
        "tertius_stop_earliest_months_until_maintenance{cylinder=\"1\",transducer=\"c2\"} 2.5\n";
    let drifting = later(&healthy, drift, &format!("{drift}{due}"));
    let dropped = "\ntertius_frames_dropped_total 0\n";
    let dropping = later(&healthy, dropped, "\ntertius_frames_dropped_total 3\n");
    let alike = "\ntertius_frames_contradicting_total 0\n";
    let contradicting = later(&healthy, alike, "\ntertius_frames_contradicting_total 3\n");
    let cut = "\ntertius_frames_short_total 0\n";
    let short = later(&healthy, cut, "\ntertius_frames_short_total 3\n");
    let alone = "\ntertius_frames_imitated_total 0\n";
    let imitated = later(&healthy, alone, "\ntertius_frames_imitated_total 3\n");
    let usual = "\ntertius_sync_doubted_seconds_total 0\n";
    let flooded = later(&healthy, usual, "\ntertius_sync_doubted_seconds_total 5\n");
    let opened = "\ntertius_incidents_opened_total{cylinder=\"2\"} 0\n";
    let again = later(&healthy, opened, &opened.replace("} 0", "} 4"));
    let failures = "\ntertius_store_failures_total 0\n";
    let locked = later(&healthy, failures, "\ntertius_store_failures_total 3\n");
    let full = later(&healthy, failures, "\ntertius_store_failures_total 20\n");
    let tokens = "\ntertius_login_failures_total 0\n";
    let mistyped = later(&healthy, tokens, "\ntertius_login_failures_total 3\n");
    let tried = later(&healthy, tokens, "\ntertius_login_failures_total 20\n");
    let failures = "\ntertius_recorder_failures_total 0\n";
    let unrecorded = later(&healthy, failures, "\ntertius_recorder_failures_total 1\n");
    let cases = serde_json::json!({
        "mistyped": mistyped, "tried": tried, "locked": locked, "full": full, "unrecorded": unrecorded,
        "healthy": healthy, "faulty": faulty, "still": still, "quiet": quiet, "lost": lost,
        "gone": gone, "history": history, "drifting": drifting, "dropping": dropping,
        "again": again, "contradicting": contradicting, "short": short,
        "imitated": imitated, "flooded": flooded,
    });
    let files = ["config/prometheus/tertius.rules.yml", "config/grafana/tertius.json"];
    let told = oracle::run("alerts.py", &files, &cases.to_string());
    let told: serde_json::Value = serde_json::from_str(&told).expect("the oracle writes JSON");
    let rules = [
        "Blind",
        "Warning",
        "IncidentsAgainAndAgain",
        "Drift",
        "HistoryLost",
        "FramesLost",
        "FramesContradict",
        "OwnFramesImitated",
        "SyncDoubtful",
        "EventsNotKept",
        "TokensTried",
        "IncidentsNotRecorded",
    ];
    assert_eq!(told["rules"], serde_json::json!(rules));
    let expected = serde_json::json!({
        "healthy": [], "faulty": ["Warning"], "still": ["Blind"], "quiet": ["Blind"],
        "lost": ["Blind"], "gone": ["Blind"], "history": ["HistoryLost"], "drifting": ["Drift"],
        "mistyped": [], "tried": ["TokensTried"], "locked": [], "full": ["EventsNotKept"], "unrecorded": ["IncidentsNotRecorded"],
        "dropping": ["FramesLost"], "contradicting": ["FramesContradict"], "short": ["FramesContradict"],
        "imitated": ["OwnFramesImitated"], "flooded": ["SyncDoubtful"],
        "again": ["IncidentsAgainAndAgain"],
    });
    assert_eq!(told["firing"], expected);
    assert_eq!(told["queries"], 11, "each asks for what there is");
}
