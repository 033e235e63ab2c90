//! What the page is served: what the gateway knows, to those who may have it, and to nobody at the others' cost.

use crate::downloads::connect;
use crate::metrics_support::{Answer, Bench, ask};
use serde_json::Value;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::time::Duration;
use tertius::appliance::http::{Desk, Server};
use tertius::appliance::telemetry::{MachineFacts, Recorder};
use tertius::config::MachineNames;
use tertius::frame::Frame;
use tertius::time::Span;
use tertius_testing::machine::Cycle;

pub const DELAY: Span = Span::from_nanos(30_000);

/// A gateway that has heard 4 s of a machine, at the end of which the second cylinder's C1 is off.
fn bench() -> Bench {
    let mut bench = Bench::new();
    let telemetry = bench.witness.recorder.telemetry();
    let limits_m = vec![[1e-3, 1e-3, 1.5e-3, 0.05]; 6];
    let configuration = "e-type.toml".to_owned();
    let name = "<b>Ampelmann</b>".to_owned();
    let platform_states = vec![(0, "safe".to_owned()), (3, "engaged".to_owned())];
    let facts =
        MachineFacts { name, configuration, limits_m, platform_states, ..MachineFacts::default() };
    telemetry.describe(facts);
    bench.witness.recorder.opened();
    let frames: Vec<Frame> = (0..200)
        .flat_map(|k| Cycle { offset: if k >= 190 { 30 } else { 0 }, ..Cycle::new(k) }.frames())
        .collect();
    bench.run(&frames, DELAY);
    bench
}

pub fn json(answer: &Answer) -> Value {
    serde_json::from_str(&answer.body).unwrap_or_else(|error| panic!("{error}: {}", answer.body))
}

/// Events as they come.
pub struct Watcher {
    answer: BufReader<TcpStream>,
    /// First line of the answer.
    status: String,
}

impl Watcher {
    /// The client `n`, who watches from an address of its own.
    pub fn new(bench: &Bench, n: u8) -> Self {
        let mut stream = connect(bench.server.address(), n, 1 << 20);
        stream.set_read_timeout(Some(Duration::from_secs(60))).expect("a time limit");
        stream.write_all(b"GET /api/stream HTTP/1.1\r\nHost: localhost\r\n\r\n").expect("it reads");
        let mut watcher = Self { answer: BufReader::new(stream), status: String::new() };
        watcher.status = watcher.line().expect("an answer");
        watcher
    }

    fn line(&mut self) -> Option<String> {
        let mut line = String::new();
        let read = self.answer.read_line(&mut line).ok()?;
        (read > 0).then(|| line.trim_end().to_owned())
    }

    /// Data of the next event `name`.
    pub fn event(&mut self, name: &str) -> Value {
        let wanted = format!("event: {name}");
        loop {
            let line = self.line().expect("it goes on");
            if line == wanted {
                let data = self.line().expect("it has data");
                let data = data.strip_prefix("data: ").expect("it is data");
                return serde_json::from_str(data).expect("it is JSON");
            }
        }
    }
}

#[test]
fn the_overview_has_lamps_and_claims_nothing_without_evidence() {
    let mut bench = bench();
    let overview = json(&bench.ask("/api/overview"));
    let lamp = |overview: &Value, cylinder: usize, which: usize| {
        overview["cylinders"][cylinder - 1]["transducers"][which]["lamp"].clone()
    };
    assert_eq!(lamp(&overview, 2, 0), "failure", "{overview}");
    assert_eq!((lamp(&overview, 1, 0), lamp(&overview, 6, 1)), ("good".into(), "good".into()));
    let words = &overview["cylinders"][1]["transducers"][0]["words"];
    assert!(words.as_str().is_some_and(|words| words.starts_with("failure: ")), "{words}");
    let size = overview["cylinders"][1]["residuals_mm"][2].as_f64().expect("it is judged");
    assert!(size > 1.5, "R3 in its newest half second: {size}");
    assert_eq!(overview["incidents"][0]["cylinder"], 2);
    assert_eq!(overview["platform"], "engaged");
    // The bus falls quiet: what was good is unknown, and the incident stands.
    for _ in 0..20 {
        bench.hands.pass(Span::from_seconds(0.1));
        bench.turn().expect("the bus is up");
    }
    let overview = json(&bench.ask("/api/overview"));
    for (cylinder, which) in (1..=6).flat_map(|n| [(n, 0), (n, 1)]) {
        assert_eq!(lamp(&overview, cylinder, which), "unknown");
    }
    assert_eq!(overview["cylinders"][0]["residuals_mm"], serde_json::json!([null, null, null]));
    assert_eq!(overview["platform"], Value::Null, "what it was is no news");
    assert_eq!(overview["incidents"][0]["cylinder"], 2);
}

/// Names of the first two cylinders, which nothing else has to know.
fn names() -> MachineNames {
    let tag = r#"{"name":"Fwd\"Port\\","c1_name":"LT-101A"}"#;
    let other = r#"{"name":"<b>FwdStbd</b>","c1_name":"LT-102A","c2_name":"LT-102B"}"#;
    serde_json::from_str(&format!("[{tag},{other},{{}},{{}},{{}},{{}}]")).expect("names")
}

#[test]
fn names_stand_beside_numbers_in_what_the_page_asks_for_and_in_the_metrics() {
    let bench = bench();
    let bare =
        [bench.ask("/api/overview").body, bench.ask("/api/machine").body, bench.scrape().body];
    for (text, name) in bare.iter().zip(["\"name\":\"Fwd", "\"names\"", "tertius_cylinder_info"]) {
        assert!(!text.contains(name), "{name} in {text}");
    }
    let telemetry = bench.witness.recorder.telemetry();
    telemetry.describe(MachineFacts { names: names(), ..(*telemetry.facts()).clone() });
    let overview = json(&bench.ask("/api/overview"));
    let cylinders = &overview["cylinders"];
    assert_eq!(
        (&cylinders[1]["number"], &cylinders[1]["name"]),
        (&2.into(), &"<b>FwdStbd</b>".into())
    );
    assert_eq!(cylinders[1]["transducers"][1]["name"], "LT-102B");
    assert!(
        cylinders[0]["transducers"][1].get("name").is_none() && cylinders[2].get("name").is_none()
    );
    let incident = &overview["incidents"][0];
    assert_eq!((&incident["cylinder"], &incident["name"]), (&2.into(), &"<b>FwdStbd</b>".into()));
    assert_eq!(incident["suspect_name"], "LT-102A");
    let summary = incident["summary"].as_str().expect("words");
    assert!(summary.starts_with("cylinder 2 (<b>FwdStbd</b>), C1 (LT-102A), "), "{summary}");
    assert_eq!(json(&bench.ask("/api/machine"))["names"][0]["c1_name"], "LT-101A");
    let metrics = bench.metrics();
    let of = |labels: &[&str]| metrics.get("tertius_cylinder_info", labels);
    assert_eq!(of(&["cylinder=1", "name=Fwd\"Port\\"]), 1.0);
    assert_eq!(of(&["cylinder=2", "name=<b>FwdStbd</b>"]), 1.0);
    let tag = ["cylinder=2", "transducer=c2", "name=LT-102B"];
    assert_eq!(metrics.get("tertius_transducer_info", &tag), 1.0);
    let text = bench.scrape().body;
    assert_eq!(text.matches("tertius_cylinder_info{").count(), 2, "{text}");
    assert_eq!(text.matches("tertius_transducer_info{").count(), 3);
    // No other sample has changed: the numbers are what they are joined by.
    assert!(text.contains("tertius_incidents_open{cylinder=\"2\"} 1"), "{text}");
}

#[test]
fn a_trend_has_the_extremes_of_what_was_recorded() {
    let bench = bench();
    let trend = json(&bench.ask("/api/trend/2?seconds=3600"));
    let times: Vec<f64> =
        trend["time"].as_array().expect("times").iter().filter_map(Value::as_f64).collect();
    // The bin that is being filled is not complete.
    assert_eq!(times.len(), 7, "{times:?}");
    for (place, name) in [(0, "c1"), (1, "c2"), (2, "r1"), (3, "r2"), (4, "r3")] {
        let column = &trend["quantities"][place];
        assert_eq!(column["name"], name);
        for (bin, begin) in times.iter().enumerate() {
            let of = bench.witness.records.iter().filter(|record| {
                let at = record.timestamp.as_seconds();
                record.cylinder == 2 && at >= *begin && at < begin + 0.5
            });
            let value = |record: &tertius::monitor::Record| match place {
                0 => record.c1,
                1 => record.c2_corrected.or(record.c2),
                _ => record.residuals[place - 2],
            };
            let values: Vec<f64> = of.filter_map(value).collect();
            let expected = |fold: fn(f64, f64) -> f64| values.iter().copied().reduce(fold);
            let close = |found: &Value, expected: Option<f64>| match (found.as_f64(), expected) {
                (Some(found), Some(expected)) => (found - expected).abs() < 1e-6,
                (found, expected) => found.is_none() && expected.is_none(),
            };
            assert!(close(&column["least"][bin], expected(f64::min)), "{name} {bin}");
            assert!(close(&column["largest"][bin], expected(f64::max)), "{name} {bin}");
        }
    }
    assert_eq!(
        json(&bench.ask("/api/trend/1?seconds=1"))["time"].as_array().map(Vec::len),
        Some(2)
    );
    assert_eq!(bench.ask("/api/trend/7").code, 404);
    assert_eq!(bench.ask("/api/trend/0").code, 404);
    assert_eq!(bench.ask("/api/trend/x").code, 400);
    assert_eq!(bench.ask("/api/trend/1?seconds=-1").code, 400);
    assert_eq!(bench.ask("/api/trend/1?seconds=4294967295").code, 200);
}

#[test]
fn the_page_allows_nothing_that_is_not_its_own() {
    let bench = bench();
    let page = bench.ask("/");
    assert_eq!(page.code, 200);
    let policy = "content-security-policy: default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'";
    assert!(page.head.contains(policy), "{}", page.head);
    assert!(page.head.contains("x-content-type-options: nosniff"));
    assert!(!page.body.contains("://") && !page.body.contains("style="), "{}", page.body);
    let names = page.body.split('"').filter(|name| name.starts_with("/assets/"));
    let mut size = page.body.len();
    for name in names {
        let answer = ask(&bench.server, &format!("GET {name} HTTP/1.1\r\nHost: localhost\r\n\r\n"));
        assert_eq!(answer.code, 200, "{name}");
        size += answer.body.len();
    }
    assert!(size < 150_000, "the whole page has {size} bytes before compression");
    // What the machine is called is a text, and no markup.
    let machine = bench.ask("/api/machine");
    assert!(machine.head.contains("content-type: application/json"), "{}", machine.head);
    assert_eq!(json(&machine)["name"], "<b>Ampelmann</b>");
}

#[test]
fn what_reaches_for_more_is_refused() {
    let bench = bench();
    let get = |path: &str, host: &str| {
        ask(&bench.server, &format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n")).code
    };
    for path in [
        "/assets/../Cargo.toml",
        "/assets/..%2F..%2Fetc%2Fpasswd",
        "/assets/%2e%2e/index.html",
        "/assets//etc/passwd",
        "/assets/",
    ] {
        assert_eq!(get(path, "localhost"), 404, "{path}");
    }
    // A name from elsewhere that was made to point here.
    let pages =
        ["/", "/api/overview", "/api/machine", "/api/trend/1", "/api/stream", "/assets/page.js"];
    for path in pages.into_iter().chain(["/health", "/metrics"]) {
        for host in ["evil.example", "localhost.evil.example:9481", "192.168.0.9"] {
            assert_eq!(get(path, host), 421, "{path} for {host}");
        }
    }
    for path in ["/health", "/metrics"] {
        assert!(bench.ask(path).head.contains("x-content-type-options: nosniff"), "{path}");
    }
    let code = |request: &str| ask(&bench.server, request).code;
    assert_eq!(code("GET / HTTP/1.1\r\n\r\n"), 421, "no Host at all");
    assert_eq!(code("POST /api/overview HTTP/1.1\r\nHost: localhost\r\n\r\n"), 405);
}

#[test]
fn beyond_this_computer_only_machines_are_answered() {
    let recorder =
        Recorder::new(Arc::new(tertius::appliance::telemetry::clock::SystemClock::new()));
    let everywhere = "0.0.0.0:0".parse().expect("an address");
    let server =
        Server::start(everywhere, &recorder, Desk::default(), None).expect("there is a free port");
    let get = |path: &str| ask(&server, &format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n"));
    for path in ["/", "/api/overview", "/api/stream"] {
        let answer = get(path);
        assert_eq!(answer.code, 403);
        assert!(answer.body.contains("ssh -L"), "{}", answer.body);
    }
    assert_eq!(get("/metrics").code, 200);
}

#[test]
fn those_who_watch_are_told_what_is_new() {
    let bench = bench();
    let mut watcher = Watcher::new(&bench, 1);
    let overview = watcher.event("overview");
    assert_eq!(overview["cylinders"].as_array().map(Vec::len), Some(6));
    assert_eq!(overview["cylinders"][1]["transducers"][0]["lamp"], "failure");
    // A new bin comes once, of every cylinder.
    let mut bench = bench;
    let frames: Vec<Frame> = (200..230).flat_map(|k| Cycle::new(k).frames()).collect();
    bench.run(&frames, DELAY);
    let trend = json(&bench.ask("/api/trend/3"));
    let times = trend["time"].as_array().expect("times");
    let mut told: Vec<Value> = Vec::new();
    let has_newest = |told: &[Value]| {
        told.iter().rfind(|row| row[0] == 3).is_some_and(|row| Some(&row[1]) == times.last())
    };
    while !has_newest(&told) {
        told.extend(watcher.event("bins").as_array().expect("rows").iter().cloned());
    }
    for cylinder in 1..=6 {
        let of: Vec<&Value> =
            told.iter().filter(|row| row[0] == cylinder).map(|row| &row[1]).collect();
        assert!(times.iter().collect::<Vec<_>>().ends_with(&of), "{of:?} of {times:?}");
    }
    assert!(told.iter().all(|row| row[2].as_array().map(Vec::len) == Some(14)));
}

/// Whoever watches without reading is dropped; others, and who asks once, are served.
#[test]
fn who_watches_and_does_not_read_costs_nobody_anything() {
    let bench = bench();
    // One address may have half of the places.
    let watcher = |n: u8| Watcher::new(&bench, 1 + n % 2);
    let idle: Vec<Watcher> = (0..10).map(watcher).collect();
    let mut reading: Vec<Watcher> = (0..40).map(watcher).collect();
    for watcher in &mut reading {
        watcher.event("overview");
    }
    assert_eq!(bench.ask("/health").code, 200);
    // As many as there may be, and one more.
    let more: Vec<Watcher> = (0..14).map(watcher).collect();
    let late = watcher(0);
    assert!(late.status.contains("503"), "{}", late.status);
    drop((idle, more));
    for watcher in &mut reading {
        watcher.event("overview");
    }
}
