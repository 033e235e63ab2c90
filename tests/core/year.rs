//! A machine whose rods stand on their stops now and then: temperature, stops that wear, transducers that
//! repeat and are rounded to counts, and one that drifts. In millimetres and years. Cylinders may have C1 alone.

use std::f64::consts::TAU;
use tertius::sequential::stops::{self, Blame, Judgement};
use tertius::sequential::{Dwell, DwellHistory, Gauging, StopReadings};
use tertius::time::Timestamp;

pub const CYLINDERS: usize = 6;

const DAYS: f64 = 365.25;

/// The first visit, days since 1970.
const BEGIN: f64 = 20_000.0;

/// How far temperature moves a reading to either side over the year; over a day half of that, mm.
const SEASON: f64 = 0.4;

/// By how much a transducer's temperature differs from its cylinder's.
const UNLIKE: f64 = 0.1;

/// A stop wears by up to this in a year, mm.
const WEAR: f64 = 0.5;

/// Standard deviations of where a rod stands, and of what a transducer reads there, mm.
const ROD: f64 = 0.05;
const REPEATABILITY: f64 = 0.05;

/// Standard deviation from reading to reading while the rod stands, mm.
const NOISE: f64 = 0.05;

/// Whose temperature it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Temperature {
    /// The machine's.
    Common,
    /// Each cylinder has another season, and other days.
    Each,
}

/// What the readings move in, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Grade {
    Fine,
    Coarse,
}

impl Grade {
    pub const fn count(self) -> f64 {
        match self {
            Self::Fine => 3e3 / 27_648.0,
            Self::Coarse => 4.0 * 3e3 / 27_648.0,
        }
    }
}

/// SplitMix64.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((mixed ^ mixed >> 31) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.uniform()).ln()).sqrt() * (TAU * self.uniform()).cos()
    }
}

/// What is constant of a cylinder.
struct Cylinder {
    phase: f64,
    wear: f64,
    gains: [f64; 2],
    offsets: [f64; 2],
}

pub struct Machine {
    grade: Grade,
    temperature: Temperature,
    random: Random,
    cylinders: Vec<Cylinder>,
    /// So many cylinders, the first ones, have C1 alone.
    singles: usize,
    pub histories: Vec<DwellHistory>,
}

impl Machine {
    pub fn new(grade: Grade, temperature: Temperature, seed: u64) -> Self {
        let mut random = Random(seed.wrapping_mul(0xD134_2543_DE82_EF95));
        let mut cylinder = |_| Cylinder {
            phase: random.uniform() * TAU,
            wear: WEAR * random.uniform(),
            gains: [0, 1].map(|_| 1.0 + UNLIKE * (2.0 * random.uniform() - 1.0)),
            offsets: [0, 1].map(|_| random.uniform()),
        };
        let cylinders: Vec<Cylinder> = (0..CYLINDERS).map(&mut cylinder).collect();
        let mut history = DwellHistory::default();
        history.gauge(Gauging { count: grade.count() * 1e-3, corrected: Some([1.0, 0.0]) });
        let histories = vec![history; CYLINDERS];
        Self { grade, temperature, random, cylinders, singles: 0, histories }
    }

    /// The machine of so many `cylinders`, of which the first `singles` have C1 alone. Nothing has told the resolution
    /// of those.
    pub fn of(mut self, cylinders: usize, singles: usize) -> Self {
        self.singles = singles;
        self.histories.truncate(cylinders);
        self.histories.iter_mut().take(singles).for_each(|it| *it = DwellHistory::default());
        self
    }

    /// Half of all, by chance.
    pub fn toss(&mut self) -> bool {
        self.random.uniform() < 0.5
    }

    /// The rods stand on their stops after so many years, by a clock that says `clock`; `moved`: how much
    /// more C1 (0) or C2 (1) of a cylinder, from 0, reads by then, mm.
    pub fn visit(&mut self, years: f64, clock: f64, moved: impl Fn(usize, usize) -> f64) {
        let hour = 0.3 * self.random.uniform();
        let day = (TAU * self.random.uniform()).sin();
        let at = Timestamp::from_nanos(((BEGIN + clock * DAYS + hour) * 86_400e9) as i64);
        let Self { random, cylinders, histories, singles, .. } = self;
        let common = cylinders[0].phase;
        for (n, (it, history)) in cylinders.iter().zip(histories).enumerate() {
            let (phase, day) = match self.temperature {
                Temperature::Common => (common, day),
                Temperature::Each => (it.phase, (TAU * random.uniform()).sin()),
            };
            let warmth = SEASON * ((TAU * years + phase).sin() + 0.5 * day);
            let rod = it.wear * years + ROD * random.normal();
            let readings = [0, 1].map(|which| {
                let scatter = REPEATABILITY * random.normal();
                let length = rod + it.gains[which] * warmth + it.offsets[which];
                1e-3 * rounded(length + moved(n, which) + scatter, self.grade.count())
            });
            let c2 = Some(readings[1]).filter(|_| n >= *singles);
            history.add(Dwell { at, readings: StopReadings { c1: readings[0], c2 } });
        }
    }

    pub fn judge(&self) -> Vec<Option<Judgement>> {
        stops::judge(&self.histories)
    }

    /// Whom the dwells so far blame, of each cylinder.
    pub fn blames(&self) -> Vec<Blame> {
        let blame = |judged: Option<Judgement>| judged.map_or(Blame::Neither, |it| it.blame);
        self.judge().into_iter().map(blame).collect()
    }
}

/// The mean of many readings that are rounded to counts, each with its own noise.
fn rounded(length: f64, count: f64) -> f64 {
    let below = (length / count).floor();
    let beyond = ((length / count - below - 0.5) * count / NOISE).clamp(-8.0, 8.0);
    // The normal distribution's integral, within a hundredth.
    count * (below + 1.0 / (1.0 + (-1.702 * beyond).exp()))
}

/// What came of a year in which a transducer of the first cylinder drifts, or none.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outcome {
    /// It was named, and how far it had drifted then, mm.
    pub right: Option<f64>,
    /// Anything else was ever named of that cylinder.
    pub wrong: bool,
    /// Healthy cylinders of which anything was ever named, and all of them.
    pub false_blames: usize,
    pub healthy: usize,
}

/// A year with a visit every so many `days` and a drift of `rate` mm a year, 0 for none.
pub fn year(grade: Grade, temperature: Temperature, days: f64, rate: f64, seed: u64) -> Outcome {
    let mut machine = Machine::new(grade, temperature, seed);
    let drifting = usize::from(machine.toss());
    let sign = if machine.toss() { 1.0 } else { -1.0 };
    let due = [Blame::C1, Blame::C2][drifting];
    let mut outcome = Outcome::default();
    let mut blamed = [false; CYLINDERS];
    for k in 0..(DAYS / days) as usize {
        let years = k as f64 * days / DAYS;
        let moved = |n, which| if (n, which) == (0, drifting) { sign * rate * years } else { 0.0 };
        machine.visit(years, years, moved);
        for (n, blame) in machine.blames().into_iter().enumerate() {
            let named = matches!(blame, Blame::C1 | Blame::C2 | Blame::Both);
            if n > 0 || rate == 0.0 {
                blamed[n] |= named;
            } else if blame == due {
                outcome.right.get_or_insert(rate * years);
            } else {
                outcome.wrong |= named;
            }
        }
    }
    outcome.healthy = CYLINDERS - usize::from(rate > 0.0);
    outcome.false_blames = blamed.iter().filter(|it| **it).count();
    outcome
}
