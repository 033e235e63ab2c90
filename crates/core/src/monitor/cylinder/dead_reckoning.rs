//! The last transducer of a cylinder against dead reckoning: the way that the command alone has moved the rod.
//!
//! An observer follows a drift of the reading that corrects it, and is quiet meanwhile: where nothing was left to compare
//! with, drifts of 50 mm/s went on until the reading left its range. Nothing corrects dead reckoning. It is off by
//! some millimetres a second, by the load, the oil and the bends of the valve, and by more the faster the rod goes. So the
//! error of a reading is looked for in windows of half a second to a minute, beside what is usual in windows of this length.

use super::{Cylinder, Evaluation, TRANSDUCERS};
use crate::estimate::mean::Mean;
use crate::monitor::gate::Opening;
use crate::observe::observer::{Measurement, ObserverDesign};
use crate::sequential::{Pair, Sequential};
use crate::state::{state, whole};
use crate::time;
use crate::verdict::VerdictParameters;

/// Windows, each twice as long as the one before.
const WINDOWS: usize = 8;

/// Ticks of the longest one.
const HELD: usize = 1 << (WINDOWS - 1);

/// What a reading has departed by from dead reckoning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CourseError {
    /// m, signed.
    pub error: f64,
    /// What it was compared with, m.
    pub limit: f64,
}

/// The readings of one transducer less dead reckoning.
#[derive(Clone, Debug)]
struct Course {
    /// Newest reading, m, if the way since is known.
    reading: Option<f64>,
    /// Way by the command since, m.
    way: f64,
    /// Error of dead reckoning so far, m.
    error: f64,
    /// That at the newest ticks, a ring.
    errors: [f64; HELD],
    /// Windows, one bit each, in which the error was above its limit at the newest tick, and those in which it was below.
    beyond: [u8; 2],
}

state! { Course { reading, way, error, errors, beyond } }

impl Course {
    const NONE: Self =
        Self { reading: None, way: 0.0, error: 0.0, errors: [0.0; HELD], beyond: [0; 2] };

    /// Takes the reading of a cycle, m. Without one the way goes on.
    fn take(&mut self, reading: Option<f64>) {
        let Some(reading) = reading else { return };
        if let Some(before) = self.reading.replace(reading) {
            self.error += reading - before - self.way;
        }
        self.way = 0.0;
    }
}

/// Velocity and load pressure by the model (4-1) alone, where no drive was learnt.
#[derive(Clone, Copy, Debug)]
struct FreeModel {
    /// m/s and bar.
    x: [f64; 2],
    /// Newest command, m/s.
    command: f64,
    /// Cycles until nothing is left of what it began with.
    settling: u32,
}

whole! { FreeModel { x, command, settling } }

impl FreeModel {
    const fn new(settling: u32) -> Self {
        Self { x: [0.0; 2], command: 0.0, settling }
    }

    /// Velocity until the next cycle, m/s, once it has settled.
    fn step(&mut self, by: &ObserverDesign, length: f64, command: Option<f64>) -> Option<f64> {
        self.command = command.unwrap_or(self.command);
        let [velocity, pressure] = self.x;
        let next = |row: usize| {
            by.a[(row, 0)] * length
                + by.a[(row, 1)] * velocity
                + by.a[(row, 2)] * pressure
                + by.b[row] * self.command
        };
        self.x = [next(1), next(2)];
        if !self.x[0].is_finite() {
            // It never settles.
            *self = Self::new(u32::MAX / 4);
        }
        self.settling = self.settling.saturating_sub(1);
        (self.settling == 0).then_some(velocity)
    }
}

/// Dead reckoning of one cylinder.
#[derive(Clone, Debug)]
pub struct DeadReckoning {
    /// Sample time, s.
    sample_time: f64,
    /// Cycles of a tick.
    tick: u32,
    /// Ticks of a mean.
    memory: u32,
    /// Cycles in which the model loses what it began with.
    settling: u32,
    model: FreeModel,
    courses: [Course; 2],
    /// Distance that the rod has gone by its command, either way, m.
    distance: f64,
    /// That at the newest ticks, a ring.
    distances: [f64; HELD],
    next: usize,
    held: usize,
    cycles: u32,
    /// Ticks since anything was found.
    calm: u32,
    /// Mean square of the error in each window while nothing was found, m².
    usual: [Mean; WINDOWS],
    /// Mean distance of a tick then, m.
    pace: Mean,
}

state! {
    DeadReckoning { model, courses, distance, distances, next, held, cycles, calm, usual, pace }
    but { sample_time, tick, memory, settling }
    sound |it| it.next < HELD && it.held <= HELD
}

/// What a window's error is judged by.
#[derive(Clone, Copy, Debug)]
struct Bounds<'a> {
    parameters: &'a VerdictParameters,
    /// No error is one below this, m.
    least: f64,
}

impl DeadReckoning {
    pub fn new(sample_time: f64, parameters: &VerdictParameters) -> Self {
        let settling = time::cycles(parameters.reckoned_settling, sample_time);
        Self {
            sample_time,
            tick: time::cycles(parameters.reckoned, sample_time).max(1),
            memory: time::cycles(parameters.reckoned_memory, parameters.reckoned),
            settling,
            model: FreeModel::new(settling),
            courses: [Course::NONE; 2],
            distance: 0.0,
            distances: [0.0; HELD],
            next: 0,
            held: 0,
            cycles: 0,
            calm: 0,
            usual: [Mean::default(); WINDOWS],
            pace: Mean::default(),
        }
    }

    /// Takes that the way until the next readings is not known.
    pub fn pause(&mut self) {
        self.courses.iter_mut().for_each(|course| course.reading = None);
    }

    /// Takes that the errors so far are none of a transducer.
    fn forget(&mut self) {
        self.pause();
        (self.held, self.calm, self.cycles) = (0, 0, 0);
    }

    /// Takes the readings of a cycle, m, and the velocity until the next one, m/s. Returns whether a tick is due.
    #[inline]
    fn step(&mut self, readings: [Option<f64>; 2], velocity: Option<f64>) -> bool {
        for (course, reading) in self.courses.iter_mut().zip(readings) {
            course.take(reading);
        }
        let Some(velocity) = velocity else {
            self.pause();
            return false;
        };
        let way = self.sample_time * velocity;
        self.courses.iter_mut().for_each(|course| course.way += way);
        self.distance += way.abs();
        self.cycles += 1;
        self.cycles >= self.tick
    }

    /// A tick: judges transducer `alone`, and learns what is usual while nothing `is_calm`.
    fn judge(
        &mut self,
        alone: Option<usize>,
        is_calm: bool,
        bounds: Bounds<'_>,
    ) -> Option<CourseError> {
        self.cycles = 0;
        self.calm = if is_calm { self.calm.saturating_add(1) } else { 0 };
        let i = alone.unwrap_or_else(|| usize::from(self.courses[0].reading.is_none()));
        let (mut beyond, mut found) = ([0_u8; 2], None);
        for window in 0..WINDOWS {
            let ticks = 1 << window;
            if ticks > self.held {
                break;
            }
            let since = (self.next + HELD - ticks) % HELD;
            let error = self.courses[i].error - self.courses[i].errors[since];
            let gone = self.distance - self.distances[since];
            // Beside another reading nothing is learnt while a transducer is at fault, and no error has to be bounded.
            let limit = alone.and_then(|_| self.limit(window, gone, bounds));
            let most = limit.unwrap_or(f64::INFINITY);
            if self.calm as usize > ticks {
                // A drift of an only transducer would be usual before it is found.
                let counted = error.abs().min(0.5 * most);
                self.usual[window].add(counted * counted, self.memory);
            }
            let (side, is_beyond) = (usize::from(error < 0.0), error.abs() > most);
            beyond[side] |= u8::from(is_beyond) << window;
            // A wild reading at a tick is beyond it once in each direction.
            if is_beyond && self.courses[i].beyond[side] & beyond[side] != 0 {
                found = Some(CourseError { error, limit: most });
            }
        }
        let before = (self.next + HELD - 1) % HELD;
        if self.calm > 1 && self.held > 0 {
            let gone = self.distance - self.distances[before];
            self.pace.add(gone, self.memory);
        }
        self.courses.iter_mut().for_each(|course| course.beyond = [0; 2]);
        if let Some(i) = alone {
            self.courses[i].beyond = beyond;
        }
        self.push();
        found
    }

    /// What the error in a window may be in which the rod has `gone` so far, m; `None` where it is not known.
    fn limit(&self, window: usize, gone: f64, bounds: Bounds<'_>) -> Option<f64> {
        let Bounds { parameters, least } = bounds;
        let ticks = f64::from(1_u32 << window);
        // Windows overlap: only those that follow each other are trials.
        let trials = f64::from(self.usual[window].count()) / ticks;
        if trials < parameters.reckoned_trials {
            return None;
        }
        let variance = self.usual[window].value() * (1.0 + parameters.reckoned_doubt / trials);
        let pace = (gone / (ticks * self.pace.value())).max(1.0);
        Some((parameters.reckoned_deviations * pace * libm::sqrt(variance)).max(least))
    }

    fn push(&mut self) {
        for course in &mut self.courses {
            course.errors[self.next] = course.error;
        }
        self.distances[self.next] = self.distance;
        self.next = (self.next + 1) % HELD;
        self.held = (self.held + 1).min(HELD);
    }
}

impl Cylinder {
    /// Dead reckoning, where the velocity is known by a drive that was learnt, or by the model where there is one transducer.
    pub(super) fn reckoning_of(&self) -> Option<DeadReckoning> {
        let is_driven = self.sequential.as_deref().is_some_and(|it| it.pair().is_some());
        let is_single = !TRANSDUCERS.into_iter().all(|it| self.has(it));
        let parameters = self.design.bank.parameters;
        let sample_time = self.design.bank.sample_time;
        (is_driven || is_single).then(|| DeadReckoning::new(sample_time, parameters))
    }

    /// Takes the readings of a cycle where the drive has given the velocity.
    #[inline]
    pub(super) fn reckon_by_drive(&mut self, good: [Option<Measurement>; 2]) {
        let sequential = self.sequential.as_deref();
        self.reckon(good, sequential.and_then(Sequential::pair).and_then(Pair::velocity));
    }

    /// The same of a cylinder with one transducer, by the model alone.
    pub(super) fn reckon_by_model(
        &mut self,
        now: Evaluation,
        good: [Option<Measurement>; 2],
        command: Option<f64>,
    ) {
        let is_open = now.gate == Opening::Open && self.command_missing < self.design.command_stale;
        let Some(reckoning) = &mut self.reckoning else { return };
        if !is_open {
            reckoning.model = FreeModel::new(reckoning.settling);
        }
        let by = &self.design.observers[0];
        let length = good[0].or(good[1]).filter(|_| is_open);
        let velocity = length.and_then(|it| reckoning.model.step(by, it.position, command));
        self.reckon(good, velocity);
    }

    #[inline]
    fn reckon(&mut self, good: [Option<Measurement>; 2], velocity: Option<f64>) {
        // The curve of a drive was not learnt beyond its lesson: in a sea of 3 m it was off by three times the most of
        // one of 2 m. And a stop holds the rod, however it is commanded, whichever reading shows that it is there.
        let is_known = !self.commands.is_beyond()
            && !good.iter().flatten().any(|it| self.is_near_end(it.position))
            && !self.has_idle_valve();
        let Some(reckoning) = &mut self.reckoning else { return };
        let readings = good.map(|it| it.map(|it| it.position));
        if reckoning.step(readings, velocity.filter(|_| is_known)) {
            self.judge_reckoning();
        }
    }

    /// Judges a last transducer at a tick, and latches one that departs from dead reckoning.
    #[inline(never)]
    fn judge_reckoning(&mut self) {
        let parameters = self.design.bank.parameters;
        let bounds = Bounds { parameters, least: parameters.reckoned_least * self.design.critical };
        let is_explained = self.process.as_deref().is_some_and(|it| it.alarm().is_some());
        let (alone, is_calm) = (self.alone(), !self.finds_anything());
        let Some(reckoning) = &mut self.reckoning else { return };
        if is_explained {
            reckoning.forget();
        } else if let Some((i, departure)) = alone.zip(reckoning.judge(alone, is_calm, bounds)) {
            self.latch_departure(i, departure);
        }
    }
}

#[cfg(test)]
mod tests;
