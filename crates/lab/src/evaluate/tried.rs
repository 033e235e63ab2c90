//! The faults of one simulated machine.

use super::stand::{Stand, StandError};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use tertius_core::time::Span;
use tertius_core::verdict::Suspect;
use tertius_machine::inject::{Fault, Placed, Shape, Wanted, Window, place};

/// Number of turns in which the cylinders of a machine have their faults where sequential detectors judge: they put down
/// what half of the cylinders show at once to something shared.
pub(super) const TURNS: u32 = 3;

/// Time from when the observers have settled until the earliest fault, s.
const LEAD: f64 = 3.0;

/// Span of time within which all faults begin, s.
const SPREAD: f64 = 1.0;

/// A fault that is tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriedFault {
    /// Cylinder number, counted from 1.
    pub cylinder: u8,
    /// The faulty transducer, C1 or C2.
    pub transducer: Suspect,
    /// The fault with its sign; `None`: nothing happens.
    pub wanted: Option<Wanted>,
    /// Time of the fault after the first frame, s.
    pub at: f64,
}

/// A machine and its faults.
#[derive(Clone, Debug, PartialEq)]
pub struct Try {
    pub seed: u64,
    pub faults: Vec<TriedFault>,
}

impl Try {
    /// Draws a trial of `wanted` on a machine of so many `cylinders` from `rng`; `settle` is how long the observers take to
    /// settle, s. Every cylinder has the fault, on C1 or C2; where it is `alone`, C1 of the cylinder of that number, modulo
    /// their number. Faults that differ only in kind and size are drawn on the same machines.
    pub fn draw(
        wanted: Option<Wanted>,
        alone: Option<u32>,
        cylinders: u8,
        settle: f64,
        rng: &mut ChaCha8Rng,
    ) -> Self {
        let seed = rng.random();
        let count = u32::from(cylinders);
        let chosen = (0..count).filter(|index| alone.is_none_or(|number| number % count == *index));
        let faults = chosen
            .map(|index| {
                let at = settle + LEAD + SPREAD * rng.random::<f64>();
                let second = rng.random::<bool>() && alone.is_none();
                let sign = if rng.random::<bool>() { 1.0 } else { -1.0 };
                TriedFault {
                    cylinder: index as u8 + 1,
                    transducer: if second { Suspect::C2 } else { Suspect::C1 },
                    wanted: wanted.map(|wanted| signed(wanted, sign)),
                    at,
                }
            })
            .collect();
        Self { seed, faults }
    }
}

/// `wanted`, towards the other side where `sign` is −1.
pub(super) fn signed(wanted: Wanted, sign: f64) -> Wanted {
    let Wanted::Shape(shape) = wanted else { return wanted };
    Wanted::Shape(match shape {
        Shape::Step { size } => Shape::Step { size: sign * size },
        Shape::Incipient { size, b } => Shape::Incipient { size: sign * size, b },
        Shape::Drift { rate } => Shape::Drift { rate: sign * rate },
        Shape::Scale { gain } => Shape::Scale { gain: sign * gain },
        Shape::Spike { size, probability } => Shape::Spike { size: sign * size, probability },
        // Noise has no side, and what is gone neither.
        Shape::Noise { .. }
        | Shape::Freeze
        | Shape::Constant(_)
        | Shape::Stale
        | Shape::Loss { .. } => shape,
    })
}

impl Stand<'_> {
    /// The faults of `one`, in their order.
    pub(super) fn placed(&self, one: &Try) -> Result<Vec<Placed>, StandError> {
        let wanted = one.faults.iter().filter_map(|tried| Some((tried, tried.wanted?)));
        let placed = wanted.map(|(tried, wanted)| {
            let window = Window { from: Span::from_seconds(tried.at), until: None };
            let (cylinder, sensor) = (tried.cylinder, tried.transducer.name());
            let fault = Fault { cylinder, sensor, wanted, window };
            Ok(place(&fault, self.settings, self.database)?)
        });
        placed.collect()
    }
}
