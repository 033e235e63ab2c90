//! The readings of a cylinder against dead reckoning: the way that its oil, or its command alone, has moved the rod.
//!
//! An observer follows a drift of the reading that corrects it: where nothing was left to compare with, drifts of 50 mm/s
//! went on until the reading left its range. Nothing corrects dead reckoning. By the command it is off by some millimetres
//! a second, by the load, the oil and the bends of the valve, and by more the faster the rod goes; by the oil that passes
//! the valve it is off by less. An error of the reading is therefore looked for in windows of half a second to a minute,
//! and compared with the usual error of such a window.
//!
//! Two readings that agree are judged by what both are off by: a fault that they have in common, of a supply or an input
//! card, leaves their difference at zero, and the observers follow it.

mod course;
mod free_model;
mod parameters;

use super::CylinderDesign;
use crate::estimate::mean::Mean;
use crate::observe::observer::ObserverDesign;
use crate::sample::Transducer;
use crate::state::state;
use crate::time;
use course::ReckonedCourse;
pub(super) use course::{Compared, CourseError, CourseJump, common};
use free_model::FreeModel;
pub use parameters::ReckoningParameters;
use parameters::{LONGEST_WINDOW_TICKS, WINDOWS};

/// What gives the rod's way, the best one first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WaySource {
    /// The oil that passes the valve, by spool and pressures: the way since the cycle before.
    Oil,
    /// The drive that was learnt, by the command: the way until the next cycle.
    Drive,
    /// The model (4-1), likewise.
    Model,
}

impl WaySource {
    /// The best one of a cylinder. Beside a second transducer the model would cost more than it gives.
    pub fn of(design: &CylinderDesign) -> Option<Self> {
        let is_driven = design.sequential.as_ref().is_some_and(|it| it.pair.is_some());
        let is_single = !Transducer::ALL.into_iter().all(|it| design.has(it));
        match design.process.as_ref().is_some_and(|it| it.flow.is_some()) {
            true => Some(Self::Oil),
            false if is_driven => Some(Self::Drive),
            false if is_single => Some(Self::Model),
            false => None,
        }
    }
}

/// Dead reckoning of one cylinder.
#[derive(Clone, Debug)]
pub struct DeadReckoning {
    parameters: &'static ReckoningParameters,
    source: WaySource,
    /// Sample time, s.
    sample_time: f64,
    /// No error is one below this, m.
    least: f64,
    /// Cycles of a tick.
    tick: u32,
    /// Ticks of a mean, and of the bias.
    memory: u32,
    bias_memory: u32,
    /// Cycles in which the model loses what it began with.
    settling: u32,
    model: FreeModel,
    /// Of C1 and of C2.
    courses: [ReckonedCourse; 2],
    /// Way of the rod by its command, and the same without its direction, m.
    way: f64,
    distance: f64,
    /// Distance at the newest ticks, a ring.
    distances: [f64; LONGEST_WINDOW_TICKS],
    /// Part of the way that the rod goes until the next cycle, m.
    ahead: f64,
    next: usize,
    held: usize,
    /// Cycles since the newest tick.
    cycles: u32,
    /// Ticks since anything was found.
    calm: u32,
    /// Mean square of the error in each window while nothing was found, m².
    usual: [Mean; WINDOWS],
    /// Mean distance of a tick then, m.
    pace: Mean,
    /// Mean error of a tick, m, which is followed: oil that leaks more as it warms, or a valve whose null moves, would add up
    /// to more than all else.
    bias: Mean,
}

state! {
    DeadReckoning { model, courses, way, distance, distances, ahead, next, held, cycles, calm, usual, pace, bias }
    but { parameters, source, sample_time, least, tick, memory, bias_memory, settling }
    sound |it| it.next < LONGEST_WINDOW_TICKS && it.held <= LONGEST_WINDOW_TICKS
}

impl DeadReckoning {
    /// Where anything gives the rod's way.
    pub fn of(design: &CylinderDesign) -> Option<Self> {
        let source = WaySource::of(design)?;
        let (parameters, sample_time) = (design.reckoning, design.bank.sample_time);
        let least = parameters.least * design.critical;
        Some(Self::new(parameters, source, sample_time, least))
    }

    fn new(
        parameters: &'static ReckoningParameters,
        source: WaySource,
        sample_time: f64,
        least: f64,
    ) -> Self {
        let settling = time::cycles(parameters.settling, sample_time);
        Self {
            parameters,
            source,
            sample_time,
            least,
            tick: time::cycles(parameters.interval, sample_time).max(1),
            memory: time::cycles(parameters.memory, parameters.interval),
            bias_memory: time::cycles(parameters.bias, parameters.interval),
            settling,
            model: FreeModel::new(settling),
            courses: [ReckonedCourse::NONE; 2],
            way: 0.0,
            distance: 0.0,
            distances: [0.0; LONGEST_WINDOW_TICKS],
            ahead: 0.0,
            next: 0,
            held: 0,
            cycles: 0,
            calm: 0,
            usual: [Mean::default(); WINDOWS],
            pace: Mean::default(),
            bias: Mean::default(),
        }
    }

    /// Ends the stretch in which the way is known. What the rod moves from the tick before to the next stretch is no error.
    pub fn pause(&mut self) {
        self.courses.iter_mut().for_each(|course| course.origin = None);
    }

    /// Drops the errors so far, which are the cylinder's.
    pub fn forget(&mut self) {
        self.pause();
        (self.held, self.calm) = (0, 0);
    }

    pub fn goes_by(&self, source: WaySource) -> bool {
        self.source == source
    }

    /// Velocity until the next cycle by the model that `by` follows, m/s, for a rod of this `length`, m; `None` where that is
    /// not known, or the model has not settled. Where it is not `open`, the model begins anew.
    pub fn free_velocity(
        &mut self,
        open: bool,
        by: &ObserverDesign,
        length: Option<f64>,
        command: Option<f64>,
    ) -> Option<f64> {
        if !open {
            self.model = FreeModel::new(self.settling);
        }
        self.model.step(by, length.filter(|_| open)?, command)
    }

    /// Begins a cycle. Returns whether it is a tick.
    #[inline]
    pub const fn begin(&mut self) -> bool {
        self.cycles += 1;
        let is_tick = self.cycles >= self.tick;
        if is_tick {
            self.cycles = 0;
        }
        is_tick
    }

    /// Takes the velocity from one cycle to the next one, m/s.
    #[inline]
    pub fn go(&mut self, velocity: Option<f64>) {
        let way = velocity.map(|velocity| self.sample_time * velocity);
        match way {
            Some(way) => (self.way, self.distance) = (self.way + way, self.distance + way.abs()),
            None => self.pause(),
        }
        self.ahead = if self.source == WaySource::Oil { 0.0 } else { way.unwrap_or_default() };
    }

    /// What the readings, m, of these transducers are off by alike since the last tick but one; `None` where the way is not
    /// known since, or too little was learnt. Of the last tick itself a jump may be part already, which is known to be none
    /// of a wild reading three cycles later.
    pub fn jump(&self, of: [usize; 2], lengths: [Option<f64>; 2]) -> Option<CourseJump> {
        let since = (self.next + LONGEST_WINDOW_TICKS - 2) % LONGEST_WINDOW_TICKS;
        let way = self.way - self.ahead;
        let error = |i: usize| {
            let ReckonedCourse { origin, errors, .. } = &self.courses[i];
            Some(lengths[i]? - way - (*origin)? - errors[since])
        };
        let limit = self.limit(1, self.distance - self.distances[since])?;
        let error = common([error(of[0])?, error(of[1])?]);
        (self.held >= 2).then_some(CourseJump { error, limit })
    }

    /// Takes the readings of a tick, m: judges what is `compared`, and learns the usual errors while nothing is found of the
    /// cylinder (`is_calm`).
    pub fn judge(
        &mut self,
        readings: [Option<f64>; 2],
        compared: Compared,
        is_calm: bool,
    ) -> Option<CourseError> {
        self.way += self.bias.value();
        let goes_on = [0, 1].map(|i: usize| self.courses[i].follow(readings[i], self.way));
        if goes_on == [false; 2] {
            return None;
        }
        self.calm = if is_calm { self.calm.saturating_add(1) } else { 0 };
        let of = if let Compared::Alone(i) = compared { [i; 2] } else { [0, 1] };
        let is_judged = compared != Compared::Neither;
        let (mut beyond, mut found) = ([0_u8; 2], None);
        for window in 0..WINDOWS {
            let ticks = 1 << window;
            // The bias is followed all the same: a pair that differs for half an hour, as it warms, may agree again.
            if ticks > self.held || !is_judged && window > 0 {
                break;
            }
            // Windows that overlap are no lessons of their own.
            let is_lesson =
                is_judged && self.calm as usize > ticks && self.next.is_multiple_of(ticks);
            let since = (self.next + LONGEST_WINDOW_TICKS - ticks) % LONGEST_WINDOW_TICKS;
            let error = common(of.map(|i| self.courses[i].error - self.courses[i].errors[since]));
            // Nearly always it is far below any limit.
            let is_small = !is_judged || error.abs() <= 0.5 * self.least;
            let gone = self.distance - self.distances[since];
            let limit = if is_small { None } else { self.limit(window, gone) };
            let limit = limit.unwrap_or(f64::INFINITY);
            if is_lesson {
                // A drift would become usual before it is found.
                let counted = error.abs().min(0.5 * limit);
                self.usual[window].add(counted * counted, self.memory >> window);
            }
            if window == 0 {
                let followed = error.clamp(-0.5 * limit, 0.5 * limit);
                self.bias.add(self.bias.value() + followed, self.bias_memory);
            }
            let (side, is_beyond) = (usize::from(error < 0.0), error.abs() > limit);
            beyond[side] |= u8::from(is_beyond) << window;
            // A wild reading at a tick is beyond it once in each direction.
            if is_beyond && self.courses[of[0]].beyond[side] & beyond[side] != 0 {
                let seconds = self.parameters.interval * f64::from(ticks as u32);
                found = Some(CourseError { error, limit, seconds });
            }
        }
        if self.calm > 1 && self.held > 0 {
            let before = (self.next + LONGEST_WINDOW_TICKS - 1) % LONGEST_WINDOW_TICKS;
            self.pace.add(self.distance - self.distances[before], self.memory);
        }
        self.courses.iter_mut().for_each(|course| course.beyond = [0; 2]);
        self.courses[of[0]].beyond = beyond;
        self.push();
        found
    }

    /// Largest error of a window in which the rod has `gone` so far, m; `None` where too little was learnt.
    fn limit(&self, window: usize, gone: f64) -> Option<f64> {
        let (p, ticks) = (self.parameters, f64::from(1_u32 << window));
        let trials = f64::from(self.usual[window].count());
        if trials < p.trials {
            return None;
        }
        let variance = self.usual[window].value() * (1.0 + p.doubt / trials);
        let pace = (gone / (ticks * self.pace.value())).max(1.0);
        Some((p.deviations * pace * libm::sqrt(variance)).max(self.least))
    }

    fn push(&mut self) {
        for course in &mut self.courses {
            course.errors[self.next] = course.error;
        }
        self.distances[self.next] = self.distance;
        self.next = (self.next + 1) % LONGEST_WINDOW_TICKS;
        self.held = (self.held + 1).min(LONGEST_WINDOW_TICKS);
    }
}

#[cfg(test)]
mod tests;
