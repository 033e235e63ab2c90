//! The last transducer of a cylinder: the other one is out, or there is none.
//!
//! Nothing is left to compare it with but its own observer (thesis, section 5-7), so that observer alone names it. An
//! observer follows a step within a few samples and is quiet then, which is no evidence that the reading is right again.
//! A displacement of the last transducer is therefore latched, until the other one is back and agrees with it, until it
//! reads on the mechanical stop what it read there before, or until it steps back by as much, as the rod's way shows.
//!
//! The observer is evidence only in the motion in which it was quiet before. A controller that follows a faulty C1, or
//! a rod that it drives to its end, makes the observer of a sound C2 disagree, too.

mod departing;
mod displacement;
mod parameters;
mod shared;
mod stop;
mod supervising;
mod usual;

use super::{Cycle, CylinderDesign};
use crate::sample::Transducer;
use crate::state::whole;
pub use displacement::Latch;
use displacement::Watched;
pub use parameters::LastParameters;
pub use shared::SharedDeparture;
use stop::Rest;
use usual::{MotionRange, UsualMotion};

/// Supervision of the last transducer of one cylinder.
#[derive(Clone, Copy, Debug)]
pub struct LastOne {
    of: [Watched; 2],
    rests: [Rest; 2],
    usual: UsualMotion,
    /// R3 of the cycle before, m.
    difference: Option<f64>,
    /// Whether the other one was out by the difference alone when the displacement that is tried began.
    was_apart: bool,
    /// Whether the last one has stepped to where the other one had been displaced to, so that they agree and are both wrong.
    has_joined: bool,
    /// What both transducers are off by alike.
    pub(super) shared: Option<SharedDeparture>,
    /// What both innovations have in common.
    together: Watched,
    /// Whether both observers were raised in the cycle before.
    are_raised: bool,
    /// Whether anything was found in the cycle before, or the rod stood on its stop.
    is_attended: bool,
}

whole! { LastOne { of, rests, usual, difference, was_apart, has_joined, shared, together, are_raised, is_attended } }

impl Default for LastOne {
    fn default() -> Self {
        let nothing = MotionRange::NONE;
        let usual =
            UsualMotion { range: nothing, tried: nothing, newest: 0.0, calm: 0, unusual: 0 };
        Self {
            of: Default::default(),
            rests: Default::default(),
            usual,
            difference: None,
            was_apart: false,
            has_joined: false,
            shared: None,
            together: Watched::default(),
            are_raised: false,
            is_attended: false,
        }
    }
}

impl LastOne {
    /// Lowest and highest length while nothing was found, m.
    #[inline]
    pub const fn been(&self) -> [f64; 2] {
        self.usual.range.been
    }

    /// Whether transducer `i` is latched.
    pub const fn is_latched(&self, i: usize) -> bool {
        self.of[i].latch.is_some()
    }

    /// Whether transducer `i` is latched because it departs from dead reckoning.
    pub fn departs(&self, i: usize) -> bool {
        self.of[i].latch.is_some_and(|latch| latch.departs.is_some())
    }

    /// Whether either is latched.
    #[inline]
    pub const fn any_latched(&self) -> bool {
        self.is_latched(0) || self.is_latched(1)
    }

    /// Whether the finding of the observer of transducer `i` is that transducer's own.
    pub const fn names(&self, i: usize) -> bool {
        self.of[i].is_named || self.is_latched(i)
    }

    /// Whether transducer `i` is named, but its displacement is not confirmed: it may be a single wild sample.
    pub const fn is_tentative(&self, i: usize) -> bool {
        self.of[i].is_named && !self.is_latched(i)
    }

    /// Forgets what the next cycle had to confirm, after a time of which nothing is known. What is latched stands.
    pub fn interrupt(&mut self) {
        for watched in self.of.iter_mut().chain([&mut self.together]) {
            (watched.tried, watched.aftermath, watched.beyond) = (None, 0, 0);
        }
        for rest in &mut self.rests {
            rest.end();
        }
    }

    /// Takes that the newest displacement of transducer `i` was a wild reading, of which its observer has kept nothing.
    pub fn dismiss(&mut self, i: usize) {
        for watched in [&mut self.of[i], &mut self.together] {
            (watched.tried, watched.beyond) = (None, watched.beyond & !1);
        }
    }

    /// Takes a cycle in which nothing was found.
    fn forget(&mut self) {
        self.of = self.of.map(|it| Watched { power: it.power, ..Watched::default() });
        (self.together, self.are_raised) = (Watched::default(), false);
    }

    /// Takes an innovation of transducer `i` while it was not the last one, m, which counts for `cycles` cycles.
    #[inline]
    fn measure(&mut self, i: usize, residual: Option<f64>, cycles: u32, design: &CylinderDesign) {
        let Some(residual) = residual else { return };
        let most = design.last.counted * design.bank.observer.high;
        let (counted, power) = (residual.abs().min(most), &mut self.of[i].power);
        let share = f64::from(cycles) * design.bank.sample_time / design.last.memory;
        *power += share * (counted * counted - *power);
    }

    /// Innovation of transducer `i` that is well above the usual ones, m.
    fn usual_step(&self, i: usize, design: &CylinderDesign) -> f64 {
        design.last.well_above * libm::sqrt(self.of[i].power)
    }

    /// Innovation from which on the last transducer, `i`, is displaced, m. On a machine that the model fits badly a threshold
    /// alone is no evidence.
    pub fn least_step(&self, i: usize, design: &CylinderDesign) -> f64 {
        design.bank.observer.high.max(self.usual_step(i, design))
    }

    /// Ends the latches, because there is evidence that the readings are right. Whether both are off alike is another question.
    fn release(&mut self) {
        for watched in &mut self.of {
            (watched.latch, watched.is_named) = (None, false);
        }
        self.has_joined = false;
    }

    /// What is latched of transducer `i`.
    pub const fn latch(&self, i: usize) -> Option<Latch> {
        self.of[i].latch
    }

    /// Whether transducer `i` has been the last one since before what is found now.
    fn is_last(&self, i: usize, design: &CylinderDesign) -> bool {
        !design.has(Transducer::ALL[1 - i]) || self.of[1 - i].out > design.coincidence_cycles
    }

    /// The only transducer that is left, if it is not latched.
    pub fn alone(&self, design: &CylinderDesign) -> Option<usize> {
        let is_alone = |i: &usize| {
            design.has(Transducer::ALL[*i]) && self.is_last(*i, design) && self.of[*i].out == 0
        };
        (0..2).find(is_alone)
    }

    /// Whether the rod is expected where it was not while nothing was found, such as on a stop, which is no fault of a
    /// reading.
    fn is_elsewhere(&self, cycle: &Cycle, design: &CylinderDesign) -> bool {
        let [lowest, highest] = self.been();
        let (half, near) = (0.5 * (highest - lowest), design.last.near);
        let [least, most] = design.inner_stroke();
        let lowest = (lowest - half).max(least).min(lowest - near);
        let highest = (highest + half).min(most).max(highest + near);
        let is_beyond = |i: usize| {
            let innovation = cycle.residuals.r[i].unwrap_or_default();
            let expected = cycle.good[i].map(|it| it.position - innovation);
            let place = expected.map(|it| match i {
                0 => it,
                _ => design.comparator.corrected(it),
            });
            place.is_some_and(|it| !(lowest..=highest).contains(&it))
        };
        (0..2).any(|i| self.is_last(i, design) && !self.is_latched(i) && is_beyond(i))
    }
}
