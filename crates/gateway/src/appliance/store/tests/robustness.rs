//! What the store does with what befalls its file.

use super::super::export::{ExportFormat, export};
use super::super::hours::{Moments, Part};
use super::super::retention::{Aging, Limits, step};
use super::*;
use rusqlite::Connection;
use std::path::Path;

#[test]
fn a_locked_database_is_written_when_it_is_free_again() {
    let bench = Bench::new();
    let writer = written(bench.writer(), []);
    let other = Connection::open(bench.path()).expect("it is there");
    other.execute_batch("BEGIN IMMEDIATE").expect("it is free");
    let mut writer = written(writer, [Note::Incident(incident(1))]);
    assert_eq!(bench.trouble().as_deref(), Some("another process has locked it"));
    let (note, mut answered) = act(1, ActKind::Acknowledge, ["A", ""]);
    writer.take(note);
    writer.write();
    assert!(matches!(answered.try_recv(), Ok(Err(ActError::Unavailable(_)))), "told at once");
    (0..5000).for_each(|_| _ = writer.take(Note::Warning(warning())));
    other.execute_batch("COMMIT").expect("it is ours");
    writer.write();
    assert_eq!(bench.trouble(), None);
    assert_eq!(bench.overview().counts.unacknowledged, 1);
    let lost = bench.of_kind(EventKind::Lost);
    assert_eq!(lost, ["2953 warnings or events were not stored: too many came at once"]);
}

#[test]
fn only_one_gateway_writes_it() {
    let bench = Bench::new();
    let _first = written(bench.writer(), [Note::Incident(incident(1))]);
    let _second = written(bench.writer(), []);
    let told = bench.trouble().expect("it is taken");
    assert!(told.starts_with("another gateway keeps its events there"), "{told}");
    assert_eq!(bench.overview().counts.unacknowledged, 1, "nothing was interrupted");
}

#[test]
fn a_damaged_file_is_set_aside_and_another_begun() {
    let bench = Bench::new();
    fs::write(bench.path(), "nothing that a database begins with").expect("the folder is ours");
    let mut writer = written(bench.writer(), [Note::Incident(incident(1))]);
    writer.write();
    assert_eq!(bench.trouble(), None);
    assert_eq!(bench.overview().counts.unacknowledged, 1, "nothing is missing");
    assert_eq!(bench.files(), ["kept.events", "kept.events.aside-1", "kept.events.lock"]);
    // Damage that comes while it is open.
    let size = fs::metadata(bench.path()).expect("it is there").len();
    let mut writer = written(writer, [Note::Incident(incident(2))]);
    let other = Connection::open(bench.path()).expect("it is there");
    other.query_row("PRAGMA wal_checkpoint(TRUNCATE)", [], |_| Ok(())).expect("it is free");
    drop(other);
    overwrite(&bench.path(), size.min(4096), 40);
    writer.take(Note::Incident(incident(3)));
    writer.write();
    writer.write();
    assert_eq!(bench.trouble(), None);
    assert_eq!(bench.overview().alarms.len(), 1, "what was not written yet");
    assert!(bench.files().contains(&"kept.events.aside-2".to_owned()));
}

/// Damages all pages of the file but for the first.
fn overwrite(path: &Path, from: u64, pages: usize) {
    use std::os::unix::fs::FileExt;
    let file = fs::OpenOptions::new().write(true).open(path).expect("it is there");
    file.write_all_at(&vec![0xA5; pages * 4096], from).expect("there is room");
}

#[test]
fn a_newer_store_and_a_foreign_database_are_left_alone() {
    let bench = Bench::new();
    drop(written(bench.writer(), [Note::Incident(incident(1))]));
    let newer = Connection::open(bench.path()).expect("it is there");
    newer.execute_batch("PRAGMA user_version = 99").expect("it is free");
    drop(newer);
    let before = fs::read(bench.path()).expect("it is there");
    drop(written(bench.writer(), [Note::Incident(incident(2))]));
    let told = bench.trouble().expect("it is refused");
    assert!(told.starts_with("it is of version 99"), "{told}");
    assert_eq!(fs::read(bench.path()).expect("it is there"), before);
    assert_eq!(bench.files(), ["kept.events", "kept.events.lock"]);
    assert!(StoreReader::open(&bench.path()).is_err());
}

#[test]
fn a_folder_that_comes_later_is_written_then() {
    let bench = Bench::new();
    let folder = bench.folder.path().join("later");
    let plan = StorePlan { path: folder.join("kept.events"), ..bench.plan(8 * MB) };
    let writer = written(bench.writer_by(plan, false), [Note::Incident(incident(1))]);
    assert!(bench.trouble().expect("there is no folder").contains("later/kept.events"));
    fs::create_dir(&folder).expect("the folder is ours");
    drop(written(writer, [Note::Incident(closed(2))]));
    assert_eq!(bench.trouble(), None);
    let reader = StoreReader::open(&folder.join("kept.events")).expect("it was written");
    assert_eq!(reader.overview(BEGIN, false).expect("read").alarms.len(), 2);
}

#[test]
fn a_full_store_loses_the_oldest_and_stays_within_its_size() {
    let bench = Bench::new();
    let mut writer =
        written(bench.writer_by(bench.plan(4 * MB), false), [Note::Incident(incident(1))]);
    for block in 0..40_u32 {
        for number in 2..=200 {
            writer.take(Note::Incident(closed(block * 200 + number)));
        }
        // What does not fit in makes room; the next attempt fits.
        (0..3).for_each(|_| writer.write());
        let size = fs::metadata(bench.path()).expect("it is there").len();
        assert!(size <= 4 * MB, "{size} in block {block}");
    }
    assert!(bench.texts_and_ids().len() > 100, "it goes on, although nobody tidies");
    (0..20).for_each(|_| writer.tidy());
    writer.take(Note::Incident(closed(9000)));
    writer.write();
    assert_eq!(bench.trouble(), None);
    let ids = bench.texts_and_ids();
    assert_eq!(ids.len(), 500, "there are many");
    let overview = bench.overview();
    assert_eq!(
        (overview.counts.unacknowledged, overview.alarms[0].begin_s),
        (1, later(1.0).as_seconds()),
        "what is open stays, however old"
    );
    let oldest = bench.reader().incident(4, BEGIN).expect("read");
    assert_eq!(oldest, None, "the oldest closed ones went");
}

#[test]
fn what_is_too_old_gives_way_but_for_what_is_open_and_the_hours() {
    let bench = Bench::new();
    let moments = Moments { count: 2, mean: 1e-4, squares: 0.0, least: 1e-4, most: 1e-4 };
    let (hour, sample_time) = (1_699_999_200, 0.02);
    let part = Part { hour, cylinder: 2, moments: [moments; 3], sample_time };
    let notes = [incident(1), closed(2), closed(3)].map(Note::Incident);
    let notes = notes.into_iter().chain([Note::Hour(part), Note::Hour(part)]);
    drop(written(bench.writer(), notes));
    let mut database = Connection::open(bench.path()).expect("it is there");
    let limits = Limits { size: 8 * MB, days: 10 };
    let (mut aging, day) = (Aging::default(), 86_400.0);
    // Two looks, since a clock that leaps ahead ages nothing.
    for now in [9.9 * day, 9.9 * day + 3600.0] {
        step(&mut database, limits, &mut aging, later(now)).expect("it is free");
    }
    assert_eq!(bench.texts_and_ids().len(), 3);
    step(&mut database, limits, &mut aging, later(10.1 * day)).expect("it is free");
    assert_eq!(bench.texts_and_ids().len(), 3, "nothing ages faster than the gateway runs");
    let mut aging = Aging::default();
    for now in [10.1 * day, 10.2 * day] {
        step(&mut database, limits, &mut aging, later(now)).expect("it is free");
    }
    assert_eq!(bench.texts_and_ids().len(), 1);
    assert_eq!(bench.overview().counts.unacknowledged, 1, "what is open stays");
    let of_hour = |seconds| Timestamp::from_nanos(seconds * 1_000_000_000);
    let hours = bench.reader().hours(2, of_hour(hour), of_hour(hour + 1)).expect("read");
    assert_eq!((hours.len(), hours[0].count, hours[0].judged_s), (3, 4, 0.08));
}

#[test]
fn a_clock_that_is_set_back_changes_the_times_and_no_order() {
    let bench = Bench::new();
    let back = Span::from_seconds(-86_400.0);
    let mut early = closed(2);
    (early.begin, early.timestamp) = (early.begin.after(back), early.timestamp.after(back));
    drop(written(bench.writer(), [Note::Incident(closed(1)), Note::Incident(early)]));
    let found = bench.reader().search(&Filter::default(), later(0.0)).expect("read");
    let times: Vec<f64> =
        found.entries.iter().map(|it| it.at_s.since(BEGIN).as_seconds()).collect();
    assert_eq!(times, [2.0 - 86_400.0, 1.0, 0.0], "as they came, the newest first");
    let range = Filter { to: Some(later(-3600.0)), ..Filter::default() };
    assert_eq!(bench.texts(&range).len(), 1);
}

/// The rows that version 1 has written; nobody changes this file.
#[test]
fn a_store_of_version_1_is_read_and_goes_on() {
    let bench = Bench::new();
    let old = Connection::open(bench.path()).expect("the folder is ours");
    old.execute_batch(include_str!("../fixtures/v1.sql")).expect("it is SQL");
    drop(old);
    drop(written(bench.writer(), [Note::Incident(incident(7))]));
    let fresh = Bench::new();
    drop(written(fresh.writer(), []));
    assert_eq!(schema(&bench.path()), schema(&fresh.path()), "old or new, it is the same");
    let found = bench.texts(&Filter { text: "frozen".to_owned(), ..Filter::default() });
    assert_eq!(found, ["cylinder 4, C2, orange: frozen reading"]);
    let page = bench.reader().incident(2, BEGIN).expect("read").expect("it is there");
    assert_eq!(page.alarm.acknowledged_by.as_deref(), Some("A. Person"));
    assert_eq!((page.revisions.len(), page.warnings.len(), page.acts.len()), (2, 1, 1));
    assert_eq!(bench.reader().stops(4).expect("read").len(), 1);
    let hours = bench.reader().hours(4, Timestamp::default(), BEGIN).expect("read");
    assert_eq!((hours[0].count, hours[0].unknown_s), (90_000, 1800.0));
}

fn schema(path: &Path) -> Vec<String> {
    let database = Connection::open(path).expect("it is there");
    let mut query = database
        .prepare("SELECT name || ': ' || coalesce(sql, '') FROM sqlite_schema ORDER BY name")
        .expect("it is SQL");
    let rows = query.query_map([], |row| row.get(0)).expect("it can be read");
    rows.collect::<rusqlite::Result<_>>().expect("it can be read")
}

#[test]
fn one_bad_byte_costs_a_character_and_not_the_list() {
    let bench = Bench::new();
    drop(written(bench.writer(), [incident(1), closed(2), closed(3)].map(Note::Incident)));
    let database = Connection::open(bench.path()).expect("it is there");
    let bad = "UPDATE events SET text = CAST(X'61FF62' AS TEXT), suspect = CAST(X'FE' AS TEXT) WHERE id = 3;
         UPDATE incidents SET fault = CAST(X'C328' AS TEXT), advice = CAST(X'FF' AS TEXT) WHERE id = 3;
         UPDATE revisions SET text = CAST(X'80' AS TEXT) WHERE incident = 3;
         UPDATE runs SET machine = CAST(X'FF' AS TEXT);";
    database.execute_batch(bad).expect("it is free");
    drop(database);
    let found = bench.reader().search(&Filter::default(), later(100.0)).expect("read");
    assert_eq!((found.entries.len(), found.damaged), (4, 1));
    assert_eq!(found.entries[1].text, "a\u{fffd}b");
    let page = bench.reader().incident(3, BEGIN).expect("read").expect("it is there");
    assert_eq!((page.advice.as_str(), page.revisions[0].text.as_str()), ("\u{fffd}", "\u{fffd}"));
    assert_eq!(bench.overview().run.expect("it ran").machine, "\u{fffd}");
    assert_eq!(bench.reader().news(|_| 0, 100).expect("read").len(), 4);
    let mut csv = Vec::new();
    let all = Filter::default();
    let damaged = export(
        &bench.reader(),
        &all,
        ExportFormat::Csv,
        &MachineNames::default(),
        later(100.0),
        &mut csv,
    );
    assert_eq!(damaged.expect("read"), 1);
}

/// What is on a page that nothing needs at the start is found all the same.
#[test]
fn damage_anywhere_is_found_when_the_file_is_opened() {
    let bench = Bench::new();
    let notes = (1..=300).map(|number| Note::Incident(closed(number)));
    drop(written(bench.writer(), notes));
    let whole = fs::read(bench.path()).expect("it is there");
    let (page, pages) = (4096, whole.len() / 4096);
    assert!(pages > 40, "{pages}");
    for number in (1..pages).step_by(7) {
        let mut damaged = whole.clone();
        damaged[number * page..(number + 1) * page].fill(0xA5);
        let aside = bench.folder.path().join("kept.events.aside-1");
        _ = fs::remove_file(&aside);
        fs::write(bench.path(), &damaged).expect("the folder is ours");
        let mut writer = written(bench.writer(), [Note::Incident(incident(1))]);
        writer.write();
        assert_eq!(bench.trouble(), None, "page {number}");
        assert!(
            fs::read(&aside).is_ok_and(|kept| kept == damaged),
            "page {number} is not set aside"
        );
        assert_eq!(bench.overview().alarms.len(), 1, "another one was begun");
    }
}

#[test]
fn what_cannot_be_written_at_the_end_is_told() {
    let bench = Bench::new();
    let plan = StorePlan { path: bench.folder.path().join("no/kept.events"), ..bench.plan(8 * MB) };
    let log = Log::default();
    let told = tracing_subscriber::fmt().with_writer(log.clone()).with_ansi(false).finish();
    tracing::subscriber::with_default(told, || {
        let writer = bench.writer_by(plan, false);
        let notes = [incident(1), incident(2), incident(3)].map(Note::Incident);
        written(writer, notes).give_up();
    });
    let told = String::from_utf8(log.0.lock().expect("ours").clone()).expect("text");
    assert!(told.contains("3 notes are lost: the gateway stops"), "{told}");
    assert!(told.contains("no/kept.events"), "{told}");
}

/// What a log writes.
#[derive(Clone, Default)]
struct Log(std::sync::Arc<std::sync::Mutex<Vec<u8>>>);

impl std::io::Write for Log {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().expect("ours").extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl tracing_subscriber::fmt::MakeWriter<'_> for Log {
    type Writer = Self;

    fn make_writer(&self) -> Self {
        self.clone()
    }
}
