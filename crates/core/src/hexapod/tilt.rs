//! Whose reading has moved, by the attitude of the deck.
//!
//! The lengths by C1 and the vessel's attitude give the deck's to, and a sensor on the deck measures it. A
//! C1 that reads a cylinder too long by d leaves a tilt of h = −(∂attitude/∂ℓ) d between them, a C2 that reads it too
//! short by d leaves none; by C1 and C2 alone both are the same difference d.
//!
//! The mean e of that tilt over some seconds, less what is usual, has a covariance S that is measured while nothing is
//! wrong. With h averaged in the same way for each cylinder whose readings have parted, an explanation is a choice of
//! those whose C1 it was, and Q = (e − Σh)ᵀ S⁻¹ (e − Σh) how badly it fits. The log-likelihood of a cylinder's C1 less
//! that of its C2 is half of what the best explanation without it fits worse than the best one with it.
//!
//! A cylinder with a single transducer has nothing that could part. There a tilt that departs from the usual one is a
//! finding, and its direction identifies the cylinder ([`TiltChange`]).
//!
//! Without the sensor there is no such evidence: a controller that follows C1 holds the deck level by C1, whoever is
//! wrong.

mod comparison;
mod departure;
mod explanation;
mod healthy;

use super::{Geometry, Hexapod, LEGS, Pose, TiltParameters};
use crate::state::{state, whole};
use crate::time;
use comparison::{Comparison, are_finite, inclination, up};
use core::f64::consts::FRAC_PI_2;
use departure::{Departure, Found, fit};
pub use departure::{TiltChange, TiltError};
use explanation::evidence;
use healthy::Healthy;
use nalgebra::Vector2;

/// What a comparison is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct TiltDesign {
    pub geometry: Geometry,
    /// Standard deviation of what the sensor on the deck is off by for longer than a moment, rad.
    pub accuracy: f64,
    /// s.
    pub sample_time: f64,
    pub parameters: &'static TiltParameters,
}

/// An angle that a sensor measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inclination {
    VesselRoll,
    VesselPitch,
    TopRoll,
    TopPitch,
}

/// What is known of a cylinder in a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TiltLeg {
    /// C1, m.
    pub length: Option<f64>,
    /// Whether nothing is found of it.
    pub is_healthy: bool,
    /// Whether it has no C2.
    pub is_single: bool,
    /// Whether its readings have parted, and by how much C1 is now beyond what C2 has it at, m, where that is known.
    pub parted: Option<Option<f64>>,
}

/// What a cycle has shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TiltJudgement {
    /// For each cylinder whose readings have parted the evidence of whose has moved, nats: positive for C1, negative for
    /// C2; `None` where nothing was compared, or nothing explains the tilt.
    pub parted: [Option<f64>; LEGS],
    /// Of the cylinders with a single transducer.
    pub change: Option<TiltChange>,
}

/// Roll and pitch of one sensor, rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Sensor {
    angles: [f64; 2],
    /// Whether either came in this cycle.
    fresh: [bool; 2],
    /// The angles that were compared last, and since how many cycles they repeat.
    before: [f64; 2],
    repeated: u32,
}

whole! {
    Sensor { angles, fresh, before, repeated }
    sound |it| it.repeated < u32::MAX
}

/// The mean tilt that is judged.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Mean {
    tilt: [f64; 2],
    /// Cycles since it began.
    age: u32,
}

whole! {
    Mean { tilt, age }
    sound |it| it.age < u32::MAX && are_finite(&it.tilt)
}

/// Cycles since the readings of any cylinder have parted, and the tilt that each would explain, rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Since {
    cycles: u32,
    tilts: [Option<[f64; 2]>; LEGS],
}

whole! {
    Since { cycles, tilts }
    sound |it| it.cycles < u32::MAX && it.tilts.iter().flatten().all(are_finite)
}

/// Compares the deck's attitude by the lengths with that by a sensor on it.
#[derive(Clone, Debug)]
pub struct Tilt {
    hexapod: Hexapod,
    accuracy: f64,
    parameters: &'static TiltParameters,
    counts: Counts,
    vessel: Sensor,
    top: Sensor,
    /// The deck over the base at the newest comparison, from which the search begins.
    deck: Option<[f64; 6]>,
    /// Cycles since the newest comparison.
    idle: u32,
    mean: Option<Mean>,
    healthy: Option<Healthy>,
    since: Option<Since>,
    departure: Option<Departure>,
    found: Option<Found>,
}

state! {
    Tilt { vessel, top, deck, idle, mean, healthy, since, departure, found }
    but { hexapod, accuracy, parameters, counts }
    sound |it| it.idle < u32::MAX
}

/// Times of [`TiltParameters`] in cycles.
#[derive(Clone, Copy, Debug)]
struct Counts {
    every: u32,
    mean: f64,
    healthy: u32,
    settled: u32,
    gap: u32,
    frozen: u32,
    confirmed: u32,
    undecided: u32,
    sample_time: f64,
}

impl Tilt {
    pub fn new(design: &TiltDesign) -> Self {
        let TiltDesign { geometry, accuracy, sample_time, parameters } = design;
        let cycles = |seconds| time::cycles(seconds, *sample_time).max(1);
        let counts = Counts {
            every: cycles(parameters.every),
            mean: parameters.mean / sample_time,
            healthy: cycles(parameters.healthy),
            settled: cycles(parameters.settled),
            gap: cycles(parameters.gap),
            frozen: cycles(parameters.frozen),
            confirmed: cycles(parameters.confirmed),
            undecided: cycles(parameters.undecided),
            sample_time: *sample_time,
        };
        Self {
            hexapod: Hexapod::new(geometry),
            accuracy: *accuracy,
            parameters,
            counts,
            vessel: Sensor::default(),
            top: Sensor::default(),
            deck: None,
            idle: 0,
            mean: None,
            healthy: None,
            since: None,
            departure: None,
            found: None,
        }
    }

    /// Takes an angle from the bus, rad; returns `false` if no machine stands like that.
    pub fn put(&mut self, which: Inclination, angle: f64) -> bool {
        let (sensor, axis) = match which {
            Inclination::VesselRoll => (&mut self.vessel, 0),
            Inclination::VesselPitch => (&mut self.vessel, 1),
            Inclination::TopRoll => (&mut self.top, 0),
            Inclination::TopPitch => (&mut self.top, 1),
        };
        // NaN is not below it.
        let is_possible = angle.abs() < FRAC_PI_2;
        if is_possible {
            (sensor.angles[axis], sensor.fresh[axis]) = (angle, true);
        }
        is_possible
    }

    /// Cycles are missing: what comes next is not the mean's.
    pub const fn lose(&mut self) {
        self.mean = None;
    }

    /// Forgets everything: nobody knows what has happened.
    pub const fn forget(&mut self) {
        (self.deck, self.mean, self.healthy, self.since) = (None, None, None, None);
        (self.departure, self.found) = (None, None);
    }

    /// Whether the usual tilt is known, so that an alarm could be decided.
    pub fn is_judging(&self) -> bool {
        self.healthy.is_some_and(|it| it.age >= self.counts.settled)
    }

    /// Takes a cycle, and the angles that came in it.
    pub fn step(&mut self, legs: &[TiltLeg; LEGS]) -> TiltJudgement {
        let nothing = TiltJudgement::default();
        self.idle = self.idle.saturating_add(1).min(u32::MAX - 1);
        let [vessel, top] = [self.vessel.take(), self.top.take()];
        if self.idle < self.counts.every {
            return nothing;
        }
        let frozen = self.counts.frozen;
        let [vessel, top] =
            [vessel, top].map(|it| it.filter(|(_, repeated)| *repeated < frozen).map(|it| it.0));
        if self.idle > self.counts.gap {
            self.mean = None;
        }
        let Some((vessel, top)) = vessel.zip(top) else { return nothing };
        let is_healthy = legs.iter().all(|leg| leg.is_healthy);
        let has_parted = legs.iter().any(|leg| leg.parted.is_some());
        // A mean is either of a healthy machine or of one whose readings have parted.
        if !is_healthy && !has_parted {
            (self.mean, self.since) = (None, None);
            return nothing;
        }
        if is_healthy && self.since.is_some() {
            (self.mean, self.since) = (None, None);
        }
        let Some(found) = self.compare(vessel, top, legs) else { return nothing };
        let cycles = core::mem::take(&mut self.idle);
        let share = match self.mean {
            Some(_) => 1.0 - libm::exp(-f64::from(cycles) / self.counts.mean),
            None => 1.0,
        };
        self.follow(found.tilt, share, cycles);
        let mut change = None;
        if is_healthy {
            if legs.iter().any(|leg| leg.is_single) {
                change = self.judge_single(&found, legs, share, cycles);
            }
            // What a transducer may be off by is not the usual tilt.
            if self.departure.is_none() && self.found.is_none() {
                self.learn(found.tilt, cycles);
            }
        }
        let parted = match has_parted {
            true => self.weigh(&found, legs, share, cycles),
            false => [None; LEGS],
        };
        TiltJudgement { parted, change }
    }

    /// Follows the mean, of which the newest comparison is this `share`.
    fn follow(&mut self, tilt: [f64; 2], share: f64, cycles: u32) {
        let mean = self.mean.get_or_insert(Mean { tilt, age: 0 });
        mean.age = mean.age.saturating_add(cycles).min(u32::MAX - 1);
        for (mean, tilt) in mean.tilt.iter_mut().zip(tilt) {
            *mean += share * (tilt - *mean);
        }
    }

    /// Learns what is usual of a healthy machine.
    fn learn(&mut self, tilt: [f64; 2], cycles: u32) {
        let (counts, by) = (&self.counts, self.parameters);
        let usual = self.accuracy * self.accuracy;
        let healthy = self.healthy.get_or_insert(Healthy {
            tilt,
            covariance: [usual, 0.0, usual],
            age: 0,
            since: 0,
            measured: 0,
        });
        healthy.age = healthy.age.saturating_add(cycles).min(counts.healthy);
        let share = f64::from(cycles) / f64::from(healthy.age.max(cycles));
        for (own, tilt) in healthy.tilt.iter_mut().zip(tilt) {
            *own += share * (tilt - *own);
        }
        healthy.since = healthy.since.saturating_add(cycles).min(counts.healthy);
        let Some(mean) = self.mean.filter(|mean| mean.age >= counts.settled) else { return };
        if f64::from(healthy.since) < counts.mean {
            return;
        }
        healthy.since = 0;
        healthy.measure([mean.tilt[0] - healthy.tilt[0], mean.tilt[1] - healthy.tilt[1]], by);
    }

    /// The tilt between the deck by the lengths and that by its sensor, and what of it a metre of each cylinder would
    /// be; `None` without all lengths, or a deck that has them.
    fn compare(
        &mut self,
        vessel: [f64; 2],
        top: [f64; 2],
        legs: &[TiltLeg; LEGS],
    ) -> Option<Comparison> {
        let mut strokes = [0.0; LEGS];
        for (stroke, leg) in strokes.iter_mut().zip(legs) {
            *stroke = leg.length?;
        }
        let guess = self.deck.map_or_else(|| self.hexapod.neutral(), |it| posed(&it));
        let deck = self.hexapod.forward(&strokes, &guess).ok().map(|solution| solution.pose);
        self.deck = deck.map(|it| numbers(&it));
        let deck = deck?;
        let up = up(vessel) * deck.rotation();
        let by_lengths = inclination(&up);
        let tilt = [top[0] - by_lengths[0], top[1] - by_lengths[1]];
        Some(Comparison { tilt, deck, up, vessel })
    }

    /// Takes what each cylinder whose readings have parted would explain of the tilt, and compares.
    #[cold]
    fn weigh(
        &mut self,
        found: &Comparison,
        legs: &[TiltLeg; LEGS],
        share: f64,
        cycles: u32,
    ) -> [Option<f64>; LEGS] {
        let Some(slopes) = found.slopes(&self.hexapod) else { return [None; LEGS] };
        let since = self.since.get_or_insert_default();
        since.cycles = since.cycles.saturating_add(cycles).min(u32::MAX - 1);
        let mut is_known = true;
        for ((tilt, leg), slope) in since.tilts.iter_mut().zip(legs).zip(slopes) {
            let Some(parted) = leg.parted else {
                *tilt = None;
                continue;
            };
            is_known &= parted.is_some();
            let own = tilt.get_or_insert_default();
            for (own, slope) in own.iter_mut().zip(slope) {
                *own += share * (-slope * parted.unwrap_or_default() - *own);
            }
        }
        let since = *since;
        let healthy = self.healthy.filter(|it| it.age >= self.counts.settled);
        let mean = self.mean.filter(|it| it.age >= self.counts.settled);
        let Some((mean, healthy)) = mean.zip(healthy).filter(|_| is_known) else {
            return [None; LEGS];
        };
        let off = Vector2::new(mean.tilt[0] - healthy.tilt[0], mean.tilt[1] - healthy.tilt[1]);
        let seconds = f64::from(since.cycles) * self.counts.sample_time;
        let inverse = healthy.inverse(self.accuracy, &since.tilts, seconds, self.parameters);
        let Some(inverse) = inverse else {
            return [None; LEGS];
        };
        evidence(&off, &inverse, &since.tilts, self.parameters.beside)
    }
}

impl Tilt {
    /// Judges whether the tilt has departed from the usual one, and which single transducer explains that.
    fn judge_single(
        &mut self,
        found: &Comparison,
        legs: &[TiltLeg; LEGS],
        share: f64,
        cycles: u32,
    ) -> Option<TiltChange> {
        let by = self.parameters;
        let healthy = self.healthy.filter(|it| it.measured >= by.taught)?;
        let mean = self.mean.filter(|it| it.age >= self.counts.settled)?;
        let off = Vector2::new(mean.tilt[0] - healthy.tilt[0], mean.tilt[1] - healthy.tilt[1]);
        let mut tilts = [None; LEGS];
        tilts[0] = Some(off.into());
        // However long it stands, a tilt that is off does not become the usual one.
        let inverse = healthy.inverse(self.accuracy, &tilts, 0.0, by)?;
        if fit(&off, &inverse) < by.departed * by.departed {
            self.departure = None;
            return self.calm(cycles);
        }
        self.found.iter_mut().for_each(|it| it.calm = 0);
        let slopes = found.slopes(&self.hexapod)?;
        let departure = self.departure.get_or_insert(Departure::new(slopes));
        departure.follow(&slopes, share, cycles);
        if self.found.is_none() && departure.cycles > self.counts.undecided {
            // No transducer explains it, so it is the sensor or the machine: the usual tilt is learnt anew.
            self.forget();
            return None;
        }
        let since = f64::from(departure.cycles) * self.counts.sample_time;
        // The usual tilt is no longer followed, and the sensor's error of then comes to count as well: without it a drift of
        // 0.05 mm/s named a healthy cylinder.
        let accuracy = self.accuracy * libm::sqrt(1.0 + (since / by.healthy).min(1.0));
        let inverse = healthy.inverse(accuracy, &tilts, since, by)?;
        let single = legs.map(|leg| leg.is_single);
        let explained = departure.explain(&off, &inverse, single, since, by);
        let lasted = departure.last(explained.map(|it| it.leg), cycles);
        let error = explained.filter(|_| lasted >= self.counts.confirmed)?;
        // A second one beside it would turn the direction: the first one stays.
        let found = self.found.get_or_insert(Found { leg: error.leg, calm: 0 });
        (found.leg == error.leg).then_some(TiltChange::Moved(error))
    }

    /// Takes that the tilt is the usual one.
    fn calm(&mut self, cycles: u32) -> Option<TiltChange> {
        let found = self.found.as_mut()?;
        found.calm = found.calm.saturating_add(cycles).min(u32::MAX - 1);
        let returned = (found.calm >= self.counts.confirmed).then_some(found.leg)?;
        self.found = None;
        Some(TiltChange::Returned(returned))
    }
}

impl Sensor {
    /// Roll and pitch of this cycle, where both came, and for how many cycles they have been the same.
    fn take(&mut self) -> Option<([f64; 2], u32)> {
        self.repeated = self.repeated.saturating_add(1).min(u32::MAX - 1);
        if core::mem::take(&mut self.fresh) != [true; 2] {
            return None;
        }
        if self.angles != self.before {
            (self.before, self.repeated) = (self.angles, 0);
        }
        Some((self.angles, self.repeated))
    }
}

fn posed(numbers: &[f64; 6]) -> Pose {
    let [x, y, z, roll, pitch, yaw] = *numbers;
    Pose::new([x, y, z], [roll, pitch, yaw])
}

fn numbers(pose: &Pose) -> [f64; 6] {
    let ([x, y, z], [roll, pitch, yaw]) = (pose.translation.into(), pose.attitude.into());
    [x, y, z, roll, pitch, yaw]
}

#[cfg(test)]
mod tests;
