//! What the store does with what happens to it.

use super::act::{ActError, ActRequest, AlarmAct};
use super::note::{Event, EventKind, Note};
use super::plan::{Cause, Plan, StorePlan};
use super::query::Filter;
use super::reader::{AlarmOverview, Counts, StoreReader};
use super::samples::{BEGIN, closed, incident, warning};
use super::shared::Shared;
use super::writer::Writer;
use crate::alarm_list::{ActKind, ActRefusal};
use crate::appliance::telemetry::Telemetry;
use crate::appliance::telemetry::clock::SystemClock;
use std::fs;
use std::path::PathBuf;
use tempfile::TempDir;
use tertius_config::MachineNames;
use tertius_core::alarm::Level;
use tertius_core::incident::{Cylinders, Incident, Progress, Scope};
use tertius_core::time::{Span, Timestamp};
use tokio::sync::oneshot;

mod robustness;

const MB: u64 = 1_000_000;

/// A store in a folder of its own.
struct Bench {
    folder: TempDir,
    shared: Shared,
    telemetry: Telemetry,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("there is room");
        let telemetry = Telemetry::new(&SystemClock::new());
        Self { folder, shared: Shared::default(), telemetry }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("kept.events")
    }

    fn plan(&self, size: u64) -> StorePlan {
        StorePlan {
            path: self.path(),
            size,
            days: 1000,
            machine: "a machine".to_owned(),
            names: MachineNames::default(),
            configuration: "0123456789abcdef".to_owned(),
            sample_time: 0.02,
        }
    }

    /// A writer that has begun, as after the program's start.
    fn writer(&self) -> Writer<'_> {
        self.writer_by(self.plan(8 * MB), false)
    }

    fn writer_by(&self, store: StorePlan, continues: bool) -> Writer<'_> {
        let mut writer = Writer::new(&self.shared, &self.telemetry);
        let plan = Plan { store, cause: Cause::Start, at: BEGIN, continues };
        writer.take(Note::Begin(Some(Box::new(plan))));
        writer
    }

    fn reader(&self) -> StoreReader {
        StoreReader::open(&self.path()).expect("it was written")
    }

    /// The alarm list, whose counts are those of its alarms.
    fn overview(&self) -> AlarmOverview {
        let overview = self.reader().overview(later(100.0), false).expect("it can be read");
        let count = |state| overview.alarms.iter().filter(|it| it.state == state).count() as u64;
        let listed = Counts {
            unacknowledged: count("unacknowledged"),
            acknowledged: count("acknowledged"),
            returned: count("returned_unacknowledged"),
            interrupted: count("interrupted_unacknowledged"),
            shelved: count("shelved"),
        };
        assert!(overview.counts == listed || overview.alarms.len() == 200, "{overview:?}");
        overview
    }

    /// Texts of the entries that `filter` finds, the newest first.
    fn texts(&self, filter: &Filter) -> Vec<String> {
        let found = self.reader().search(filter, later(100.0)).expect("it can be read");
        found.entries.into_iter().map(|entry| entry.text).collect()
    }

    fn of_kind(&self, kind: EventKind) -> Vec<String> {
        self.texts(&Filter { kind: Some(kind), ..Filter::default() })
    }

    fn trouble(&self) -> Option<String> {
        self.shared.state.lock().expect("nobody panicked").trouble.clone()
    }

    fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).expect("it is there");
        let names = entries.map(|entry| entry.expect("it is there").file_name());
        let mut names: Vec<_> = names.map(|name| name.into_string().expect("UTF-8")).collect();
        names.retain(|name| !name.ends_with("-shm") && !name.ends_with("-wal"));
        names.sort();
        names
    }
}

fn later(seconds: f64) -> Timestamp {
    BEGIN.after(Span::from_seconds(seconds))
}

type Answer = oneshot::Receiver<Result<(), ActError>>;

fn act(incident: i64, kind: ActKind, texts: [&str; 2]) -> (Note, Answer) {
    let (answer, answered) = oneshot::channel();
    let act = AlarmAct::new(incident, kind, later(10.0), texts).expect("it is whole");
    (Note::Act(ActRequest { act: Box::new(act), answer }), answered)
}

/// Writes these notes, and returns the writer.
fn written<'a>(mut writer: Writer<'a>, notes: impl IntoIterator<Item = Note>) -> Writer<'a> {
    notes.into_iter().for_each(|note| _ = writer.take(note));
    writer.write();
    writer
}

/// What a person does with the only incident, and the answer.
fn done(writer: &mut Writer<'_>, bench: &Bench, kind: ActKind) -> Result<(), ActError> {
    bench.shared.acts.fetch_add(1, std::sync::atomic::Ordering::AcqRel);
    let id = bench.texts_and_ids()[0];
    let (note, mut answered) = act(id, kind, ["A. Person", "on it"]);
    writer.take(note);
    writer.write();
    answered.try_recv().expect("it is answered once it is written")
}

impl Bench {
    /// Numbers of the incidents, the newest first.
    fn texts_and_ids(&self) -> Vec<i64> {
        let filter = Filter { kind: Some(EventKind::Incident), ..Filter::default() };
        let found = self.reader().search(&filter, later(100.0)).expect("it can be read");
        found.entries.into_iter().map(|entry| entry.id).collect()
    }
}

#[test]
fn an_incident_is_read_as_it_was_told() {
    let bench = Bench::new();
    let revised = Incident { progress: Progress::Revised, level: Level::Orange, ..incident(6) };
    let notes = [
        Note::Warning(tertius_core::alarm::Warning { timestamp: later(6.0), ..warning() }),
        Note::Incident(incident(6)),
        Note::Incident(revised),
        Note::Incident(Incident { level: Level::Orange, ..closed(6) }),
    ];
    drop(written(bench.writer(), notes));
    let id = bench.texts_and_ids()[0];
    let page = bench.reader().incident(id, later(100.0)).expect("read").expect("it is there");
    assert_eq!(page.alarm.state, "returned_unacknowledged");
    assert_eq!((page.alarm.level, page.alarm.ending.as_deref()), ("orange", Some("returned")));
    assert_eq!(
        page.alarm.text,
        "cylinder 1, C1, orange: step of 1.21 mm, R1 up to 1.20 mm (limit 1.00 mm)"
    );
    let alarm = &page.alarm;
    assert_eq!(
        (alarm.peak_m, alarm.limit_m, page.size_m),
        (Some(1.2e-3), Some(1e-3), Some(1.21e-3))
    );
    assert_eq!((alarm.named_s, alarm.named_by_its_end), (Some(alarm.begin_s), Some(false)));
    let progress: Vec<_> = page.revisions.iter().map(|it| it.progress.as_str()).collect();
    assert_eq!(progress, ["opened", "revised", "closed"]);
    assert_eq!(page.warnings.len(), 1);
    assert_eq!(
        (page.warnings[0].detector.as_str(), page.warnings[0].residual_m),
        ("fde1", Some(1.2e-3))
    );
    assert_eq!(bench.reader().incident(id + 1, later(0.0)).expect("read"), None);
}

/// A reload calls them otherwise: what was told before keeps its names.
#[test]
fn events_have_the_names_of_the_configuration_of_their_run() {
    let bench = Bench::new();
    let named = |name: &str| {
        let names = format!(r#"[{{"name":"{name}","c1_name":"LT-1A"}},{{}},{{}},{{}},{{}},{{}}]"#);
        let names = serde_json::from_str(&names).expect("names");
        StorePlan { names, ..bench.plan(8 * MB) }
    };
    let begin = |store| {
        Note::Begin(Some(Box::new(Plan {
            store,
            cause: Cause::Reload,
            at: later(7.0),
            continues: false,
        })))
    };
    let writer = bench.writer_by(named("FwdPort"), false);
    let notes = [Note::Incident(incident(6)), begin(named("Bow")), Note::Incident(incident(12))];
    drop(written(writer, notes));
    let filter = Filter { text: "FwdPort LT".to_owned(), ..Filter::default() };
    let found = bench.reader().search(&filter, later(100.0)).expect("it can be read").entries;
    let texts: Vec<&str> = found.iter().map(|it| it.text.as_str()).collect();
    let what = "yellow: step of 1.21 mm, R1 up to 1.20 mm (limit 1.00 mm)";
    assert_eq!(texts, [format!("cylinder 1 (FwdPort), C1 (LT-1A), {what}")]);
    let [newest, _] = bench.texts_and_ids()[..] else { panic!("two incidents") };
    let page = bench.reader().incident(newest, later(100.0)).expect("read").expect("it is there");
    assert_eq!(page.alarm.text, format!("cylinder 1 (Bow), C1 (LT-1A), {what}"));
    assert!(page.advice.ends_with("the magnet of C1 (LT-1A)."), "{}", page.advice);
}

/// What several cylinders have in common is the machine's, and is found by each of them.
#[test]
fn an_incident_of_the_machine_has_no_cylinder_and_is_found_by_those_that_it_concerns() {
    let bench = Bench::new();
    let mut cylinders = Cylinders::NONE;
    (2..6).for_each(|index| cylinders.insert(index));
    let shared = Incident { scope: Scope::Machine(cylinders), ..incident(6) };
    let warned = Note::Warning(tertius_core::alarm::Warning { timestamp: later(6.0), ..warning() });
    drop(written(bench.writer(), [warned, Note::Incident(shared)]));
    let found = |cylinder| {
        let kind = Some(EventKind::Incident);
        let filter = Filter { kind, cylinder, ..Filter::default() };
        bench.reader().search(&filter, later(100.0)).expect("it can be read").entries
    };
    assert_eq!([1, 3, 6].map(|n| found(Some(n)).len()), [0, 1, 1]);
    let [entry] = &found(None)[..] else { panic!("one incident") };
    assert_eq!(entry.cylinder, None);
    let page = bench.reader().incident(entry.id, later(100.0)).expect("read").expect("it is there");
    assert_eq!((page.alarm.cylinder, page.warnings.len()), (None, 1));
    assert!(page.alarm.text.starts_with("machine (cylinders 3 to 6), yellow: step"), "{page:?}");
}

/// The columns that are kept beside the history say what the history says.
#[test]
fn people_s_acts_are_events_and_change_the_alarm_alone() {
    let bench = Bench::new();
    let mut writer = written(bench.writer(), [Note::Incident(incident(1))]);
    let shelve = ActKind::Shelve(later(3600.0));
    assert_eq!(bench.overview().alarms[0].state, "unacknowledged");
    assert_eq!(done(&mut writer, &bench, ActKind::Acknowledge), Ok(()));
    assert_eq!(bench.overview().alarms[0].state, "acknowledged");
    let again = done(&mut writer, &bench, ActKind::Acknowledge);
    assert_eq!(again, Err(ActError::Refused(ActRefusal::Acknowledged)));
    assert_eq!(done(&mut writer, &bench, shelve), Ok(()));
    assert_eq!((bench.overview().alarms[0].state, bench.overview().counts.shelved), ("shelved", 1));
    let mut writer = written(writer, [Note::Incident(closed(1))]);
    assert_eq!(bench.overview().alarms, [], "it is over and acknowledged");
    let refused = done(&mut writer, &bench, shelve);
    assert_eq!(refused, Err(ActError::Refused(ActRefusal::Normal)));
    let (note, mut answered) = act(4711, ActKind::Acknowledge, ["A", ""]);
    let writer = written(writer, [note]);
    assert_eq!(answered.try_recv(), Ok(Err(ActError::Unknown)));
    drop(writer);
    let acts = bench.of_kind(EventKind::Act);
    let id = bench.texts_and_ids()[0];
    assert_eq!(
        acts,
        [
            format!("A. Person shelved incident {id} for 1.0 h: on it"),
            format!("A. Person acknowledged incident {id}: on it"),
        ]
        .map(|it| it.replace("1.0 h", &tertius_report::story::span(Span::from_seconds(3590.0))))
    );
    let page = bench.reader().incident(id, later(0.0)).expect("read").expect("it is there");
    assert_eq!(page.acts.len(), 2);
    assert_eq!(page.alarm.acknowledged_by.as_deref(), Some("A. Person"));
}

#[test]
fn what_stood_when_the_program_died_is_interrupted_and_not_over() {
    let bench = Bench::new();
    let mut writer =
        written(bench.writer(), [Note::Incident(incident(1)), Note::Incident(closed(2))]);
    assert_eq!(done(&mut writer, &bench, ActKind::Acknowledge), Ok(()));
    // Killed: no end. The next monitor counts anew.
    drop(writer);
    drop(written(bench.writer(), [Note::Incident(incident(1))]));
    let overview = bench.overview();
    let states: Vec<_> = overview.alarms.iter().map(|it| it.state).collect();
    assert_eq!(states, ["unacknowledged", "interrupted_unacknowledged"]);
    assert_eq!(overview.alarms[1].ending.as_deref(), Some("interrupted"));
    assert_eq!(overview.alarms[1].end_s, None);
    let starts = bench.of_kind(EventKind::Start);
    assert!(starts[0].contains("ended without a word, last seen"), "{starts:?}");
    assert!(starts[1].ends_with("configuration 0123456789abcdef"), "{starts:?}");
}

#[test]
fn a_monitor_that_was_taken_up_goes_on_with_its_incidents() {
    let bench = Bench::new();
    drop(written(bench.writer(), [Note::Incident(incident(1)), Note::Incident(incident(2))]));
    let writer = bench.writer_by(bench.plan(8 * MB), true);
    drop(written(writer, [Note::Incident(closed(1))]));
    let states: Vec<_> = bench.overview().alarms.iter().map(|it| it.state).collect();
    assert_eq!(states, ["unacknowledged", "returned_unacknowledged"]);
    // Also where nobody said so in time.
    drop(written(bench.writer(), [Note::Incident(closed(2))]));
    let states: Vec<_> = bench.overview().alarms.iter().map(|it| it.state).collect();
    assert_eq!(states, ["returned_unacknowledged"; 2]);
}

#[test]
fn a_search_finds_by_words_and_facts_page_by_page() {
    let bench = Bench::new();
    let mut notes: Vec<Note> = (1..=30).map(|number| Note::Incident(closed(number))).collect();
    let worse = Incident { level: Level::Black, ..closed(31) };
    notes.push(Note::Incident(worse));
    let at = later(50.0);
    let text = "can0: the interface is down".to_owned();
    let event = Event { kind: EventKind::BusLost, at, cylinder: None, text };
    notes.push(Note::Event(Box::new(event)));
    drop(written(bench.writer(), notes));
    let count = |filter: Filter| bench.texts(&filter).len();
    let text = |text: &str| Filter { text: text.to_owned(), ..Filter::default() };
    assert_eq!(count(Filter::default()), 33);
    assert_eq!(count(text("STEP cyl")), 31);
    assert_eq!(count(text("interf down")), 1);
    assert_eq!(count(text("step down")), 0);
    assert_eq!(count(Filter { cylinder: Some(2), ..Filter::default() }), 6);
    assert_eq!(count(Filter { level: Some(Level::Red), ..Filter::default() }), 1);
    assert_eq!(count(Filter { kind: Some(EventKind::BusLost), ..Filter::default() }), 1);
    let range = Filter { from: Some(later(10.0)), to: Some(later(12.0)), ..Filter::default() };
    assert_eq!(count(range), 2);
    let (mut page, mut ids) = (Filter { limit: 10, ..text("step") }, Vec::new());
    loop {
        let found = bench.reader().search(&page, later(0.0)).expect("it can be read");
        ids.extend(found.entries.iter().map(|entry| entry.id));
        page.before = found.next;
        if found.next.is_none() {
            break;
        }
    }
    assert_eq!(ids.len(), 31);
    assert!(ids.is_sorted_by(|a, b| a > b), "each once, the newest first");
}

#[test]
fn news_are_in_the_order_of_writing_and_go_with_their_events() {
    let bench = Bench::new();
    let mut writer = bench.writer();
    writer.take(Note::Incident(incident(1)));
    let text = "no answer".to_owned();
    let event = Event { kind: EventKind::BusLost, at: BEGIN, cylinder: None, text };
    writer.take(Note::Event(Box::new(event)));
    writer.take(Note::Incident(closed(1)));
    writer.write();
    let news = |after| bench.reader().news(|_| after, 100).expect("it can be read");
    let all = news(0);
    let told = all.iter().map(|it| (it.number, it.kind.as_str(), it.progress.as_deref()));
    let expected = [
        (1, "start", None),
        (2, "incident", Some("opened")),
        (3, "bus_lost", None),
        (4, "incident", Some("closed")),
    ];
    assert_eq!(told.collect::<Vec<_>>(), expected);
    assert_eq!((all[1].id, &all[1].store), (all[3].id, &all[0].store));
    assert_eq!(news(3), all[3..]);
    // What gives way is no news any more, and its number is not given again.
    let other = rusqlite::Connection::open(bench.path()).expect("it was written");
    other.execute_batch("DELETE FROM events WHERE kind <> 'incident'").expect("it is ours");
    let left: Vec<i64> = news(0).iter().map(|it| it.number).collect();
    assert_eq!(left, [2, 4]);
    writer.take(Note::Incident(incident(2)));
    writer.write();
    assert_eq!(news(4)[0].number, 5);
}
