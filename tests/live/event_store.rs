//! What the gateway finds is in its event store, and can be read while it runs and after it.

use serde_json::Value;
use std::path::Path;
use tertius::alarm_list::ActKind;
use tertius::appliance::store::{AlarmAct, Cause, Clerk, Filter, StorePlan, StoreReader};
use tertius::appliance::telemetry::Recorder;
use tertius::appliance::telemetry::clock::{Clock, SystemClock};
use tertius::config::MachineNames;
use tertius::frame::Frame;
use tertius::time::Span;
use tertius_testing::process::{configuration, excerpt, write};
use tertius_testing::support::{Run, replay, tertius};

/// Steps of 1.25 mm at 60 s; they end at 65 s.
fn stage(folder: &Path) -> (String, String) {
    let config = configuration(folder, "virtual");
    let text = std::fs::read_to_string(&config).expect("it was written");
    let kept = "[store]\nfile = \"kept.events\"\n\n";
    std::fs::write(&config, format!("{kept}{text}")).expect("the folder is ours");
    let log = folder.join("bus.log");
    write(&log, "can0", &excerpt(57.0, 72.0));
    let plain = |path: &Path| path.to_str().expect("temporary folders have plain names").to_owned();
    (plain(&config), plain(&log))
}

fn run(config: &str, log: &str) -> Run {
    tertius(&["run", "--config", config, "--play", log, "--speed", "max"], b"").ok()
}

fn events(config: &str, options: &[&str]) -> Run {
    tertius(&[&["events", "--config", config], options].concat(), b"")
}

#[test]
fn the_store_has_the_incidents_that_a_replay_finds() {
    let folder = tempfile::tempdir().expect("there is room");
    let (config, log) = stage(folder.path());
    events(&config, &[]).failed(2, &["kept.events"]);
    run(&config, &log);
    let expected = replay(&[&log], &config, &[]).ok();
    let summaries = |lines: &[Value], key: &str| {
        let mut texts: Vec<String> =
            lines.iter().map(|it| it[key].as_str().expect("a text").to_owned()).collect();
        texts.sort();
        texts
    };
    let of_replay: Vec<Value> = expected
        .incidents()
        .into_iter()
        .filter(|it| it["state"] == "closed" || it["state"] == "standing")
        .collect();
    let kept = events(&config, &["--kind", "incident", "--format", "jsonl"]).ok();
    assert!(!of_replay.is_empty());
    assert_eq!(summaries(&kept.lines(), "text"), summaries(&of_replay, "summary"));
    let begins = |lines: &[Value], key: &str| {
        let mut begins: Vec<f64> = lines.iter().map(|it| it[key].as_f64().expect("s")).collect();
        begins.sort_by(f64::total_cmp);
        begins
    };
    let first = expected.warnings()[0].clone();
    let zero = first["timestamp"].as_f64().expect("s") - first["t"].as_f64().expect("s");
    let expected = begins(&of_replay, "begin");
    for (kept, begin) in begins(&kept.lines(), "at_s").into_iter().zip(expected) {
        assert!((kept - zero - begin).abs() < 1e-5, "{kept} {begin}");
    }
}

/// For two seconds a second device sends C1 of cylinder 1, too, and C1 of cylinder 3 has a status without a meaning.
#[test]
fn what_cannot_be_relied_on_is_kept_and_logged_as_a_replay_tells_it() {
    let folder = tempfile::tempdir().expect("there is room");
    let (config, log) = stage(folder.path());
    let begin = excerpt(57.0, 57.1)[0].timestamp;
    let odd = |frame: &Frame, place: usize, bits: u8| {
        let mut data = frame.data().to_vec();
        data[place] ^= bits;
        Frame::new(frame.timestamp, frame.id, frame.kind, &data)
    };
    let doubtful = excerpt(57.0, 72.0).into_iter().flat_map(|frame| {
        let is_odd = (1.0..3.0).contains(&frame.timestamp.since(begin).as_seconds());
        match frame.id.value() {
            0x181 if is_odd => vec![odd(&frame, 0, 1), frame],
            0x183 if is_odd => vec![odd(&frame, 4, 0x40)],
            _ => vec![frame],
        }
    });
    write(Path::new(&log), "can0", &doubtful.collect::<Vec<_>>());
    let told: Vec<(String, bool)> = run(&config, &log)
        .stderr
        .lines()
        .filter(|line| line.contains("0x181") || line.contains("0x40"))
        .map(|line| (line.to_owned(), line.contains("WARN")))
        .collect();
    let kept = events(&config, &["--kind", "doubt", "--format", "jsonl"]).ok().lines();
    let mut texts: Vec<&str> = kept.iter().rev().filter_map(|it| it["text"].as_str()).collect();
    let words = [
        "frames 0x181 contradict each other: a second device sends them, too",
        "C1: the status has 0x40, which `plausibility.status_mask` does not have",
        "frames 0x181 no longer contradict each other",
    ];
    texts.sort_by_key(|text| words.iter().position(|word| text.starts_with(word)));
    assert_eq!(texts.len(), words.len(), "{texts:?}");
    for (text, word) in texts.iter().zip(words) {
        assert!(text.starts_with(word), "{text} is not {word}");
        let what = text.strip_prefix("C1: ").unwrap_or(text);
        let logged = told.iter().filter(|(line, _)| line.contains(what));
        let is_warning = !word.contains("no longer");
        assert_eq!(logged.map(|(_, warns)| *warns).collect::<Vec<_>>(), [is_warning], "{told:?}");
    }
    let cylinders: Vec<&Value> = kept.iter().rev().map(|it| &it["cylinder"]).collect();
    assert_eq!(cylinders.iter().filter(|it| ***it == 3).count(), 1, "{kept:?}");
    let of_replay = replay(&[&log], &config, &[]).ok();
    let notices = of_replay.lines().into_iter().filter(|line| {
        let what = line["notice"].as_str().unwrap_or_default();
        what.starts_with("contradiction") || what == "unnamed_status"
    });
    assert_eq!(notices.count(), words.len());
}

#[test]
fn what_is_kept_does_nothing_to_a_terminal() {
    let folder = tempfile::tempdir().expect("there is room");
    let (config, log) = stage(folder.path());
    run(&config, &log);
    let store = rusqlite::Connection::open(folder.path().join("kept.events")).expect("it is there");
    let evil = "\u{1b}[2J\u{9b}31m\u{202e}";
    store.execute("UPDATE events SET text = ?1 || text", [evil]).expect("it is free");
    for format in ["human", "jsonl", "csv"] {
        let shown = events(&config, &["--format", format]).ok().stdout;
        assert!(shown.contains("\\u001b[2J\\u009b31m\\u202e"), "{shown}");
        let acts = |c: char| (c.is_control() && c != '\n') || c == '\u{202e}';
        assert!(!shown.contains(acts), "{shown:?}");
    }
}

#[test]
fn each_start_and_stop_is_an_event_and_csv_says_it_too() {
    let folder = tempfile::tempdir().expect("there is room");
    let (config, log) = stage(folder.path());
    run(&config, &log);
    run(&config, &log);
    let human = events(&config, &[]).ok().stdout;
    assert_eq!(human.matches("  start: tertius").count(), 2, "{human}");
    assert_eq!(human.matches("  stop: the gateway was stopped").count(), 2, "{human}");
    assert_eq!(human.matches("bus opened: ").count(), 2, "{human}");
    assert!(!human.contains("without a word"), "{human}");
    let csv = events(&config, &["--format", "csv", "--search", "step"]).ok().stdout;
    let mut lines = csv.lines();
    assert!(lines.next().is_some_and(|head| head.starts_with("id,at_utc,at_s,kind,cylinder,")));
    let incidents = lines.filter(|line| line.contains(",incident,")).count();
    assert!(incidents >= 2 && incidents.is_multiple_of(2), "{csv}");
    let told = events(&config, &["--kind", "nothing"]);
    told.failed(2, &["expected one of incident, act, start"]);
}

/// Cylinders are called as the configuration says today.
#[test]
fn files_of_events_have_the_names_of_cylinders() {
    let folder = tempfile::tempdir().expect("there is room");
    let (config, log) = stage(folder.path());
    run(&config, &log);
    let export = |format: &str| events(&config, &["--format", format]).ok().stdout;
    let (csv, lines) = (export("csv"), export("jsonl"));
    assert!(!csv.contains(",name,") && !lines.contains("\"name\""), "without names: {csv}");
    let text = std::fs::read_to_string(&config).expect("it was written");
    let named = (1..=6).fold(text, |text, n| {
        let own = format!("[[cylinder]]\nn = {n}\n");
        assert_eq!(text.matches(&own).count(), 1, "{own:?}");
        text.replace(&own, &format!("{own}name = \"Deck, {n}\"\n"))
    });
    std::fs::write(&config, named).expect("the folder is ours");
    let [bare, named] =
        [csv, export("csv")].map(|it| it.lines().map(str::to_owned).collect::<Vec<_>>());
    assert_eq!(named[0], bare[0].replace(",cylinder,", ",cylinder,name,"));
    let mut of_cylinders = 0;
    for (bare, named) in bare.iter().zip(&named).skip(1) {
        let fields: Vec<&str> = bare.splitn(6, ',').collect();
        let (n, rest) = (fields[4], fields[5]);
        let name = if n.is_empty() { String::new() } else { format!("\"Deck, {n}\"") };
        assert_eq!(*named, format!("{},{n},{name},{rest}", fields[..4].join(",")));
        of_cylinders += usize::from(!n.is_empty());
    }
    assert!(of_cylinders >= 1 && of_cylinders + 1 < bare.len(), "{bare:?}");
    for line in events(&config, &["--format", "jsonl"]).ok().lines() {
        let expected = line["cylinder"].as_u64().map(|n| format!("Deck, {n}"));
        assert_eq!(line.get("name").and_then(Value::as_str), expected.as_deref(), "{line}");
    }
}

#[test]
fn an_act_is_answered_once_it_is_kept() {
    let folder = tempfile::tempdir().expect("there is room");
    let (config, log) = stage(folder.path());
    run(&config, &log);
    let path = folder.path().join("kept.events");
    let clock = SystemClock::new();
    let recorder = Recorder::new(std::sync::Arc::new(clock));
    let mut clerk = Clerk::new(recorder.telemetry());
    let plan = StorePlan {
        path: path.clone(),
        size: 8_000_000,
        days: 100,
        machine: "a machine".to_owned(),
        names: MachineNames::default(),
        configuration: String::new(),
        sample_time: 0.02,
    };
    clerk.begin(Some(plan), Cause::Start, false);
    let now = clock.system();
    let listed = |now| StoreReader::open(&path).and_then(|reader| reader.overview(now, false));
    let before = listed(now).expect("it can be read");
    let incident = before.alarms[0].incident;
    let handle = clerk.handle();
    let until = now.after(Span::from_seconds(600.0));
    for kind in [ActKind::Acknowledge, ActKind::Shelve(until)] {
        let act = AlarmAct::new(incident, kind, now, ["A. Person", "the cable is on its way"]);
        let answer = handle.act(act.expect("it is whole")).expect("nothing else waits");
        _ = answer.blocking_recv().expect("it is answered");
    }
    let reader = StoreReader::open(&path).expect("it is there");
    let page = reader.incident(incident, now).expect("it can be read").expect("it is there");
    assert_eq!(page.acts[0].who, "A. Person");
    assert_eq!(page.alarm.acknowledged_note.as_deref(), Some("the cable is on its way"));
    let found = reader.search(&Filter { text: "cable way".to_owned(), ..Filter::default() }, now);
    assert!(!found.expect("it can be read").entries.is_empty(), "acts are events");
    clerk.finish();
    assert_eq!(handle.state().trouble, None);
}

#[test]
fn a_store_that_would_overwrite_an_input_is_refused() {
    let folder = tempfile::tempdir().expect("there is room");
    let (config, _) = stage(folder.path());
    let text = std::fs::read_to_string(&config).expect("it was written");
    let text = text.replace("kept.events", "machine.toml");
    std::fs::write(&config, text).expect("the folder is ours");
    tertius(&["check", &config], b"").failed(2, &["`store.file` would overwrite"]);
}
