//! Trials of a commissioned machine, with faults and without, in seas that it did not learn from.

use crate::line::Faults;
use crate::plan::Task;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tertius::alarm::{State, Warning};
use tertius::commission::trial::DETECTORS;
use tertius::config::Settings;
use tertius::dbc::Database;
use tertius::evaluate::{Blame, Outcome};
use tertius::inject::{Fault, Shape, Wanted, Window, place};
use tertius::monitor::{Monitor, MonitorDesign};
use tertius::simulator::{Options, Simulator, Tables};
use tertius::time::Span;
use tertius::verdict::Suspect;

/// Significant wave height, m, and peak period, s.
const SEAS: [[f64; 2]; 4] = [[2.0, 7.5], [1.6, 7.0], [2.3, 8.5], [1.8, 9.0]];

/// Time from when the observers have settled until a fault begins, s.
const LEAD: f64 = 37.0;

/// Cylinders of a machine that have a fault at once: a change that half of the cylinders share
/// counts as no cylinder's own.
const AT_ONCE: usize = 2;

pub struct Watched<'a> {
    pub tables: &'a Tables,
    pub settings: &'a Settings,
    pub database: &'a Database,
    pub design: &'a MonitorDesign,
}

/// Shapes by name, and how long each is watched, s.
fn kinds(coarse: bool) -> [(&'static str, Shape, f64); 7] {
    let step = |size: f64| Shape::Step { size };
    let smallest = if coarse {
        ("step 0.75 mm", step(7.5e-4), 10.0)
    } else {
        ("step 0.25 mm", step(2.5e-4), 10.0)
    };
    [
        smallest,
        ("step 0.5 mm", step(5e-4), 10.0),
        ("step 1 mm", step(1e-3), 10.0),
        ("step 1.25 mm", step(1.25e-3), 10.0),
        ("noise 0.87 mm", Shape::Noise { size: 8.68e-4 }, 5.0),
        ("drift 0.1 mm/s", Shape::Drift { rate: 1e-4 }, 12.0),
        ("drift 0.01 mm/s", Shape::Drift { rate: 1e-5 }, 60.0),
    ]
}

fn signed(shape: Shape, sign: f64) -> Shape {
    match shape {
        Shape::Step { size } => Shape::Step { size: sign * size },
        Shape::Drift { rate } => Shape::Drift { rate: sign * rate },
        other => other,
    }
}

impl Watched<'_> {
    /// `each` faults of every kind.
    pub fn faults(&self, task: &Task, each: usize) -> Vec<Faults> {
        let mut rng = ChaCha8Rng::seed_from_u64(task.seed);
        rng.set_stream(1_000 + task.pair as u64);
        kinds(task.is_coarse()).map(|kind| self.of_a_kind(kind, each, &mut rng)).to_vec()
    }

    fn of_a_kind(
        &self,
        (name, shape, watch): (&str, Shape, f64),
        each: usize,
        rng: &mut ChaCha8Rng,
    ) -> Faults {
        let mut faults = Faults {
            kind: name.to_owned(),
            tried: 0,
            spoilt: 0,
            delays_s: Vec::new(),
            right: 0,
            undecided: 0,
            wrong: 0,
        };
        for run in 0..each.div_ceil(AT_ONCE) {
            for outcome in self.run(shape, watch, SEAS[run % SEAS.len()], rng) {
                let delays = DETECTORS.map(|it| outcome.delays[it as usize - 1]);
                let delay = delays.into_iter().flatten().reduce(f64::min);
                faults.tried += 1;
                faults.spoilt += u64::from(outcome.spoilt);
                faults.delays_s.extend(delay);
                let blame = outcome.blame.filter(|_| delay.is_some());
                faults.right += u64::from(blame == Some(Blame::Right));
                faults.wrong += u64::from(blame == Some(Blame::Wrong));
                let open = matches!(blame, Some(Blame::Undecided | Blame::Process));
                faults.undecided += u64::from(open);
            }
        }
        faults
    }

    /// One machine with two faults at once.
    fn run(&self, shape: Shape, watch: f64, sea: [f64; 2], rng: &mut ChaCha8Rng) -> Vec<Outcome> {
        let Self { tables, settings, database, design } = *self;
        let seed = rng.random();
        let first: u8 = rng.random_range(1..=6);
        let begin = settings.observer.settle + LEAD;
        let faults: Vec<(u8, Suspect, f64, Shape)> = [first, (first + 2) % 6 + 1]
            .into_iter()
            .map(|cylinder| {
                let second = rng.random::<bool>();
                let sign = if rng.random::<bool>() { 1.0 } else { -1.0 };
                let at = begin + rng.random::<f64>() * 5.0;
                (cylinder, if second { Suspect::C2 } else { Suspect::C1 }, at, signed(shape, sign))
            })
            .collect();
        let placed = faults.iter().map(|(cylinder, suspect, at, shape)| {
            let sensor = if *suspect == Suspect::C2 { "c2" } else { "c1" };
            let window = Window { from: Span::from_seconds(*at), until: None };
            let (cylinder, wanted) = (*cylinder, Wanted::Shape(*shape));
            place(&Fault { cylinder, sensor, wanted, window }, settings, database)
                .expect("the machine has both transducers")
        });
        let faulty = placed.collect();
        let options =
            Options { seed, sea: Some(sea), in_loop: true, faults: faulty, ..Options::default() };
        let mut simulator =
            Simulator::new(tables, settings, database, &options).expect("it was recorded");
        let (mut monitor, mut heard) = (Monitor::new(design.clone()), Vec::new());
        let mut onsets = vec![None; faults.len()];
        let cycles = (begin + 5.0 + watch + 1.0) / settings.machine.sample_time;
        for _ in 0..cycles as u64 {
            let opening = simulator.opening();
            simulator.step(&mut |frame| monitor.take(frame, &mut heard));
            for (onset, tally) in onsets.iter_mut().zip(simulator.tallies()) {
                if tally.altered > 0 {
                    onset.get_or_insert(opening);
                }
            }
        }
        monitor.finish(&mut heard);
        let outcome = |((cylinder, suspect, _, _), onset): (&(u8, Suspect, f64, Shape), _)| {
            let onset: tertius::time::Timestamp = Option::expect(onset, "it was put in");
            let end = onset.after(Span::from_seconds(watch));
            Outcome::read(&heard, *cylinder, *suspect, onset, end)
        };
        faults.iter().zip(onsets).map(outcome).collect()
    }

    /// Warnings of each detector in this many fault-free hours, with at most an hour for each sea.
    pub fn false_alarms(&self, task: &Task, hours: f64) -> Vec<(String, u64)> {
        let Self { tables, settings, database, design } = *self;
        let mut rng = ChaCha8Rng::seed_from_u64(task.seed);
        rng.set_stream(1_000_000 + task.pair as u64);
        let mut counts = DETECTORS.map(|detector| (detector.name().to_owned(), 0));
        let (mut rest, mut seas) = (hours, SEAS.into_iter().cycle());
        while rest > 0.0 {
            let options = Options { seed: rng.random(), sea: seas.next(), ..Options::default() };
            let mut simulator =
                Simulator::new(tables, settings, database, &options).expect("it was recorded");
            let (mut monitor, mut heard) = (Monitor::new(design.clone()), Vec::new());
            for _ in 0..(3600.0 * rest.min(1.0) / settings.machine.sample_time) as u64 {
                simulator.step(&mut |frame| monitor.take(frame, &mut heard));
            }
            monitor.finish(&mut heard);
            for ((_, count), detector) in counts.iter_mut().zip(DETECTORS) {
                let raised = |it: &&Warning| it.detector == detector && it.state == State::Raised;
                *count += heard.iter().filter(raised).count() as u64;
            }
            rest -= 1.0;
        }
        counts.to_vec()
    }
}
