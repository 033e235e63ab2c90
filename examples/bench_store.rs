//! Fills an event store with incidents and says how long its questions take. `scripts/bench-store` runs it.
//!
//!     cargo run --example bench_store -- [INCIDENTS [MEGABYTES]]

use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tertius::alarm::detector::{PLACES, WarningPlace};
use tertius::alarm::{Detector, Finding, Level, State, Warning};
use tertius::alarm_list::ActKind;
use tertius::appliance::store::{
    AlarmAct, Cause, Clerk, EventKind, ExportFormat, Filter, StorePlan, StoreReader, export,
};
use tertius::appliance::telemetry::Recorder;
use tertius::appliance::telemetry::clock::SystemClock;
use tertius::blame::Rule;
use tertius::config::MachineNames;
use tertius::incident::{Ending, Excursion, Incident, Outset, Part, Progress, Scope};
use tertius::monitor::Record;
use tertius::sample::Quality;
use tertius::time::{Span, Timestamp};
use tertius::verdict::{Fault, Suspect};

const BEGIN: Timestamp = Timestamp::from_nanos(1_700_000_000_000_000_000);

/// Seconds from incident to incident: a hundred thousand of them are in eleven years.
const APART: f64 = 3600.0;

const ROUNDS: usize = 15;

const FAULTS: [Fault; 8] = [
    Fault::Abrupt,
    Fault::Noise,
    Fault::Incipient,
    Fault::OutOfRange,
    Fault::BrokenWire,
    Fault::Frozen,
    Fault::Stale,
    Fault::Unclassified,
];
const SUSPECTS: [Suspect; 4] = [Suspect::C1, Suspect::C2, Suspect::Undecided, Suspect::Process];
const LEVELS: [Level; 4] = [Level::Yellow, Level::Orange, Level::Red, Level::Black];

fn incident(number: u32) -> Incident {
    let begin = BEGIN.after(Span::from_seconds(APART * f64::from(number)));
    let of = number as usize;
    // Black ones are rare.
    let level = LEVELS[if number.is_multiple_of(1000) { 3 } else { of % 3 }];
    let (fault, suspect) = (FAULTS[of / 3 % 8], SUSPECTS[of / 7 % 4]);
    let value = 1e-3 + 1e-6 * f64::from(number % 9973);
    let finding = Finding {
        fault,
        suspect,
        rule: Rule::OneObserver,
        level,
        residual: Some(value),
        threshold: Some(1e-3),
        evidence: None,
        device: None,
    };
    let mut parts = [None; PLACES];
    let part = Part { raised: begin, raises: 1, stands: true, finding, has_cleared: false };
    parts[WarningPlace::Fde1 as usize] = Some(part);
    Incident {
        number,
        scope: Scope::Cylinder(1 + (number % 6) as u8),
        progress: Progress::Opened,
        timestamp: begin,
        begin,
        onset: begin,
        end: None,
        suspect,
        named: None,
        fault,
        gain: None,
        size: Some(value),
        parted: None,
        level,
        parts,
        peaks: [Some(Excursion { value, at: begin }), None, None, None],
        now: [None; 4],
        outset: Outset::default(),
        limits: [1e-3, 1e-3, 1.5e-3, 0.05],
    }
}

fn warning(incident: &Incident, state: State) -> Warning {
    Warning {
        timestamp: incident.timestamp,
        cylinder: incident.scope.cylinder().expect("it is of a cylinder"),
        detector: Detector::Fde1,
        place: WarningPlace::Fde1 as usize,
        state,
        finding: incident.parts[WarningPlace::Fde1 as usize].expect("it was made").finding,
    }
}

/// Tells of the incidents as a gateway does, in blocks that are on the disk before the next begins.
fn fill(clerk: &mut Clerk, count: u32) -> Result<(), Box<dyn Error>> {
    let handle = clerk.handle();
    for number in 1..=count {
        let opened = incident(number);
        let end = opened.begin.after(Span::from_seconds(20.0));
        let closed = Incident {
            progress: Progress::Closed,
            timestamp: end,
            end: Some((end, Ending::Returned)),
            ..opened
        };
        clerk.warning(&warning(&opened, State::Raised));
        clerk.incident(&opened);
        clerk.warning(&warning(&closed, State::Cleared));
        // The newest ones stand.
        if number + 12 <= count {
            clerk.incident(&closed);
        }
        clerk.turned();
        if number.is_multiple_of(80) || number == count {
            // An act is answered when everything before it is on the disk; this one means nothing.
            let act = AlarmAct::new(i64::MAX, ActKind::Acknowledge, end, ["bench", ""])?;
            _ = handle.act(act)?.blocking_recv()?;
        }
    }
    Ok(())
}

/// What a cycle of a cylinder costs the data path, ns: the statistics of the hour.
fn cost(clerk: &mut Clerk) -> f64 {
    const CYCLES: u32 = 1_000_000;
    let mut record = Record {
        timestamp: BEGIN,
        cylinder: 1,
        c1: Some(0.1),
        c2: Some(0.1),
        qualities: [Quality::Good; 2],
        residuals: [Some(1e-5), Some(-1e-5), Some(2e-5)],
        judged: [true; 2],
        monitored: true,
        ..Record::default()
    };
    let started = Instant::now();
    for cycle in 0..CYCLES {
        record.timestamp = record.timestamp.after(Span::from_nanos(3_333_333));
        record.cylinder = 1 + (cycle % 6) as u8;
        clerk.record(std::hint::black_box(&record));
        clerk.turned();
    }
    started.elapsed().as_secs_f64() * 1e9 / f64::from(CYCLES)
}

/// Median and longest of some rounds, ms, each with a connection of its own.
fn timed(path: &Path, ask: impl Fn(&StoreReader) -> usize) -> Result<String, Box<dyn Error>> {
    let (mut times, mut found) = (Vec::new(), 0);
    for _ in 0..ROUNDS {
        let started = Instant::now();
        found = ask(&StoreReader::open(path)?);
        times.push(started.elapsed());
    }
    times.sort();
    let ms = |time: Duration| 1e3 * time.as_secs_f64();
    let (median, most) = (ms(times[ROUNDS / 2]), ms(times[ROUNDS - 1]));
    Ok(format!("{median:8.1} ms, at most {most:8.1} ms, {found} rows"))
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let count: u32 = arguments.next().map_or(Ok(100_000), |it| it.parse())?;
    let megabytes: u64 = arguments.next().map_or(Ok(256), |it| it.parse())?;
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("bench.events");
    let recorder = Recorder::new(Arc::new(SystemClock::new()));
    let mut clerk = Clerk::new(recorder.telemetry());
    let plan = StorePlan {
        path: path.clone(),
        size: megabytes * 1_000_000,
        days: 36_500,
        machine: "a machine".to_owned(),
        names: MachineNames::default(),
        configuration: "0123456789abcdef".to_owned(),
        sample_time: 0.02,
    };
    clerk.begin(Some(plan), Cause::Start, false);
    println!("a cycle of a cylinder: {:.0} ns", cost(&mut clerk));
    let started = Instant::now();
    fill(&mut clerk, count)?;
    let seconds = started.elapsed().as_secs_f64();
    let size = |suffix: &str| {
        let file = folder.path().join(format!("bench.events{suffix}"));
        std::fs::metadata(file).map_or(0.0, |found| found.len() as f64 / 1e6)
    };
    println!("{count} incidents in {seconds:.1} s");
    println!("file {:.1} MB, log {:.1} MB, of {megabytes} MB", size(""), size("-wal"));
    let now = incident(count).begin;
    let overview = |reader: &StoreReader| {
        let overview = reader.overview(now, false).expect("it can be read");
        overview.counts.returned as usize
    };
    println!("overview                     {}", timed(&path, overview)?);
    let text = |text: &str| Filter { text: text.to_owned(), limit: 100, ..Filter::default() };
    let middle = incident(count / 2).begin;
    for (name, filter) in [
        ("newest                      ", text("")),
        ("common words                ", text("cylinder error")),
        ("words and cylinder          ", Filter { cylinder: Some(5), ..text("frozen c2") }),
        ("beginning of a common word  ", text("c")),
        ("rare level                  ", Filter { level: Some(Level::Black), ..text("") }),
        ("nothing fits                ", text("cylinder zebra")),
        ("facts that exclude another  ", Filter { kind: Some(EventKind::Act), ..text("cylinder") }),
        ("the first half              ", Filter { to: Some(middle), ..text("") }),
        ("words in the first half     ", Filter { to: Some(middle), ..text("step c1") }),
    ] {
        let ask = |reader: &StoreReader| {
            reader.search(&filter, now).expect("it can be read").entries.len()
        };
        println!("{name} {}", timed(&path, ask)?);
    }
    let started = Instant::now();
    let mut csv = Vec::new();
    export(
        &StoreReader::open(&path)?,
        &text(""),
        ExportFormat::Csv,
        &MachineNames::default(),
        now,
        &mut csv,
    )?;
    let lines = csv.iter().filter(|byte| **byte == b'\n').count();
    println!("CSV of everything: {lines} lines in {:.1} s", started.elapsed().as_secs_f64());
    clerk.finish();
    Ok(())
}
