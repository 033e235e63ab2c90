//! Single transducers that a sensor on the deck supervises: drifts and steps of C1 in the loop, and healthy hours.
//!
//! `cargo run --release --example single_deck -- 0.01 10 20 0` plays every fault on each cylinder of ten machines with a
//! sensor of 0.01°, and 20 healthy hours. The last number is the age of the sensor's readings, s.

use std::error::Error;
use std::path::Path;
use tertius::alarm::{State, Warning};
use tertius::blame::Rule;
use tertius::config::settings::Settings;
use tertius::config::{self, design};
use tertius::controller;
use tertius::dbc::{Database, text};
use tertius::inject::{Fault, place};
use tertius::monitor::{Monitor, MonitorDesign};
use tertius::simulator::{Options, Simulator, Tables};

const CYCLE: f64 = 0.02;

/// Time at work before a fault, s, and the longest time for which one is watched.
const LEAD: f64 = 180.0;
const WATCHED: f64 = 60.0;

/// An error has to be named before this, m.
const IN_TIME: f64 = 0.02;

/// How long one healthy machine is watched, s.
const STRETCH: f64 = 1800.0;

/// Significant wave height, m, and peak period, s; machines take turns.
const SEAS: [[f64; 2]; 2] = [[2.5, 8.0], [1.5, 11.0]];

/// Shapes, their key, and its value, m/s or m.
const CASES: [(&str, &str, f64); 10] = [
    ("drift", "rate", 0.02e-3),
    ("drift", "rate", 0.05e-3),
    ("drift", "rate", 0.1e-3),
    ("drift", "rate", 0.2e-3),
    ("drift", "rate", 0.5e-3),
    ("drift", "rate", 2e-3),
    ("drift", "rate", 10e-3),
    ("step", "size", 5e-3),
    ("step", "size", 10e-3),
    ("step", "size", 20e-3),
];

struct Stand {
    settings: Settings,
    database: Database,
    tables: Tables,
    design: MonitorDesign,
}

impl Stand {
    fn new(accuracy: f64, latency: f64) -> Result<Self, Box<dyn Error>> {
        let loaded = config::load(Path::new("config/e-type-top.toml"))?;
        let database = Database::parse(&text::from_bytes(&loaded.dbc_text))?;
        let mut settings = loaded.settings;
        let signals = &mut settings.signals.cylinder;
        (signals.c2, signals.c2_velocity) = (None, None);
        (signals.c2_status, signals.c2_counter) = (None, None);
        settings.hexapod.as_mut().ok_or("there is no hexapod")?.top_accuracy = accuracy;
        let mut tables = Tables::parse(&std::fs::read_to_string("config/e-type-plant.toml")?)?;
        let top = &mut tables.sensors.top;
        (top.noise, top.wander, top.latency) = (accuracy, accuracy, latency);
        let design = design::judging(&settings, &database)
            .map_err(|flaws| flaws.iter().map(|it| it.message.clone()).collect::<String>())?;
        Ok(Self { settings, database, tables, design })
    }

    fn start(&self, seed: u64) -> Result<(Simulator, Monitor), Box<dyn Error>> {
        let sea = Some(SEAS[seed as usize % SEAS.len()]);
        let options = Options { seed, sea, in_loop: true, ..Options::default() };
        let mut simulator = Simulator::new(&self.tables, &self.settings, &self.database, &options)?;
        simulator.request(controller::State::Engaged);
        Ok((simulator, Monitor::new(self.design.clone())))
    }
}

/// Plays so many seconds, and returns what the deck's attitude has raised.
fn play(simulator: &mut Simulator, monitor: &mut Monitor, seconds: f64) -> Vec<Warning> {
    let mut warnings: Vec<Warning> = Vec::new();
    for _ in 0..(seconds / CYCLE) as u64 {
        simulator.step(&mut |frame| monitor.take(frame, &mut warnings));
    }
    warnings.retain(|it| it.finding.rule == Rule::DeckAttitude && it.state == State::Raised);
    warnings
}

fn main() -> Result<(), Box<dyn Error>> {
    let words = std::env::args().skip(1).map(|word| word.parse::<f64>());
    let [degrees, machines, hours, latency] = words.collect::<Result<Vec<_>, _>>()?[..] else {
        return Err(
            "expected the accuracy in degrees, machines, hours and latency in seconds".into()
        );
    };
    let stand = Stand::new(degrees.to_radians(), latency)?;
    let mut counts = [[0_u32; 3]; CASES.len()];
    let mut sizes: [Vec<f64>; CASES.len()] = Default::default();
    let mut early = 0;
    for number in 0..machines as u64 {
        let (mut simulator, mut monitor) = stand.start(number)?;
        early += play(&mut simulator, &mut monitor, LEAD).len();
        for (case, (shape, key, value)) in CASES.into_iter().enumerate() {
            for cylinder in 1..=6_u8 {
                let sign =
                    if (number + u64::from(cylinder)).is_multiple_of(2) { 1.0 } else { -1.0 };
                let text =
                    format!("{shape},{key}={},cylinder={cylinder},sensor=c1,at=0", sign * value);
                let placed = place(&Fault::parse(&text)?, &stand.settings, &stand.database)?;
                let (mut simulator, mut monitor) = (simulator.clone(), monitor.clone());
                simulator.afflict(&[placed], number);
                let begin = simulator.opening();
                let seconds = if shape == "drift" { (IN_TIME / value).max(4.0) } else { WATCHED };
                let raised = play(&mut simulator, &mut monitor, seconds);
                let is_wrong = raised.iter().any(|it| it.cylinder != cylinder);
                let Some(first) = raised.first().filter(|_| !is_wrong) else {
                    counts[case][if is_wrong { 1 } else { 2 }] += 1;
                    continue;
                };
                counts[case][0] += 1;
                let after = first.timestamp.since(begin).as_seconds();
                sizes[case].push(if shape == "drift" { after * value * 1e3 } else { after });
            }
        }
    }
    println!(
        "sensor of {degrees}°, latency {latency} s, {machines} machines; before any fault: {early}"
    );
    println!("fault               right  wrong  none  named at, median and largest (mm or s)");
    for (((shape, _, value), [right, wrong, none]), mut at) in
        CASES.into_iter().zip(counts).zip(sizes)
    {
        at.sort_by(f64::total_cmp);
        let ends = [at.get(at.len() / 2), at.last()]
            .map(|it| it.map_or(String::new(), |it| format!("{it:.1}")));
        println!(
            "{shape:5} {:5.2} mm       {right:5}  {wrong:5} {none:5}  {}",
            value * 1e3,
            ends.join(" ")
        );
    }
    let mut found = 0;
    let stretches = (hours * 3600.0 / STRETCH).ceil() as u64;
    for number in 0..stretches {
        let (mut simulator, mut monitor) = stand.start(1000 + number)?;
        found += play(&mut simulator, &mut monitor, STRETCH).len();
    }
    println!("{:.1} healthy hours: {found} findings", stretches as f64 * STRETCH / 3600.0);
    Ok(())
}
