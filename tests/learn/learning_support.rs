//! Rows of a machine that is simulated by (4-1), with noise that is the same in every run.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tertius::observe::model::Model;
use tertius::sample::Quality;
use tertius::survey::Row;
use tertius::time::Timestamp;

pub const TS: f64 = 0.02;
pub const THETA: [f64; 5] = [-0.0101, -0.1231, -1.6891e-5, -10.7104, -0.0023];
pub const GAMMA: [f64; 2] = [0.0926, 6.5427];

pub fn random(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// About normal, of deviation 1: the sum of twelve numbers.
pub fn normal(random: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0
}

/// The row of cycle `k` with these readings.
pub fn row(k: u64, cylinder: u8, c1: Option<f64>, c2: Option<f64>) -> Row {
    Row {
        timestamp: Timestamp::from_nanos(20_000_000 * k as i64),
        t: TS * k as f64,
        cycle: k,
        cylinder,
        c1,
        c2,
        v1: None,
        v2: None,
        u: Some(0.0),
        pressure_bottom: None,
        pressure_rod: None,
        pressure_load: None,
        supply: None,
        spool: None,
        monitored: true,
        raw: [c1, c2],
        qualities: [c1, c2].map(|c| if c.is_some() { Quality::Good } else { Quality::OutOfRange }),
    }
}

pub fn model() -> Model {
    Model::new(TS, THETA, GAMMA)
}

/// `count` cycles of cylinder 1: process and readings with noise, C2 = C1 but for its noise.
pub fn rows(seed: u64, count: u64) -> Vec<Row> {
    let (model, mut random) = (model(), random(seed));
    let mut x = nalgebra::Vector3::new(0.0, 0.0, 0.0);
    (0..count)
        .map(|k| {
            let t = TS * k as f64;
            let u = 0.3 * (0.7 * t).cos() + 0.05 * (2.9 * t).sin();
            let reading = |random: &mut ChaCha8Rng| Some(x[0] + 1e-4 * normal(random));
            let (c1, c2) = (reading(&mut random), reading(&mut random));
            let v1 = Some(x[1] + 1e-2 * normal(&mut random));
            let v2 = Some(x[1] + 1e-2 * normal(&mut random));
            x = model.a * x + model.b * u;
            x[1] += 1e-3 * normal(&mut random);
            Row { v1, v2, u: Some(u), ..row(k, 1, c1, c2) }
        })
        .collect()
}
