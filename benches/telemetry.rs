//! What the telemetry and the flight recorder cost the data path: the same frames through the same
//! gateway without and with them, in turn, in one run.
//!
//!     cargo bench --bench telemetry

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tertius::alarm::{OwnFrame, Warning};
use tertius::appliance::flight::{FlightPlan, FlightRecorder};
use tertius::appliance::telemetry::Recorder;
use tertius::appliance::telemetry::clock::SystemClock;
use tertius::bus::{Port, PortCounts, PortError, Received, Sent, Stamps};
use tertius::config::{self, design};
use tertius::dbc::Database;
use tertius::frame::{Buses, Frame};
use tertius::live::gateway::{Journal, Silent};
use tertius::monitor::{Estimates, Monitor, Record};
use tertius::time::{Span, Timestamp};
use tertius_testing::machine::{Cycle, gateway_of, monitor};

/// As many as the recorder has blocks for, since no worker keeps up with frames that come without a pause.
const CYCLES: i64 = 1_500;
const ROUNDS: usize = 101;

/// Gives frames, so many at a time, and takes everything.
struct Tape<'a> {
    frames: &'a [Frame],
    batch: usize,
    counts: PortCounts,
}

impl Port for Tape<'_> {
    fn receive(
        &mut self,
        _: Duration,
        take: &mut dyn FnMut(&Frame),
    ) -> Result<Received, PortError> {
        let (now, later) = self.frames.split_at(self.batch.min(self.frames.len()));
        self.frames = later;
        now.iter().for_each(take);
        self.counts.received += now.len() as u64;
        let drained_at: Option<Timestamp> = now.last().map(|frame| frame.timestamp);
        Ok(Received { frames: now.len(), drained_at, lost: Buses::NONE })
    }

    fn send(&mut self, _: &OwnFrame) -> Result<Sent, PortError> {
        Ok(Sent::Taken)
    }

    fn counts(&self) -> PortCounts {
        self.counts
    }

    fn stamps(&self) -> Stamps {
        Stamps::Embedded
    }

    fn description(&self) -> String {
        String::new()
    }
}

struct Told(Recorder, Option<FlightRecorder>);

impl Journal for Told {
    fn frame(&mut self, frame: &Frame) {
        if let Some(flight) = &mut self.1 {
            flight.frame(frame);
        }
    }

    fn record(&mut self, record: &Record) {
        self.0.record(record);
    }

    fn warning(&mut self, warning: &Warning) {
        self.0.warning(warning);
    }

    fn sent(&mut self, frame: &OwnFrame, at: Timestamp) {
        self.0.sent(frame);
        if let Some(flight) = &mut self.1 {
            flight.sent(frame, at);
        }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum With {
    Nothing,
    Telemetry,
    Recorder,
}

/// A plan by which nothing is written, since nobody asks for it.
fn plan() -> FlightPlan {
    let path = Path::new("tests/recordings/e-type-sequential.toml");
    let loaded = config::load(path).expect("it ships");
    FlightPlan {
        folder: std::env::temp_dir().join("tertius-bench"),
        before: Span::from_seconds(30.0),
        after: Span::from_seconds(30.0),
        size: 1,
        machine: String::new(),
        names: loaded.settings.names(),
        fingerprints: loaded.fingerprints(),
        interfaces: vec!["can0".to_owned()],
        files: Vec::new(),
        design: everything(&loaded).checksum(),
    }
}

fn everything(loaded: &config::Loaded) -> tertius::monitor::MonitorDesign {
    let text = tertius::dbc::text::from_bytes(&loaded.dbc_text);
    let database = Database::parse(&text).expect("it ships");
    let mut design = design::judging(&loaded.settings, &database).expect("they fit");
    design.estimates = Estimates::Computed;
    design
}

/// Nanoseconds a frame.
fn play(frames: &[Frame], batch: usize, with: With, plan: &FlightPlan) -> f64 {
    let mut port = Tape { frames, batch, counts: PortCounts::default() };
    let mut gateway = gateway_of(monitor(), 0.05);
    let mut told = Told(Recorder::new(Arc::new(SystemClock::new())), None);
    told.0.opened();
    if with == With::Recorder {
        let mut flight = FlightRecorder::new(told.0.telemetry());
        flight.follow(Some(plan.clone()), gateway.monitor());
        told.1 = Some(flight);
    }
    let start = Instant::now();
    while !port.frames.is_empty() {
        if with == With::Nothing {
            gateway.turn(&mut port, Duration::ZERO, &mut Silent).expect("a tape does not break");
        } else {
            gateway.turn(&mut port, Duration::ZERO, &mut told).expect("a tape does not break");
            told.0.turned(&gateway, &port);
            if let Some(flight) = &mut told.1 {
                flight.turned(&gateway);
            }
        }
    }
    let time = start.elapsed();
    assert_eq!(gateway.monitor().counts().cycles, CYCLES as u64);
    time.as_nanos() as f64 / frames.len() as f64
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() {
    let frames: Vec<Frame> = (0..CYCLES).flat_map(|k| Cycle::new(k).frames()).collect();
    let plan = plan();
    for (without, with, what) in [
        (With::Nothing, With::Telemetry, "telemetry"),
        (With::Telemetry, With::Recorder, "flight recorder beside the telemetry"),
    ] {
        for (batch, name) in [(20, "a turn for each cycle"), (1, "a turn for each frame")] {
            let pairs: Vec<(f64, f64)> = (0..ROUNDS)
                .map(|_| (play(&frames, batch, without, &plan), play(&frames, batch, with, &plan)))
                .collect();
            let least = |of: fn(&(f64, f64)) -> f64| {
                // Whatever else the computer does only adds to it.
                pairs.iter().map(of).fold(f64::INFINITY, f64::min)
            };
            let (without, with) = (least(|pair| pair.0), least(|pair| pair.1));
            let ratio = with / without;
            println!(
                "{what}, {name}: {without:.0} ns a frame without, {with:.0} with; ratio {ratio:.3}"
            );
        }
    }
    copies();
}

/// What a copy of the monitor takes.
fn copies() {
    let loaded = config::load(Path::new("tests/recordings/e-type-sequential.toml"));
    let mut monitor = Monitor::new(everything(&loaded.expect("it ships")));
    let frames = (0..CYCLES).flat_map(|k| Cycle::new(k).frames());
    frames.for_each(|frame| monitor.take(&frame, &mut Vec::new()));
    let times = (0..200).map(|_| {
        let start = Instant::now();
        let copy = Box::new(monitor.clone());
        let time = start.elapsed();
        drop(copy);
        time.as_nanos() as f64 / 1e3
    });
    println!("a copy of the monitor with everything on: {:.0} µs", median(times.collect()));
}
