//! How many times faster than the machine a simulated one is, with its bus and its monitor.
//!
//! `cargo bench --bench simulate`: one core, the default machine, ten minutes of its time; the
//! best of some rounds of each part. At last the monitor alone, on the frames of an hour, and what
//! that makes for a year of a machine.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use tertius::config;
use tertius::config::design;
use tertius::controller::Readings;
use tertius::dbc::{Database, text};
use tertius::frame::Frame;
use tertius::monitor::{Monitor, Sink};
use tertius::simulator::{Machine, Options, Simulator, Tables};

const CYCLES: u32 = 30_000;
const ROUNDS: usize = 7;
const CYCLES_PER_SECOND: f64 = 50.0;
const CYCLES_PER_MINUTE: u32 = 3000;
const HOURS_PER_YEAR: f64 = 8766.0;

struct Nothing;

impl Sink for Nothing {}

fn main() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/e-type-simulated.toml");
    let loaded = config::load(&path).expect("the configuration is sound");
    let database = Database::parse(&text::from_bytes(&loaded.dbc_text)).expect("the DBC is sound");
    let settings = &loaded.settings;
    let design = design::judging(settings, &database).expect("they fit");
    let tables = Tables::default();
    let options = Options { seed: 1, ..Options::default() };
    let made = Machine::new(&tables, settings.machine.sample_time, &options).expect("it is sound");
    let simulated = Simulator::new(&tables, settings, &database, &options).expect("it is sound");

    show(
        "sea, controller, plant, transducers",
        best(|| {
            let mut machine = made.clone();
            let mut readings = Readings::default();
            for _ in 0..CYCLES {
                let sample = machine.sample();
                readings.lengths = sample.transducers.map(|[c1, _]| c1.length);
                readings.speeds = sample.transducers.map(|[c1, _]| c1.speed);
                readings.pressures = sample.load_pressures;
                readings.pose = sample.motion.pose;
                readings.rate = sample.motion.rate;
                black_box(machine.command(&readings));
                machine.advance();
            }
        }),
    );
    show(
        "  of these, the plant alone",
        best(|| {
            let mut machine = made.clone();
            for _ in 0..CYCLES {
                machine.advance();
            }
            black_box(machine.states());
        }),
    );
    show(
        "all of it as frames",
        best(|| {
            let mut simulator = simulated.clone();
            let mut frames = 0;
            for _ in 0..CYCLES {
                simulator.step(&mut |frame| frames += u32::from(black_box(frame).length() > 0));
            }
            assert_eq!(frames, 22 * CYCLES);
        }),
    );
    show(
        "all of it with the monitor",
        best(|| {
            let (mut simulator, mut monitor) = (simulated.clone(), Monitor::new(design.clone()));
            for _ in 0..CYCLES {
                simulator.step(&mut |frame| monitor.take(frame, &mut Nothing));
            }
            assert_eq!(monitor.counts().cycles, u64::from(CYCLES));
        }),
    );
    alone(simulated.clone(), Monitor::new(design));
}

/// An hour, minute by minute: the machine makes the frames of a minute, and only what the monitor
/// does with them is timed.
fn alone(mut simulator: Simulator, mut monitor: Monitor) {
    let (mut frames, mut seconds) = (Vec::<Frame>::new(), 0.0);
    for _ in 0..60 {
        frames.clear();
        for _ in 0..CYCLES_PER_MINUTE {
            simulator.step(&mut |frame| frames.push(frame.clone()));
        }
        let start = Instant::now();
        for frame in &frames {
            monitor.take(black_box(frame), &mut Nothing);
        }
        seconds += start.elapsed().as_secs_f64();
    }
    let (cycles, cylinders) = (monitor.counts().cycles, monitor.tallies().count() as u64);
    assert_eq!(cycles, 60 * u64::from(CYCLES_PER_MINUTE));
    let samples = (cycles * cylinders) as f64;
    println!(
        "the monitor alone, an hour: {seconds:.3} s, {:.0} ns a cylinder and sample, {:.0} times \
         real time",
        1e9 * seconds / samples,
        3600.0 / seconds
    );
    println!(
        "  a year of a machine, {:.2e} samples of a cylinder: {:.0} s on one core",
        samples * HOURS_PER_YEAR,
        seconds * HOURS_PER_YEAR
    );
}

/// The shortest of some runs, s.
fn best(mut run: impl FnMut()) -> f64 {
    let times = (0..ROUNDS).map(|_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    });
    times.fold(f64::INFINITY, f64::min)
}

fn show(what: &str, seconds: f64) {
    let rate = f64::from(CYCLES) / seconds;
    println!(
        "{what:<40} {:6.2} µs a cycle, {:7.0} times real time",
        1e6 / rate,
        rate / CYCLES_PER_SECOND
    );
}
