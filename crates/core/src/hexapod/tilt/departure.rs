//! A departure of the tilt from the usual one, and the cylinder whose only transducer explains it.
//!
//! Nothing is there to compare a single transducer with, so the tilt itself has to depart. A C1 that reads a cylinder too
//! long by d moves it by −(∂attitude/∂ℓ) d. Since d is unknown, with either sign, only the direction identifies the
//! cylinder: six axes in the plane of roll and pitch, which lie about 30° apart on a platform of threefold symmetry.

use super::super::{LEGS, TiltParameters};
use super::comparison::are_finite;
use crate::state::whole;
use nalgebra::{Matrix2, Vector2};

/// What the tilt has changed to on a cylinder with a single transducer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TiltChange {
    /// Its C1 is off; repeated while it is, with the newest size.
    Moved(TiltError),
    /// The tilt of this leg, of index 0 to 5, is the usual one again.
    Returned(usize),
}

impl TiltChange {
    /// Index of the leg, 0 to 5.
    pub const fn leg(&self) -> usize {
        match self {
            Self::Moved(error) => error.leg,
            Self::Returned(leg) => *leg,
        }
    }
}

/// An error of a single transducer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TiltError {
    /// Index of the leg, 0 to 5.
    pub leg: usize,
    /// By how much C1 reads the cylinder too long, m.
    pub size: f64,
    /// Evidence that the tilt is not the usual one, nats.
    pub nats: f64,
    /// By how much any other leg explains it worse, nats.
    pub apart: f64,
    /// Since when the tilt has departed, s.
    pub since: f64,
}

/// A tilt beyond the usual one, from which nothing is learnt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Departure {
    /// Cycles since it began.
    pub cycles: u32,
    /// By how much roll and pitch grow with the length of each cylinder, averaged as the tilt is, rad/m.
    slopes: [[f64; 2]; LEGS],
    /// The leg that explains it, and for how many cycles it has.
    explained: Option<(usize, u32)>,
}

whole! {
    Departure { cycles, slopes, explained }
    sound |it| it.cycles < u32::MAX && it.slopes.iter().all(are_finite)
        && it.explained.is_none_or(|(leg, cycles)| leg < LEGS && cycles < u32::MAX)
}

/// The leg whose single transducer was found to be off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Found {
    pub leg: usize,
    /// Cycles for which the tilt has been the usual one again.
    pub calm: u32,
}

whole! {
    Found { leg, calm }
    sound |it| it.leg < LEGS && it.calm < u32::MAX
}

impl Departure {
    pub const fn new(slopes: [[f64; 2]; LEGS]) -> Self {
        Self { cycles: 0, slopes, explained: None }
    }

    /// Takes a comparison with these `slopes`, of which the mean has this `share`.
    pub fn follow(&mut self, slopes: &[[f64; 2]; LEGS], share: f64, cycles: u32) {
        self.cycles = self.cycles.saturating_add(cycles).min(u32::MAX - 1);
        for (own, newest) in self.slopes.as_flattened_mut().iter_mut().zip(slopes.as_flattened()) {
            *own += share * (newest - *own);
        }
    }

    /// The leg of `single` transducers that explains `off` by S⁻¹ better than every other leg by
    /// [`TiltParameters::apart`], after `since`, s. Legs with two transducers are compared as well: an error that one of
    /// them may have made names no other.
    pub fn explain(
        &self,
        off: &Vector2<f64>,
        inverse: &Matrix2<f64>,
        single: [bool; LEGS],
        since: f64,
        by: &TiltParameters,
    ) -> Option<TiltError> {
        let beyond = fit(off, inverse);
        let mut best = (f64::INFINITY, 0, 0.0);
        let mut second = f64::INFINITY;
        for (leg, slope) in self.slopes.iter().enumerate() {
            let own = -Vector2::from(*slope);
            let (weight, along) = (fit(&own, inverse), (own.transpose() * inverse * off)[(0, 0)]);
            // A leg that does not tilt the deck explains nothing.
            let size = if weight > 0.0 { along / weight } else { 0.0 };
            let left = beyond - size * along;
            if left < best.0 {
                (second, best) = (best.0, (left, leg, size));
            } else {
                second = second.min(left);
            }
        }
        let (left, leg, size) = best;
        let apart = 0.5 * (second - left);
        let is_explained = single[leg] && left < by.beside * by.beside && apart >= by.apart;
        let nats = 0.5 * beyond;
        is_explained.then_some(TiltError { leg, size, nats, apart, since })
    }

    /// For how many cycles that leg, or none, has been the one that explains it.
    pub fn last(&mut self, leg: Option<usize>, cycles: u32) -> u32 {
        let before = self.explained.filter(|(before, _)| Some(*before) == leg);
        let lasted =
            before.map_or(0, |(_, lasted)| lasted.saturating_add(cycles).min(u32::MAX - 1));
        self.explained = leg.map(|leg| (leg, lasted));
        lasted
    }
}

/// The square of how many standard deviations a tilt is off.
pub fn fit(off: &Vector2<f64>, inverse: &Matrix2<f64>) -> f64 {
    (off.transpose() * inverse * off)[(0, 0)]
}
