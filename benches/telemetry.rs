//! What the telemetry costs the data path: the same frames through the same gateway without and
//! with it, in turn, in one run.
//!
//!     cargo bench --bench telemetry

use std::sync::Arc;
use std::time::{Duration, Instant};
use tertius::alarm::{OwnFrame, Warning};
use tertius::appliance::telemetry::Recorder;
use tertius::appliance::telemetry::clock::SystemClock;
use tertius::bus::{Port, PortCounts, PortError, Received, Sent, Stamps};
use tertius::frame::Frame;
use tertius::live::gateway::{Gateway, Journal, Silent};
use tertius::live::outbox::{Outbox, OutboxLimits};
use tertius::monitor::Record;
use tertius::time::{Span, Timestamp};
use tertius_testing::machine::{Cycle, monitor};

const CYCLES: i64 = 5_000;
const ROUNDS: usize = 21;

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
        Ok(Received { frames: now.len(), drained_at })
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

struct Told(Recorder);

impl Journal for Told {
    fn record(&mut self, record: &Record) {
        self.0.record(record);
    }

    fn warning(&mut self, warning: &Warning) {
        self.0.warning(warning);
    }

    fn sent(&mut self, frame: &OwnFrame, _: Timestamp) {
        self.0.sent(frame);
    }
}

fn gateway() -> Gateway {
    let limits = OutboxLimits {
        waiting: OutboxLimits::WAITING,
        estimates: 6,
        age: Span::from_seconds(0.2),
        bitrate: 500_000.0,
        share: 0.05,
        burst: OutboxLimits::BURST,
    };
    Gateway::new(monitor(), Outbox::new(limits), Span::from_seconds(0.01))
}

/// Nanoseconds a frame.
fn play(frames: &[Frame], batch: usize, told: bool) -> f64 {
    let mut port = Tape { frames, batch, counts: PortCounts::default() };
    let mut gateway = gateway();
    let mut recorder = Told(Recorder::new(Arc::new(SystemClock::new())));
    recorder.0.opened();
    let start = Instant::now();
    while !port.frames.is_empty() {
        if told {
            gateway.turn(&mut port, Duration::ZERO, &mut recorder).expect("a tape does not break");
            recorder.0.turned(&gateway, &port);
        } else {
            gateway.turn(&mut port, Duration::ZERO, &mut Silent).expect("a tape does not break");
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
    for (batch, name) in [(20, "a turn for each cycle"), (1, "a turn for each frame")] {
        let pairs: Vec<(f64, f64)> = (0..ROUNDS)
            .map(|_| (play(&frames, batch, false), play(&frames, batch, true)))
            .collect();
        let without = median(pairs.iter().map(|pair| pair.0).collect());
        let with = median(pairs.iter().map(|pair| pair.1).collect());
        let ratio = median(pairs.iter().map(|pair| pair.1 / pair.0).collect());
        println!("{name}: {without:.0} ns a frame without, {with:.0} with; ratio {ratio:.3}");
    }
}
