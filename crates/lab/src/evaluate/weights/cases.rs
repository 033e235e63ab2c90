//! The sets of weights, the transducers and the faults that are tried.

use crate::evaluate::fault::SIGMA;
use crate::evaluate::grade::Grade;
use tertius_learn::tune::Weights;
use tertius_learn::tune::criterion::{INCIPIENT, STEP};
use tertius_machine::inject::Shape;

/// Sets that are tried when the command line names none: of the thesis's design, of fine and of
/// coarse transducers, and a slow one.
pub const SETS: [Weights; 4] = [
    Weights { q: [1e-8, 1e-3, 100.0], r: [1e-8, 1e-2] },
    Weights { q: [5e-9, 2e-4, 1e4], r: [1e-8, 5.0] },
    Weights { q: [1e-8, 3e-5, 2e3], r: [1e-8, 1.0] },
    Weights { q: [1e-9, 1e-6, 100.0], r: [1e-8, 1e-2] },
];

/// Most sets: each has its monitor on every machine.
pub const MOST: usize = 32;

/// Faults that are tried, and how long each is watched by the observer of its transducer, s: 0 is
/// the faulty reading alone.
pub const FAULTS: [(Shape, f64); 5] = [
    (Shape::Step { size: STEP }, 0.0),
    (Shape::Step { size: 1.25e-3 }, 0.0),
    (Shape::Step { size: 1.5e-3 }, 0.0),
    (Shape::Incipient { size: INCIPIENT.0, b: INCIPIENT.1 }, 0.1),
    (Shape::Noise { size: SIGMA }, 10.0),
];

/// Transducers, and whether their readings are off for a while now and then, as in Figure 5-9.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum TransducerKind {
    Steady,
    Fluctuating,
    Coarse,
}

impl TransducerKind {
    pub const ALL: [Self; 3] = [Self::Steady, Self::Fluctuating, Self::Coarse];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Steady => "fine",
            Self::Fluctuating => "fine, fluctuating",
            Self::Coarse => "coarse",
        }
    }

    pub(super) const fn of_grade(self) -> Grade {
        match self {
            Self::Steady | Self::Fluctuating => Grade::Fine,
            Self::Coarse => Grade::Coarse,
        }
    }
}
