//! `replay --parquet`: the tables have what the lines of JSON have, each where it belongs, and take nobody's place.

use crate::names::named;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use serde_json::value::RawValue;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use tertius::config::{self, design};
use tertius::dbc::{Database, text};
use tertius::monitor::{Monitor, Sink};
use tertius::report::columns::{TABLES, column_descriptions, meaning_key, unit_key};
use tertius::sequential::Dwell;
use tertius_testing::process::{read, write};
use tertius_testing::program;
use tertius_testing::support::{E_TYPE, Run, Scratch, between, recorded, replay, tertius, top};
use tertius_testing::visits::{CONFIG, visits};

const SEQUENTIAL: &str = "tests/recordings/e-type-sequential.toml";
const TWO_BUSES: &str = "config/e-type-two-buses.toml";
const FAULTS: &str = "tests/recordings/e-type-faults.log.zst";

/// A row, or a line, its values as JSON writes them; nulls are left out.
type Row = BTreeMap<String, String>;

/// The files of a table below `folder`, in the order of their paths.
fn files(folder: &str, table: &str) -> Vec<PathBuf> {
    let (mut found, mut folders) = (Vec::new(), vec![Path::new(folder).join(table)]);
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).expect("a folder") {
            let path = entry.expect("an entry").path();
            let kind = if path.is_dir() { &mut folders } else { &mut found };
            kind.push(path);
        }
    }
    found.sort();
    found
}

/// The rows of a table below `folder`.
fn rows(folder: &str, table: &str) -> Vec<Row> {
    let rows_of = |path: PathBuf| {
        let file =
            SerializedFileReader::new(File::open(path).expect("it is there")).expect("Parquet");
        let rows = file.get_row_iter(None).expect("rows");
        rows.map(|row| cells(row.expect("a row").get_column_iter())).collect::<Vec<_>>()
    };
    files(folder, table).into_iter().flat_map(rows_of).collect()
}

fn cells<'a>(columns: impl Iterator<Item = (&'a String, &'a Field)>) -> Row {
    let cell = |(name, field): (&String, &Field)| {
        let text = match field {
            Field::Null => return None,
            Field::Bool(truth) => truth.to_string(),
            Field::Long(number) => number.to_string(),
            Field::Double(number) => serde_json::to_string(number).expect("a number"),
            Field::Str(text) => serde_json::to_string(text).expect("a text"),
            other => panic!("{name} is {other:?}"),
        };
        Some((name.clone(), text))
    };
    columns.filter_map(cell).collect()
}

/// The lines of JSON of one type, their numbers as they are written.
fn lines(run: &Run, kind: &str) -> Vec<Row> {
    let fields = |line: &str| -> Row {
        let fields: BTreeMap<String, Box<RawValue>> = serde_json::from_str(line).expect("JSON");
        let known = fields.into_iter().filter(|(_, value)| value.get() != "null");
        known.map(|(name, value)| (name, value.get().to_owned())).collect()
    };
    let of_kind = |line: &Row| line["type"] == format!("\"{kind}\"");
    run.stdout.lines().map(fields).filter(of_kind).collect()
}

/// The objects of a list, their values as they are written.
fn raw_list(list: &str) -> Vec<Row> {
    let list: Vec<BTreeMap<String, Box<RawValue>>> = serde_json::from_str(list).expect("a list");
    let row = |fields: BTreeMap<String, Box<RawValue>>| {
        fields.into_iter().map(|(name, value)| (name, value.get().to_owned())).collect()
    };
    list.into_iter().map(row).collect()
}

/// Seconds with all their digits as nanoseconds.
fn nanos(seconds: &str) -> String {
    let (whole, fraction) = seconds.split_once('.').expect("a point");
    format!("{whole}{fraction:0<9}")
}

/// Replays `log` into the tables `folder`.
fn tabulate(log: &str, config: &str, folder: &str, more: &[&str]) -> Run {
    replay(&[log], config, &[&["--parquet", folder][..], more].concat())
}

/// Compares the fields `same` of rows and lines.
#[track_caller]
fn assert_same(rows: &[Row], lines: &[Row], same: &[&str]) {
    assert_eq!(rows.len(), lines.len());
    for (row, line) in rows.iter().zip(lines) {
        for name in same {
            assert_eq!(row.get(*name), line.get(*name), "{name} of {line:?}");
        }
        assert_eq!(row["timestamp"], nanos(&line["timestamp"]));
    }
}

#[test]
fn tables_have_what_the_lines_have_to_the_bit() {
    let scratch = Scratch::new();
    let folder = scratch.path("columns");
    let run = tabulate(FAULTS, SEQUENTIAL, &folder, &[]).ok();
    let plain = replay(&[FAULTS], SEQUENTIAL, &[]).ok();
    assert!(run.stdout == plain.stdout, "the tables change the lines");

    let (warnings, told) = (rows(&folder, "warnings"), lines(&run, "warning"));
    let fields = [
        "t",
        "cylinder",
        "detector",
        "fault",
        "suspect",
        "level",
        "state",
        "residual",
        "threshold",
        "evidence",
        "location_evidence",
        "size",
        "process_size",
        "shape",
        "gain_percent",
    ];
    assert_same(&warnings, &told, &fields);
    assert!(told.len() > 100 && told.iter().any(|line| line.contains_key("location_evidence")));

    let (incidents, told) = (rows(&folder, "incidents"), lines(&run, "incident"));
    let fields = [
        "t",
        "incident",
        "state",
        "cylinder",
        "level",
        "suspect",
        "fault",
        "shape",
        "gain_percent",
        "ending",
        "size",
        "quantity",
        "peak",
        "limit",
        "now",
        "named_by_its_end",
        "summary",
        "evidence",
    ];
    assert_same(&incidents, &told, &fields);
    // Of the lines it counts from the first frame.
    let number = |text: &str| nanos(text).parse::<i64>().expect("nanoseconds");
    let first = number(&told[0]["timestamp"]) - number(&told[0]["t"]);
    assert_eq!(incidents[0]["begin"], (first + number(&told[0]["begin"])).to_string());

    let summary = run.summary();
    let row = rows(&folder, "summaries").pop().expect("a row");
    for name in
        ["judged", "frames", "cycles", "incidents", "missing_cycles", "duration", "configuration"]
    {
        assert_eq!(row[name], summary[name].to_string(), "{name}");
    }
    for (detector, count) in summary["warnings"].as_object().expect("counts") {
        assert_eq!(row[&format!("warnings_{detector}")], count.to_string());
    }
    let cylinders = rows(&folder, "cylinders");
    let told = raw_list(&lines(&run, "summary")[0]["cylinders"]);
    assert_eq!((cylinders.len(), told.len()), (6, 6));
    for (row, told) in cylinders.iter().zip(told) {
        let names =
            ["samples", "gated", "incomplete", "worst_r1", "worst_r2", "worst_r3", "warnings"];
        names.iter().for_each(|name| assert_eq!(row[*name], told[*name], "{name}"));
        let coverage = &told["sequential"];
        let judged = format!("\"judged_seconds\":{}", row["judged_seconds"]);
        let unknown = format!("\"no_baseline\":{}", row["no_baseline_seconds"]);
        assert!(coverage.contains(&judged) && coverage.contains(&unknown), "{coverage}");
    }
}

#[test]
fn tables_have_the_names_that_the_lines_have() {
    let scratch = Scratch::new();
    let folder = scratch.path("columns");
    let run = tabulate(FAULTS, &named(&scratch), &folder, &[]).ok();
    for (table, kind) in [("warnings", "warning"), ("incidents", "incident"), ("notices", "notice")]
    {
        let rows = rows(&folder, table);
        assert_same(&rows, &lines(&run, kind), &["cylinder", "name", "suspect_name"]);
    }
    let told = raw_list(&lines(&run, "summary")[0]["cylinders"]);
    let cylinders = rows(&folder, "cylinders");
    assert_eq!(cylinders.len(), told.len());
    for (row, told) in cylinders.iter().zip(&told) {
        let names = ["cylinder", "name", "c1_name", "c2_name"];
        names.iter().for_each(|name| assert_eq!(row.get(*name), told.get(*name), "{name}"));
    }
    assert!(told[0].contains_key("name") && !told[5].contains_key("c1_name"));
    let by_number = |number: &str| {
        let told = told.iter().find(|it| it["cylinder"] == number).expect("a cylinder");
        told["name"].clone()
    };
    let minutes = rows(&folder, "minutes");
    assert!(minutes.len() > 6 && minutes.iter().all(|it| it["name"] == by_number(&it["cylinder"])));
}

#[test]
fn a_bus_that_is_silent_is_among_the_notices() {
    let scratch = Scratch::new();
    let (folder, log) = (scratch.path("columns"), scratch.path("both.log"));
    let call = ["simulate", "--config", TWO_BUSES, "--duration", "20", "--output", &log];
    tertius(&call, b"").ok();
    let whole = scratch.read("both.log");
    let begin: f64 = whole[1..18].parse().expect("seconds");
    let silent = |line: &&str| {
        let t = line[1..18].parse::<f64>().expect("seconds") - begin;
        (8.0..10.5).contains(&t) && line.contains(" can1 ") || (14.0..15.0).contains(&t)
    };
    let part: String = whole.split_inclusive('\n').filter(|line| !silent(line)).collect();
    let log = scratch.write("part.log", part);
    let run = tabulate(&log, TWO_BUSES, &folder, &[]).ok();

    let (notices, told) = (rows(&folder, "notices"), lines(&run, "notice"));
    assert_same(
        &notices,
        &told,
        &["t", "notice", "seconds", "bus", "cylinder", "detector", "reason"],
    );
    let named = |name: &str| {
        let of_name = notices.iter().filter(|row| row["notice"] == format!("\"{name}\""));
        let cells = |row: &Row| {
            let cell = |name: &str| row.get(name).cloned().unwrap_or_default();
            [cell("bus"), cell("summary"), row["t"].split_once('.').expect("a point").0.to_owned()]
        };
        of_name.map(cells).collect::<Vec<_>>()
    };
    let second = "\"second\"".to_owned();
    let words = "\"the second bus is silent: what it carries is unknown\"".to_owned();
    assert_eq!(named("silence"), [[second.clone(), words, "8".to_owned()]]);
    let words = "\"the second bus is heard again\"".to_owned();
    assert_eq!(named("heard_again"), [[second, words, "10".to_owned()]]);
    let [[bus, words, _]] = &named("gap")[..] else { panic!("one gap: {notices:?}") };
    assert_eq!((bus.as_str(), words.as_str()), ("", "\"cycles again after 0.98 s without any\""));
}

/// The sum of a column.
fn total(rows: &[Row], column: &str) -> u64 {
    rows.iter().map(|row| row[column].parse::<u64>().expect("a count")).sum()
}

#[test]
fn minutes_are_the_residuals_of_their_cycles() {
    let scratch = Scratch::new();
    let (folder, table) = (scratch.path("columns"), scratch.path("residuals.csv"));
    let log = scratch.write("part.log", between(&recorded("e-type-faults.log.zst"), 50.0, 140.0));
    tabulate(&log, E_TYPE, &folder, &["--residuals", &table]).ok();
    let minutes = rows(&folder, "minutes");
    // From 22:14:10 to 22:15:40 it is two minutes by the clock that begin at 22:14 and 22:15, of six cylinders.
    assert_eq!(minutes.len(), 12);
    let text = scratch.read("residuals.csv");
    let csv: Vec<Vec<&str>> = text.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert_eq!(total(&minutes, "cycles"), csv.len() as u64);
    let gated = csv.iter().filter(|row| row[11] == "1").count() as u64;
    assert_eq!(total(&minutes, "gated"), gated);
    // The second minute of the third cylinder begins 10 s after the first frame.
    let row = minutes.iter().filter(|row| row["cylinder"] == "3").nth(1).expect("a second minute");
    assert_eq!(row["minute"], "1700000100000000000");
    let is_its = |row: &&Vec<&str>| {
        let t: f64 = row[0].parse().expect("seconds");
        row[1] == "3"
            && (1_700_000_050.0 + t) >= 1_700_000_100.0
            && (1_700_000_050.0 + t) < 1_700_000_160.0
    };
    let r3 = csv.iter().filter(is_its).filter_map(|row| row[10].parse::<f64>().ok());
    let r3: Vec<f64> = r3.collect();
    assert!(r3.len() > 1900, "{}", r3.len());
    let number = |column: &str| row[column].parse::<f64>().expect("a number");
    assert_eq!(row["r3_count"], r3.len().to_string());
    assert_eq!(number("r3_min"), r3.iter().copied().fold(f64::INFINITY, f64::min));
    assert_eq!(number("r3_max"), r3.iter().copied().fold(f64::NEG_INFINITY, f64::max));
    let mean = r3.iter().sum::<f64>() / r3.len() as f64;
    let rms = (r3.iter().map(|it| it * it).sum::<f64>() / r3.len() as f64).sqrt();
    assert!((number("r3_mean") - mean).abs() < 1e-15 && (number("r3_rms") - rms).abs() < 1e-15);
    // What was judged has the extremes that the summary has.
    let worst = rows(&folder, "cylinders")[2]["worst_r1"].parse::<f64>().expect("a number");
    let of_third = minutes.iter().filter(|row| row["cylinder"] == "3");
    let extremes = of_third.flat_map(|row| [row.get("r1_min"), row.get("r1_max")]).flatten();
    let sizes = extremes.map(|it| it.parse::<f64>().expect("a number").abs());
    assert_eq!(sizes.fold(0.0, f64::max), worst);
}

/// The lines of `log`, `by` seconds later.
fn later(log: &str, by: u64) -> String {
    let line = |line: &str| {
        let seconds: u64 = line[1..11].parse().expect("seconds");
        format!("({}{}\n", seconds + by, &line[11..])
    };
    log.lines().map(line).collect()
}

#[test]
fn each_day_has_its_own_files_under_the_name_of_the_machine() {
    let scratch = Scratch::new();
    let folder = scratch.path("columns");
    // From 23:59:54 to 00:00:06.
    let log = later(&between(&recorded("e-type-healthy.log.zst"), 30.0, 42.0), 6_364);
    let log = scratch.write("night.log", log);
    let run =
        tabulate(&log, E_TYPE, &folder, &["--machine", "A 1"]).failed(1, &["nothing was judged"]);
    let names = |table| {
        let files = files(&folder, table);
        let below =
            |path: &PathBuf| path.strip_prefix(&folder).expect("below").display().to_string();
        files.iter().map(below).collect::<Vec<_>>()
    };
    let name = "20231114T235954.000210000Z.parquet";
    let days = ["2023-11-14", "2023-11-15"];
    assert_eq!(names("minutes"), days.map(|day| format!("minutes/machine=A%201/day={day}/{name}")));
    // Of what was not found there is a table without rows.
    assert_eq!(names("warnings"), [format!("warnings/machine=A%201/day=2023-11-14/{name}")]);
    assert_eq!(rows(&folder, "warnings"), [] as [Row; 0]);
    let samples = run.summary()["cylinders"][0]["samples"].as_u64().expect("a count");
    assert_eq!(total(&rows(&folder, "minutes"), "cycles"), 6 * samples);

    // Another replay of it replaces what the first one left, also on a day on which it now finds nothing.
    let before = fs::read(files(&folder, "minutes")[0].clone()).expect("it is there");
    let stray = Path::new(&folder).join("minutes/machine=A%201/day=2023-12-01");
    fs::create_dir(&stray).expect("ours");
    fs::copy(&files(&folder, "minutes")[0], stray.join(name)).expect("ours");
    let foreign = stray.join("of-somebody-else.parquet");
    fs::write(&foreign, "PAR1").expect("ours");
    tabulate(&log, E_TYPE, &folder, &["--machine", "A 1"]).failed(1, &["nothing was judged"]);
    assert!(!stray.join(name).exists() && foreign.exists());
    assert!(fs::read(files(&folder, "minutes")[0].clone()).expect("it is there") == before);
}

#[test]
fn what_is_not_ours_stays_and_a_failed_run_leaves_nothing() {
    let scratch = Scratch::new();
    let folder = scratch.path("columns");
    let log = scratch.write("part.log", between(&recorded("e-type-healthy.log.zst"), 30.0, 33.0));
    let name = "minutes/machine=M/day=2023-11-14/20231114T221350.000210000Z.parquet";
    let path = Path::new(&folder).join(name);
    fs::create_dir_all(path.parent().expect("a folder")).expect("ours");
    fs::write(&path, "PAR1 of somebody else PAR1").expect("ours");
    let call =
        |more: &[&str]| tabulate(&log, E_TYPE, &folder, &[&["--machine", "M"], more].concat());
    call(&[]).failed(2, &[name, "this command did not write it", "--force"]);
    assert_eq!(fs::read(&path).expect("it is there"), b"PAR1 of somebody else PAR1");
    let left: Vec<PathBuf> = TABLES
        .iter()
        .filter(|it| Path::new(&folder).join(it).exists())
        .flat_map(|table| files(&folder, table))
        .collect();
    assert_eq!(left, [path]);
    call(&["--force"]).failed(1, &["nothing was judged"]);
    assert_eq!(rows(&folder, "minutes").len(), 6);
    call(&[]).failed(1, &["nothing was judged"]);
    // A recording in the place of a table is an input all the same.
    let inside = scratch.path("other/minutes/machine=M/day=2023-11-14");
    fs::create_dir_all(&inside).expect("ours");
    let inside = format!("{inside}/20231114T221350.000210000Z.parquet");
    fs::copy(&log, &inside).expect("ours");
    let other = ["--machine", "M", "--force"];
    tabulate(&inside, E_TYPE, &scratch.path("other"), &other).failed(2, &["over the input"]);
    // A file is no folder.
    tabulate(&log, E_TYPE, &log, &[]).failed(2, &["cannot be created"]);
}

#[test]
fn recordings_one_by_one_add_up() {
    let scratch = Scratch::new();
    let log = between(&recorded("e-type-faults.log.zst"), 60.0, 100.0);
    let split = log.match_indices('\n').nth(log.lines().count() / 2).expect("a line").0 + 1;
    let whole = scratch.write("whole.log", &log);
    let parts = [scratch.write("1.log", &log[..split]), scratch.write("2.log", &log[split..])];
    let [one, two] = [scratch.path("one"), scratch.path("two")];
    let [a, b] = [scratch.path("a.state"), scratch.path("b.state")];
    tabulate(&whole, SEQUENTIAL, &one, &["--state", &a]).ok();
    for part in &parts {
        tabulate(part, SEQUENTIAL, &two, &["--state", &b]).ok();
    }
    for table in ["warnings", "incidents"] {
        assert_eq!(rows(&one, table), rows(&two, table), "{table}");
    }
    assert!(rows(&one, "warnings").len() > 5);
    for column in ["cycles", "judged_r1", "r3_count"] {
        assert_eq!(total(&rows(&one, "minutes"), column), total(&rows(&two, "minutes"), column));
    }
    assert_eq!(rows(&two, "summaries").len(), 2);
}

/// Hears the dwells of a monitor.
#[derive(Default)]
struct DwellsHeard(Vec<(u8, Dwell)>);

impl Sink for DwellsHeard {
    fn dwell(&mut self, cylinder: u8, dwell: &Dwell) {
        self.0.push((cylinder, *dwell));
    }
}

#[test]
fn dwells_and_trends_are_those_of_the_monitor_and_of_the_summary() {
    let (scratch, path) = (Scratch::new(), "stops.log");
    let (folder, log) = (scratch.path("columns"), scratch.path(path));
    write(Path::new(&log), "can0", &visits(0..12));
    let run = tabulate(&log, CONFIG, &folder, &[]).failed(1, &["nothing was judged"]);
    let loaded = config::load(&top().join(CONFIG)).expect("it ships");
    let database = Database::parse(&text::from_bytes(&loaded.dbc_text)).expect("it is sound");
    let mut monitor = Monitor::new(design::judging(&loaded.settings, &database).expect("they fit"));
    let mut heard = DwellsHeard::default();
    read(Path::new(&log)).iter().for_each(|frame| monitor.take(frame, &mut heard));
    monitor.finish(&mut heard);
    let mut expected: Vec<[String; 4]> = heard
        .0
        .iter()
        .map(|(cylinder, dwell)| {
            let [c1, c2] =
                dwell.readings.each().map(|it| serde_json::to_string(&it).expect("a number"));
            [dwell.at.as_nanos().to_string(), cylinder.to_string(), c1, c2]
        })
        .collect();
    let rows_of = rows(&folder, "dwells");
    let cells = |row: &Row| ["timestamp", "cylinder", "c1", "c2"].map(|name| row[name].clone());
    let mut found: Vec<[String; 4]> = rows_of.iter().map(cells).collect();
    expected.sort();
    found.sort();
    assert_eq!(found, expected);
    assert_eq!((found.len(), files(&folder, "dwells").len()), (72, 12));

    let told = raw_list(&lines(&run, "summary")[0]["trends"]);
    let trends = rows(&folder, "trends");
    assert_eq!((trends.len(), told.len()), (12, 12));
    let mut left = 0;
    for (row, told) in trends.iter().zip(told) {
        for name in [
            "cylinder",
            "transducer",
            "dwells",
            "months",
            "moved_mm",
            "mm_per_month",
            "error_mm_per_month",
        ] {
            assert_eq!(row[name], told[name], "{name}");
        }
        let until = &told["months_until_maintenance"];
        match row.get("maintenance_months") {
            Some(expected) => {
                assert!(until.contains(&format!("\"expected\":{expected}")), "{until}")
            }
            None => assert_eq!(until, "null"),
        }
        left += usize::from(row.contains_key("critical_months_latest"));
    }
    assert_eq!(left, 1, "of the transducer that drifts");
}

#[test]
fn the_metadata_tell_units_and_the_page_tells_every_column() {
    let scratch = Scratch::new();
    let folder = scratch.path("columns");
    let log = scratch.write("part.log", between(&recorded("e-type-healthy.log.zst"), 30.0, 33.0));
    tabulate(&log, E_TYPE, &folder, &[]).failed(1, &["nothing was judged"]);
    let page = fs::read_to_string(top().join("docs/OUTPUTS.md")).expect("it is there");
    for table in TABLES {
        let file = File::open(&files(&folder, table)[0]).expect("it is there");
        let file = SerializedFileReader::new(file).expect("Parquet");
        let pairs = file.metadata().file_metadata().key_value_metadata().expect("metadata");
        let known: BTreeMap<&str, &str> =
            pairs.iter().map(|pair| (&*pair.key, pair.value.as_deref().unwrap_or(""))).collect();
        assert_eq!(known["tertius.table"], table);
        let (_, section) =
            page.split_once(&format!("\n*{table}*")).expect("the page tells the table");
        let section = section.split("\n*").next().expect("a part");
        for column in column_descriptions().iter().filter(|column| column.table == table) {
            assert_eq!(known[&*meaning_key(column.name)], column.meaning);
            assert_eq!(known.get(&*unit_key(column.name)).copied().unwrap_or(""), column.unit);
            let row = format!("| `{}` | {} | {} |", column.name, column.unit, column.meaning);
            let row = row.replace("|  |", "| |");
            assert!(section.contains(&row), "{row} is not in the section of {table}");
        }
    }
}

/// The shell's way: a line for each machine, which does what is not done yet.
#[test]
fn the_shell_commands_of_a_plan_fold_a_machine() {
    let scratch = Scratch::new();
    let log = between(&recorded("e-type-faults.log.zst"), 60.0, 90.0);
    let split = log.match_indices('\n').nth(log.lines().count() / 2).expect("a line").0 + 1;
    let parts = [scratch.write("1.log", &log[..split]), scratch.write("2.log", &log[split..])];
    let config = top().join(SEQUENTIAL).display().to_string();
    let entry =
        format!("[[machine]]\nname = \"A 1\"\nconfig = {config:?}\nrecordings = [\"?.log\"]\n");
    let fleet = scratch.write("fleet.toml", entry);
    let plan = tertius(&["fleet", "plan", &fleet, "--format", "shell"], b"").ok();
    let output = scratch.path("results");
    let fold = || {
        let mut shell = Command::new("bash");
        shell.args(["-c", &plan.stdout]).current_dir(top());
        let ran = shell.env("OUTPUT", &output).env("TERTIUS", program()).output().expect("bash");
        assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
        ["1", "2"]
            .map(|n| fs::read(format!("{output}/folded/A 1/00000{n}.jsonl")).expect("it is done"))
    };
    let first = fold();
    // The same again does nothing; what is half done is done anew.
    let done = format!("{output}/folded/A 1/000002.jsonl");
    fs::write(&done, "marked").expect("ours");
    assert_eq!(fold()[1], b"marked");
    let state = scratch.path("by-hand.state");
    for (part, lines) in parts.iter().zip(first) {
        let run = replay(&[part], SEQUENTIAL, &["--state", &state]).ok();
        assert_eq!(run.stdout.as_bytes(), lines);
    }
}
