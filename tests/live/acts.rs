//! Acts on alarms over HTTP: who may, what is refused, and what is kept.

use crate::metrics_support::{Answer, ask};
use serde_json::{Value, json};
use std::path::Path;
use std::sync::Arc;
use tempfile::TempDir;
use tertius::appliance::doctor::facts::Wanted;
use tertius::appliance::http::{Desk, DeskPlan, Server, TokenDigest};
use tertius::appliance::store::{Cause, Clerk, StorePlan};
use tertius::appliance::telemetry::Recorder;
use tertius::appliance::telemetry::clock::SystemClock;
use tertius::config::MachineNames;
use tertius::config::settings::Realtime;
use tertius::frame::Id;
use tertius_testing::process::{configuration, excerpt, write};
use tertius_testing::support::tertius;

const TOKEN: &str = "0123456789abcdef0123456789abcdef";

/// A served store in which an incident stands unacknowledged.
struct Office {
    server: Server,
    desk: Desk,
    _clerk: Clerk,
    _folder: TempDir,
}

impl Office {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("there is room");
        fill(folder.path());
        let recorder = Recorder::new(Arc::new(SystemClock::new()));
        let mut clerk = Clerk::new(recorder.telemetry());
        let plan = StorePlan {
            path: folder.path().join("kept.events"),
            size: 8_000_000,
            days: 100,
            machine: "a machine".to_owned(),
            names: MachineNames::default(),
            configuration: String::new(),
            sample_time: 0.02,
        };
        clerk.begin(Some(plan), Cause::Start, false);
        let desk = Desk::new(clerk.handle(), Arc::default());
        desk.follow(DeskPlan { token: Some(TokenDigest::of(TOKEN)), ..DeskPlan::default() });
        let listen = "127.0.0.1:0".parse().expect("an address");
        let server =
            Server::start(listen, &recorder, desk.clone(), None).expect("there is a free port");
        let office = Self { server, desk, _clerk: clerk, _folder: folder };
        // Its thread opens the store meanwhile.
        let opened = || !office.get("/api/alarms").body.contains("\"path\":null");
        assert!((0..100_000).any(|_| opened()), "the store is not opened");
        office
    }

    fn get(&self, path: &str) -> Answer {
        ask(&self.server, &format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n"))
    }

    fn post(&self, path: &str, headers: &str, body: &str) -> u16 {
        let length = body.len();
        let head =
            format!("POST {path} HTTP/1.1\r\nHost: localhost\r\nContent-Length: {length}\r\n");
        ask(&self.server, &format!("{head}{headers}\r\n{body}")).code
    }

    fn act(&self, path: &str, body: &Value) -> u16 {
        let headers =
            format!("Content-Type: application/json\r\nAuthorization: Bearer {TOKEN}\r\n");
        self.post(path, &headers, &body.to_string())
    }

    /// The alarms, as listed.
    fn alarms(&self) -> Vec<Value> {
        let body: Value = serde_json::from_str(&self.get("/api/alarms").body).expect("it is JSON");
        body["alarms"].as_array().unwrap_or_else(|| panic!("{body}")).clone()
    }
}

/// Lets a gateway run into steps of 1.25 mm.
fn fill(folder: &Path) {
    let config = configuration(folder, "virtual");
    let text = std::fs::read_to_string(&config).expect("it was written");
    std::fs::write(&config, format!("[store]\nfile = \"kept.events\"\n\n{text}")).expect("ours");
    let log = folder.join("bus.log");
    write(&log, "can0", &excerpt(57.0, 72.0));
    let plain = |path: &Path| path.to_str().expect("a plain name").to_owned();
    let (config, log) = (plain(&config), plain(&log));
    tertius(&["run", "--config", &config, "--play", &log, "--speed", "max"], b"").ok();
}

#[test]
fn an_act_is_kept_with_who_did_it_and_changes_nothing_else() {
    let office = Office::new();
    let alarm = office.alarms()[0].clone();
    assert_eq!(alarm["state"], "returned_unacknowledged", "{alarm}");
    let of = |act: &str| format!("/api/alarms/{}/{act}", alarm["incident"]);
    let shelving = json!({"who": "Eva", "note": "a new cable is on its way", "minutes": 60});
    assert_eq!(office.act(&of("shelve"), &shelving), 204);
    let shelved = office.alarms()[0].clone();
    assert_eq!((&shelved["state"], &shelved["shelved_by"]), (&"shelved".into(), &"Eva".into()));
    assert_eq!(office.act(&of("unshelve"), &json!({"who": "Eva"})), 204);
    assert_eq!(office.alarms()[0]["state"], "returned_unacknowledged");
    assert_eq!(office.act(&of("acknowledge"), &json!({"who": "Eva", "note": "it was wet"})), 204);
    assert!(office.alarms().iter().all(|it| it["incident"] != alarm["incident"]), "it is over");
    let page = office.get(&format!("/api/incidents/{}", alarm["incident"])).body;
    let page: Value = serde_json::from_str(&page).expect("it is JSON");
    let kinds: Vec<&Value> =
        page["acts"].as_array().expect("acts").iter().map(|act| &act["kind"]).collect();
    assert_eq!(kinds, ["shelve", "unshelve", "acknowledge"]);
    let csv = office.get("/api/export/events.csv?kind=act").body;
    assert_eq!(csv.lines().count(), 1 + 3, "{csv}");
    assert!(csv.contains("it was wet"));
}

#[test]
fn an_act_without_all_that_it_needs_is_refused() {
    let office = Office::new();
    let alarm = office.alarms()[0]["incident"].clone();
    let path = format!("/api/alarms/{alarm}/acknowledge");
    let body = json!({"who": "Eva"}).to_string();
    let json_type = "Content-Type: application/json\r\n";
    let token = format!("Authorization: Bearer {TOKEN}\r\n");
    let post = |headers: &str| office.post(&path, headers, &body);
    assert_eq!(post(json_type), 401, "no token");
    assert_eq!(post(&format!("{json_type}Authorization: Bearer {TOKEN}0\r\n")), 401);
    assert_eq!(post(&token), 415, "a form of another page cannot send JSON");
    assert_eq!(post(&format!("Content-Type: text/plain\r\n{token}")), 415);
    for elsewhere in [
        "Origin: http://evil.example\r\n",
        "Origin: null\r\n",
        "Origin: http://localhost.evil.example\r\n",
        "Sec-Fetch-Site: cross-site\r\n",
        "Sec-Fetch-Site: same-site\r\n",
    ] {
        assert_eq!(post(&format!("{json_type}{token}{elsewhere}")), 403, "{elsewhere}");
    }
    // Asked by a browser whether another page may.
    let question = format!(
        "OPTIONS {path} HTTP/1.1\r\nHost: localhost\r\nOrigin: http://evil.example\r\n\r\n"
    );
    let answer = ask(&office.server, &question);
    assert!(answer.code == 405 && !answer.head.contains("access-control"), "{}", answer.head);
    let foreign = format!(
        "POST {path} HTTP/1.1\r\nHost: evil.example\r\n{json_type}{token}Content-Length: {}\r\n\r\n{body}",
        body.len()
    );
    assert_eq!(ask(&office.server, &foreign).code, 421);
    assert_eq!(office.act(&path, &json!({})), 400, "nobody");
    assert_eq!(office.act(&path, &json!({"who": "Eva", "more": 1})), 400);
    assert_eq!(office.act(&path, &json!({"who": "x".repeat(9000)})), 413);
    let shelve = format!("/api/alarms/{alarm}/shelve");
    assert_eq!(office.act(&shelve, &json!({"who": "Eva", "minutes": 60})), 400, "no reason");
    assert_eq!(office.act("/api/alarms/999999/acknowledge", &json!({"who": "Eva"})), 404);
    assert_eq!(office.act(&format!("/api/alarms/{alarm}/delete"), &json!({"who": "Eva"})), 404);
    assert_eq!(office.get(&path).code, 405);
    // Nothing of all that was done.
    assert_eq!(office.alarms()[0]["state"], "returned_unacknowledged");
    // Without a token in the configuration nobody may.
    office.desk.follow(DeskPlan::default());
    assert_eq!(office.act(&path, &json!({"who": "Eva"})), 403);
}

#[test]
fn what_is_searched_for_is_found_or_refused_in_words() {
    let office = Office::new();
    let found = |query: &str| -> Value {
        serde_json::from_str(&office.get(&format!("/api/events?{query}")).body).expect("it is JSON")
    };
    let incidents = found("kind=incident&level=yellow")["entries"].as_array().map(Vec::len);
    assert!(incidents.is_some_and(|count| count > 0));
    assert_eq!(found("kind=incident&cylinder=5")["entries"], json!([]));
    assert_eq!(found("text=%22%3B%20DROP%20TABLE%20events")["entries"], json!([]));
    for (query, word) in [("kind=x", "kind"), ("level=pink", "level"), ("suspect=me", "suspect")] {
        let answer = office.get(&format!("/api/events?{query}"));
        assert!(answer.code == 400 && answer.body.contains(word), "{}", answer.body);
    }
    assert_eq!(office.get("/api/events?nonsense=1").code, 400);
    assert_eq!(office.get("/api/events?limit=-1").code, 400);
    assert_eq!(office.get("/api/incidents/999999").code, 404);
    assert_eq!(office.get("/api/export/..%2fkept.events").code, 404);
    assert_eq!(office.get("/api/export/events.db").code, 404);
}

/// What `tertius doctor` finds belongs to the machine that is being watched, and is not looked for at every request.
#[test]
fn the_doctor_examines_this_computer_when_somebody_asks() {
    let office = Office::new();
    assert_eq!(office.get("/api/doctor").code, 404, "nothing is known of a configuration");
    let patient = Wanted {
        config: "here.toml".into(),
        dbc: "here.dbc".to_owned(),
        dbc_findings: 2,
        interface: "none-such".to_owned(),
        bit_rate: 500_000,
        sample_time: 0.02,
        node: 81,
        own: vec![],
        status: Id::standard(0x1D1).expect("eleven bits"),
        messages: vec![],
        others: Vec::new(),
        realtime: Realtime::default(),
        files: Vec::new(),
        keeps: vec![("the events", std::env::temp_dir().join("none/such.events"))],
        calibrated: None,
    };
    office.desk.follow(DeskPlan { patient: Some(patient.clone()), ..DeskPlan::default() });
    let answer = office.get("/api/doctor");
    let report: Value = serde_json::from_str(&answer.body).expect("JSON");
    let verdict = |subject: &str| {
        let findings = report["findings"].as_array().expect("findings");
        findings.iter().find(|it| it["subject"] == subject).map(|it| it["verdict"].clone())
    };
    assert_eq!(verdict("dbc"), Some("warn".into()), "{report}");
    assert_eq!(verdict("interface"), Some("fail".into()), "{report}");
    assert!(verdict("disk").is_some(), "{report}");
    // Within a minute it is the same examination.
    let patient = Some(Wanted { interface: "virtual".to_owned(), ..patient });
    office.desk.follow(DeskPlan { patient, ..DeskPlan::default() });
    assert_eq!(office.get("/api/doctor").body, answer.body);
}
