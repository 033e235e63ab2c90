//! Machines simulated by (4-1), as the rows that a survey of them would give.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tertius::identify::{
    Estimate, Estimator, IdentificationRefusal, OffsetRule, Shaper, Shaping, Sources,
};
use tertius::observe::model::Model;
use tertius::sample::Quality;
use tertius::survey::Row;
use tertius::time::Timestamp;

pub const THETA: [f64; 5] = [-0.0101, -0.1231, -1.6891e-5, -10.7104, -0.0023];
pub const GAMMA: [f64; 2] = [0.0926, 6.5427];
pub const TS: f64 = 0.02;

/// One cylinder of Table 4-1.
#[derive(Clone, Copy, Debug)]
pub struct Simulated {
    pub cylinder: u8,
    pub cycles: u32,
    /// Standard deviations of the noise of l, m, and l̇, m/s, and P_L, bar.
    pub noise: [f64; 3],
    /// Added to the command that acts.
    pub offset: f64,
    pub amplitude: f64,
}

impl Simulated {
    pub const fn new(cylinder: u8, cycles: u32) -> Self {
        Self { cylinder, cycles, noise: [0.0; 3], offset: 0.0, amplitude: 0.3 }
    }

    pub const fn noisy(self) -> Self {
        Self { noise: [1e-4, 5e-3, 0.5], ..self }
    }

    /// The rows of its cycles, from time zero.
    pub fn rows(self) -> Vec<Row> {
        let model = Model::new(TS, THETA, GAMMA);
        let mut generator = ChaCha8Rng::seed_from_u64(self.cylinder.into());
        let mut noise = || {
            let sum: f64 =
                (0..12).map(|_| f64::from(generator.next_u32()) / f64::from(u32::MAX)).sum();
            sum - 6.0
        };
        let mut x = nalgebra::Vector3::new(0.05, 0.0, 3.0);
        let one = |k: u32| {
            let t = f64::from(k) * TS;
            let phase = f64::from(self.cylinder);
            let waves = [(0.7, 1.0), (2.1, 0.5), (5.3, 0.4), (17.0, 0.3), (41.0, 0.2)];
            let u: f64 = waves.iter().map(|(w, a)| a * (w * t + phase * (1.0 + w)).sin()).sum();
            let u = self.amplitude * u;
            let [dl, dv, dp] = self.noise;
            let (l, v) = (x[0] + dl * noise(), x[1] + dv * noise());
            let row = row(self.cylinder, k, l, v, x[2] + dp * noise(), u + self.offset);
            x = model.a * x + model.b * u;
            row
        };
        (0..self.cycles).map(one).collect()
    }
}

pub fn row(cylinder: u8, k: u32, l: f64, v: f64, p: f64, u: f64) -> Row {
    // C1 = 1.002 C2 + 0.003, so that C2 is this.
    let c2 = (l - 0.003) / 1.002;
    Row {
        timestamp: Timestamp::from_nanos(i64::from(k) * 20_000_000),
        t: f64::from(k) * TS,
        cycle: u64::from(k) + 1,
        cylinder,
        c1: Some(l),
        c2: Some(c2),
        v1: Some(v),
        v2: Some(v / 1.002),
        u: Some(u),
        pressure_bottom: Some(p + 40.0),
        pressure_rod: Some(80.0),
        pressure_load: None,
        supply: None,
        spool: None,
        monitored: true,
        raw: [Some(l), Some(c2)],
        qualities: [Quality::Good; 2],
    }
}

pub const BOTH: Sources = Sources { velocity: true, pressure: true };

pub fn shaping(window: usize) -> Shaping {
    Shaping { sample_time: TS, window, area_ratio: 0.5 }
}

/// What `rows` of one cylinder come to.
pub fn estimate(
    rows: &[Row],
    window: usize,
    sources: Sources,
    rule: OffsetRule,
) -> Result<Estimate, IdentificationRefusal> {
    let mut estimator = Estimator::new(Shaper::new(shaping(window), sources), sources.pressure);
    for (index, row) in rows.iter().enumerate() {
        if index > 0 && row.cycle != rows[index - 1].cycle + 1 {
            estimator.gap();
        }
        estimator.row(row);
    }
    estimator.estimate(rule)
}
