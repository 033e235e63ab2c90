//! The friction curve (3-13) from constant-velocity stretches.
//!
//! At constant velocity (3-9) is A_p P_L = F_fr(l̇) + k l + F_0, with the load in F_0: the part
//! that changes its sign with the velocity is friction. A_p is not known here, so forces are given
//! as the load pressure that balances them, F/A_p in bar. A ship's motion also loads the cylinder:
//! where the remainder is as large as the friction, there is no curve (the thesis's Figure 3-10).

use super::moments::Spread;
use super::qr::{Regression, Triangle};
use crate::survey::{Row, Surveyor};
use thiserror::Error;

/// Number of parts of a stretch whose mean velocities are compared; each part is 2.5 s at 50 Hz.
/// The pressure may still settle in the first, which is compared but otherwise left out.
const PARTS: usize = 5;
const PART: u64 = 25;

/// Largest difference of the parts' means for a constant velocity, as a part of it.
pub const STEADY: f64 = 0.03;
/// Absolute limit of the difference of the parts' means for a constant velocity, m/s.
pub const FLOOR: f64 = 1.5e-3;

/// Slowest velocity that counts as motion, m/s.
const SLOWEST: f64 = 3e-3;

/// Most stretches of a cylinder that are kept: hours of them.
const MOST: usize = 4096;

/// Largest difference of stretches with the same speed, as a part of it.
const ALIKE: f64 = 0.15;

/// Fewest speeds in each direction for a curve.
pub const SPEEDS: usize = 4;

/// Largest remainder, as a part of the friction's own root mean square.
const SCATTER: f64 = 0.5;

/// Range of Stribeck velocities that are tried, m/s.
const STRIBECK: [f64; 2] = [2e-3, 0.2];
/// Number of Stribeck velocities that are tried.
const TRIES: usize = 41;

/// Means over a stretch of constant velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Velocity, m/s.
    pub velocity: f64,
    /// Length, m.
    pub length: f64,
    /// Load pressure, bar.
    pub pressure: f64,
}

/// Friction at one speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Velocity, m/s.
    pub velocity: f64,
    /// Mean friction F_fr/A_p, bar.
    pub force: f64,
    /// Standard deviation of the force between stretches, bar.
    pub deviation: f64,
    pub stretches: u64,
}

/// Friction curve (3-13), with forces over A_p in bar.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionCurve {
    pub points: Vec<Point>,
    /// Viscous friction μ_v/A_p, bar s/m.
    pub viscous: f64,
    /// Coulomb friction F_c0/A_p, bar.
    pub coulomb: f64,
    /// Static friction F_s0/A_p, bar, and Stribeck velocity c_s, m/s; `None` where no speed is slow
    /// enough to show them.
    pub stribeck: Option<(f64, f64)>,
    pub stretches: usize,
    /// Root mean square of the stretches' pressures against the curve, bar.
    pub rms: f64,
}

/// Why there is no curve, in words for people.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum NoFriction {
    #[error("no load pressure and velocity, which (3-19) needs, are recorded together")]
    NoPressure,
    #[error(
        "the recording has {stretches} stretches of 2.5 s at constant velocity, with {out} speeds \
         outwards and {back} inwards, and at least {SPEEDS} each are needed: the friction curve \
        (3-13) is not identified; record strokes at constant velocities, with the vessel at rest"
    )]
    TooFew { stretches: usize, out: usize, back: usize },
    #[error(
        "over {stretches} stretches of constant velocity the load pressure scatters by {rms_bar:.2} \
         bar about a friction of {friction_bar:.2} bar: there is no apparent relation (as in Figure \
         3-10 of the thesis), the load moves too much; record strokes with the vessel at rest"
    )]
    NoRelation { stretches: usize, rms_bar: f64, friction_bar: f64 },
    #[error("the load cannot be told from the friction in these stretches: vary stroke and speed")]
    Collinear,
}

/// Finds the stretches of all cylinders.
#[derive(Clone, Debug)]
pub struct Stretches {
    area_ratio: f64,
    cylinders: Vec<Gathering>,
}

#[derive(Clone, Debug, Default)]
struct Gathering {
    velocity: [Spread; PARTS],
    taken: u64,
    length: Spread,
    pressure: Spread,
    rows: u64,
    found: Vec<Stretch>,
}

impl Stretches {
    pub fn new(cylinders: u8, area_ratio: f64) -> Self {
        Self { area_ratio, cylinders: vec![Gathering::default(); cylinders.into()] }
    }

    /// The friction curve of each cylinder.
    pub fn curves(&self) -> Vec<Result<FrictionCurve, NoFriction>> {
        let one = |gathering: &Gathering| match gathering.rows {
            0 => Err(NoFriction::NoPressure),
            _ => curve(&gathering.found),
        };
        self.cylinders.iter().map(one).collect()
    }
}

impl Surveyor for Stretches {
    fn row(&mut self, row: &Row) {
        let place = usize::from(row.cylinder).wrapping_sub(1);
        let Some(gathering) = self.cylinders.get_mut(place) else { return };
        let load = row.load_pressure(self.area_ratio);
        match (row.monitored, row.v1, row.c1, load) {
            (true, Some(v), Some(l), Some(p)) if v.is_finite() && p.is_finite() => {
                gathering.add(v, l, p);
            }
            _ => gathering.restart(),
        }
    }

    fn gap(&mut self, cylinder: u8) {
        if let Some(gathering) = self.cylinders.get_mut(usize::from(cylinder).wrapping_sub(1)) {
            gathering.restart();
        }
    }
}

impl Gathering {
    fn restart(&mut self) {
        (self.velocity, self.taken, self.length, self.pressure) = Default::default();
    }

    fn add(&mut self, v: f64, l: f64, p: f64) {
        self.rows += 1;
        // A whole stretch starts anew, so that the place is one of the parts.
        let part = (self.taken / PART) as usize;
        self.taken += 1;
        self.velocity[part].add(v);
        if part > 0 {
            self.length.add(l);
            self.pressure.add(p);
        }
        if self.velocity[part].count < PART {
            return;
        }
        if !self.is_steady(part + 1) {
            // The next may begin here already.
            return self.restart();
        }
        if part + 1 == PARTS {
            let sum: f64 = self.velocity[1..].iter().map(|part| part.mean).sum();
            let velocity = sum / (PARTS - 1) as f64;
            let (length, pressure) = (self.length.mean, self.pressure.mean);
            if self.found.len() < MOST {
                self.found.push(Stretch { velocity, length, pressure });
            }
            self.restart();
        }
    }

    fn is_steady(&self, parts: usize) -> bool {
        let mut means = Spread::default();
        self.velocity[..parts].iter().for_each(|part| means.add(part.mean));
        let speed = means.mean.abs();
        let moves = speed >= SLOWEST && means.low * means.high > 0.0;
        moves && means.range() <= (STEADY * speed).max(FLOOR)
    }
}

impl FrictionCurve {
    /// Friction F_fr/A_p at `velocity`, m/s, in bar; 0 at standstill, where (3-10) has static
    /// friction.
    pub fn at(&self, velocity: f64) -> f64 {
        let sign = if velocity == 0.0 { 0.0 } else { velocity.signum() };
        let slow = self.stribeck.map_or(0.0, |(force, c)| force * (-velocity.abs() / c).exp());
        self.viscous * velocity + sign * (self.coulomb + slow)
    }
}

/// The curve through `found`.
///
/// # Errors
/// Too few speeds, or no relation.
pub fn curve(found: &[Stretch]) -> Result<FrictionCurve, NoFriction> {
    let speeds = |sign: f64| {
        let mut speeds: Vec<f64> =
            found.iter().map(|it| sign * it.velocity).filter(|speed| *speed > 0.0).collect();
        speeds.sort_by(f64::total_cmp);
        groups(&speeds)
    };
    let [out, back] = [speeds(1.0), speeds(-1.0)];
    let stretches = found.len();
    if out.len() < SPEEDS || back.len() < SPEEDS {
        return Err(NoFriction::TooFew { stretches, out: out.len(), back: back.len() });
    }
    let (fit, speed) = best(found).ok_or(NoFriction::Collinear)?;
    let parameters = &fit.coefficients;
    let force = |it: &Stretch| it.pressure - parameters[0] - parameters[1] * it.length;
    let mut friction = Spread::default();
    found.iter().for_each(|it| friction.add(force(it)));
    let rms = fit.residual_norm / (stretches as f64).sqrt();
    if rms > SCATTER * friction.rms() {
        let friction_bar = friction.rms();
        return Err(NoFriction::NoRelation { stretches, rms_bar: rms, friction_bar });
    }
    let ranges = out.into_iter().map(|range| (1.0, range));
    let ranges = back.into_iter().rev().map(|range| (-1.0, range)).chain(ranges);
    let point = |(sign, [low, high]): (f64, [f64; 2])| {
        let (mut velocity, mut forces) = (Spread::default(), Spread::default());
        for it in found.iter().filter(|it| (low..=high).contains(&(sign * it.velocity))) {
            velocity.add(it.velocity);
            forces.add(force(it));
        }
        let deviation = forces.variance().sqrt();
        Point { velocity: velocity.mean, force: forces.mean, deviation, stretches: forces.count }
    };
    Ok(FrictionCurve {
        points: ranges.map(point).collect(),
        viscous: parameters[2],
        coulomb: parameters[3],
        stribeck: speed.map(|speed| (parameters[4], speed)),
        stretches,
        rms,
    })
}

/// Lowest and highest speed of each group of similar ones; `speeds` are in order.
fn groups(speeds: &[f64]) -> Vec<[f64; 2]> {
    let mut groups: Vec<[f64; 2]> = Vec::new();
    for speed in speeds {
        match groups.last_mut().filter(|group| *speed <= group[0] * (1.0 + ALIKE)) {
            Some(group) => group[1] = *speed,
            None => groups.push([*speed; 2]),
        }
    }
    groups
}

/// Linear fit of load, stiffness, viscous, Coulomb and static friction for a given Stribeck
/// velocity.
fn fitted(found: &[Stretch], stribeck: Option<f64>) -> Option<Regression> {
    let mut triangle = Triangle::<6>::new();
    for it in found {
        let sign = it.velocity.signum();
        let slow = stribeck.map_or(0.0, |speed| sign * (-it.velocity.abs() / speed).exp());
        triangle.add(&[1.0, it.length, it.velocity, sign, slow, it.pressure]);
    }
    let all = [0, 1, 2, 3, 4];
    triangle.solve(if stribeck.is_some() { &all } else { &all[..4] }, 5).ok()
}

/// The fit with the smallest remainder, and its Stribeck velocity; `None` for the velocity where
/// static friction gains nothing or would help the motion.
fn best(found: &[Stretch]) -> Option<(Regression, Option<f64>)> {
    let plain = fitted(found, None);
    let [mut low, mut high] = STRIBECK;
    let mut best: Option<(Regression, f64)> = None;
    // Each round looks closer between the neighbours of the best.
    for _ in 0..4 {
        let ratio = (high / low).powf(1.0 / (TRIES - 1) as f64);
        for speed in (0..TRIES).map(|i| low * ratio.powi(i as i32)) {
            let Some(fit) = fitted(found, Some(speed)) else { continue };
            let better = |(known, _): &(Regression, f64)| fit.residual_norm < known.residual_norm;
            if fit.coefficients[4] > 0.0 && best.as_ref().is_none_or(better) {
                best = Some((fit, speed));
            }
        }
        let Some((_, speed)) = best else { break };
        (low, high) = (speed / ratio, speed * ratio);
    }
    // Static friction counts where it is beyond three of its standard errors.
    let significant =
        |(fit, _): &(Regression, f64)| fit.coefficients[4] > 3.0 * fit.standard_errors[4];
    match best.filter(significant) {
        Some((fit, speed)) => Some((fit, Some(speed))),
        None => plain.map(|fit| (fit, None)),
    }
}
