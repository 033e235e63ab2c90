//! Machines: the harsh one of config/e-type-harsh-plant.toml, varied by a seeded draw.

use crate::plan::{Mishap, Task, Transducers};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;
use tertius::evaluate::Grade;
use tertius::simulator::{Spikes, Tables};
use tertius::transducer::Errors;

/// The most that both harmonics of a transducer add up to, m.
const RIPPLE: f64 = 2.5e-4;

/// How much later than Sync a transducer samples at the most, s.
const SKEW: f64 = 5e-4;

/// Largest effect of the temperature, m.
const WARMING: f64 = 1e-4;

/// The machine of `task`, different in every task but the same for the same seed.
pub fn draw(harsh: &Tables, task: &Task) -> Tables {
    let mut rng = ChaCha8Rng::seed_from_u64(task.seed);
    rng.set_stream(1 + task.machine as u64);
    let mut tables = harsh.clone();
    let mut times = |value: &mut f64, low: f64, high: f64| *value *= rng.random_range(low..high);
    let friction = &mut tables.friction;
    times(&mut friction.viscous, 0.6, 1.3);
    times(&mut friction.coulomb, 0.5, 1.3);
    times(&mut friction.stiction, 0.5, 1.3);
    let valve = &mut tables.valve;
    times(&mut valve.lag, 0.6, 1.2);
    times(&mut valve.overlap, 0.5, 1.3);
    times(&mut valve.progression, 0.6, 1.3);
    times(&mut valve.extend_speed, 0.95, 1.15);
    times(&mut valve.retract_speed, 0.95, 1.15);
    times(&mut tables.cylinder.load_mass, 0.7, 1.2);
    times(&mut tables.gangway.load, 0.5, 1.2);
    times(&mut tables.gangway.period, 0.7, 2.0);
    match task.transducers() {
        Transducers::Fluctuating | Transducers::Coarse => {}
        Transducers::Uneven => {
            tables.transducer.fluctuation_spread = 0.5;
            tables.transducer.fluctuation_time_spread = 0.9;
        }
        Transducers::Steady => tables.transducer.fluctuation_probability = 0.0,
    }
    errors(&mut tables.c1, &mut rng);
    errors(&mut tables.c2, &mut rng);
    let grade = if task.is_coarse() { Grade::Coarse } else { Grade::Fine };
    let mut tables = grade.apply(&tables);
    if let Some(sticking) = &mut tables.disturbance.sticking {
        sticking.band = rng.random_range(0.0..0.005);
    }
    tables.disturbance.spikes = None;
    tables
}

/// `tables` with the disturbances of the recording of `task`.
pub fn befallen(tables: &Tables, task: &Task) -> Tables {
    let mut tables = tables.clone();
    if task.mishap == Mishap::Spikes {
        // As far off as Figure 5-9 has it, 0.43 mm: four fine counts, one coarse one.
        let counts = if task.is_coarse() { 1.0 } else { 4.0 };
        tables.disturbance.spikes =
            Some(Spikes { time: [0.0, 1e6], share: [0.005, 0.005], counts });
    }
    tables
}

fn errors(errors: &mut Errors, rng: &mut ChaCha8Rng) {
    let mut around = |most: f64| rng.random_range(-most..most);
    errors.offset = errors.offset.map(|_| around(3e-3));
    errors.gain = errors.gain.map(|_| around(2e-3));
    errors.bow = errors.bow.map(|_| around(2e-4));
    errors.ripple.phases = errors.ripple.phases.map(|_| around(PI));
    errors.warming.amplitudes = errors.warming.amplitudes.map(|_| around(WARMING));
    errors.skew = errors.skew.map(|_| rng.random_range(0.0..SKEW));
    errors.warming.period = rng.random_range(3000.0..9000.0);
    errors.ripple.lengths = [rng.random_range(0.6..1.5), rng.random_range(0.25..0.6)];
    errors.ripple.amplitudes = errors.ripple.amplitudes.map(|_| {
        let (all, first) = (rng.random_range(0.0..RIPPLE), rng.random_range(0.3..1.0));
        [all * first, all * (1.0 - first)]
    });
}
