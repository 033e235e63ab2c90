//! From innovations of the last transducer to a displacement of it.

use super::parameters::LastParameters;
use crate::monitor::cylinder::CylinderDesign;
use crate::monitor::cylinder::dead_reckoning::CourseJump;
use crate::state::whole;
use crate::time::{self, Timestamp};
use crate::verdict::Fault;

/// A displacement of the last transducer, found once and not refuted since.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Latch {
    pub fault: Fault,
    /// Innovation, or error of dead reckoning, that showed it, m, signed.
    pub residual: f64,
    /// What that exceeded, m.
    pub threshold: f64,
    /// What its steps add up to, m; `None` where it did not begin with a step.
    pub off: Option<f64>,
    /// Whether the last of them has brought it back, as the rod's way shows.
    pub is_back: bool,
    /// Since when the reading departs from dead reckoning, where that showed it.
    pub departs: Option<Timestamp>,
}

whole! { Latch { fault, residual, threshold, off, is_back, departs } }

/// A displacement that was confirmed, m, signed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Displacement {
    /// The reading stays there.
    Step(f64),
    /// The newest of many innovations.
    Noise(f64),
}

impl Displacement {
    /// m, signed.
    pub const fn innovation(self) -> f64 {
        let (Self::Step(innovation) | Self::Noise(innovation)) = self;
        innovation
    }

    /// Its size, m, if it is a step.
    pub const fn step(self) -> Option<f64> {
        match self {
            Self::Step(size) => Some(size),
            Self::Noise(_) => None,
        }
    }
}

/// An innovation that may be a displacement.
#[derive(Clone, Copy, Debug)]
pub struct Tried {
    /// m, signed.
    pub first: f64,
    /// Innovations since.
    pub age: u32,
}

whole! { Tried { first, age } }

/// What is known of one transducer as the last one.
#[derive(Clone, Copy, Debug, Default)]
pub struct Watched {
    /// Cycles for which it has been out itself.
    pub out: u32,
    /// Mean square of its innovations while it was not the last one, m².
    pub power: f64,
    /// Whether the present finding of its observer is its own.
    pub is_named: bool,
    /// A displacement that the next innovations have to confirm.
    pub tried: Option<Tried>,
    /// What dead reckoning shows of it, if it shows the same.
    pub jump: Option<CourseJump>,
    /// Cycles in which the innovations are what is left of a wild sample.
    pub aftermath: u32,
    /// Newest innovations beyond the limit, one bit each.
    pub beyond: u64,
    pub latch: Option<Latch>,
}

whole! { Watched { out, power, is_named, tried, jump, aftermath, beyond, latch } }

/// What an innovation of the last transducer is compared with.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Innovation from which on it is a displacement, m.
    pub least: f64,
    /// Number of those of the newest 64 that are noise.
    pub noise: u32,
    /// Gain of the observer's predicted length.
    pub gain: f64,
    /// Cycles for which a wild sample is in the innovations.
    pub aftermath: u32,
    /// Innovations after the first that confirm a displacement.
    pub confirm: u32,
    /// See [`LastParameters::stays`] and [`LastParameters::returned`].
    pub stays: f64,
    pub returned: f64,
}

impl Limits {
    /// Those of transducer `i`.
    pub fn of(design: &CylinderDesign, i: usize) -> Self {
        let (parameters, observer): (&LastParameters, _) = (design.last, &design.observers[i]);
        Self {
            least: design.bank.observer.high,
            noise: parameters.noise,
            gain: observer.l[(0, 0)],
            aftermath: 2 * observer.recovery(),
            stays: parameters.stays,
            returned: parameters.returned,
            confirm: time::samples(parameters.confirmed, design.bank.sample_time),
        }
    }
}

impl Watched {
    /// Takes an innovation of the last transducer, m. Returns a displacement that is confirmed.
    ///
    /// After a step of s the next innovation is (1 − gain) s, and after a single wild sample −gain s: what is left of s is
    /// their sum. Two wild samples side by side come back in the one after. Noise comes back, too, but goes on.
    pub fn confirm(&mut self, residual: Option<f64>, limits: &Limits) -> Option<Displacement> {
        self.aftermath = self.aftermath.saturating_sub(1);
        let before = self.tried.take();
        let Some(residual) = residual else {
            // It was displaced, and did not come again.
            return before.map(|tried| Displacement::Step(tried.first));
        };
        let is_beyond = residual.abs() > limits.least;
        self.beyond = self.beyond << 1 | u64::from(is_beyond);
        if let Some(Tried { first, age }) = before {
            let part = residual / first;
            let stays =
                if age == 0 { part + limits.gain > limits.stays } else { part > -limits.returned };
            if stays && age + 1 >= limits.confirm {
                return Some(Displacement::Step(first));
            }
            self.tried = stays.then_some(Tried { first, age: age + 1 });
            self.aftermath = if stays { self.aftermath } else { limits.aftermath };
        } else if is_beyond && self.aftermath == 0 {
            self.tried = Some(Tried { first: residual, age: 0 });
        } else if is_beyond {
            // Another wild sample shortly after the first: its own aftermath has begun.
            self.aftermath = limits.aftermath;
        }
        let is_noise = is_beyond && self.beyond.count_ones() >= limits.noise;
        is_noise.then_some(Displacement::Noise(residual))
    }

    /// Takes what dead reckoning shows in the cycle in which a displacement is tried first. By a model that fits badly a rod at
    /// work has innovations like those of a jump, too.
    pub fn compare(&mut self, shown: Option<CourseJump>, stays: f64) {
        let Some(Tried { first, .. }) = self.tried else { return };
        let is_same = |it: &CourseJump| {
            it.error.abs() > it.limit && (stays..1.0 / stays).contains(&(it.error / first))
        };
        self.jump = shown.filter(is_same);
    }
}
