//! The outages and the faults that are tried.

use crate::evaluate::fault::SIGMA;
use crate::evaluate::grade::Grade;
use tertius_machine::inject::{Shape, Wanted};

/// Why a cylinder has one transducer left: the state of the other one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outage {
    /// No frame of it arrives.
    Lost,
    Frozen,
    /// It is off by 10 mm.
    Stepped,
    /// The cylinder has no C2.
    Absent,
}

/// Step of the other transducer, m.
const OFF: f64 = 0.01;

impl Outage {
    pub const fn name(self) -> &'static str {
        match self {
            Self::Lost => "lost",
            Self::Frozen => "frozen",
            Self::Stepped => "10 mm off",
            Self::Absent => "absent",
        }
    }

    /// The fault of the other transducer; `None`: it does not exist.
    pub(super) const fn shape(self) -> Option<Shape> {
        match self {
            Self::Lost => Some(Shape::Loss { probability: 1.0 }),
            Self::Frozen => Some(Shape::Freeze),
            Self::Stepped => Some(Shape::Step { size: OFF }),
            Self::Absent => None,
        }
    }
}

/// Faults of the last transducer; `None` is no fault and shows what is found by chance.
pub const FAULTS: [Option<Wanted>; 16] = {
    const fn of(shape: Shape) -> Option<Wanted> {
        Some(Wanted::Shape(shape))
    }
    [
        of(Shape::Step { size: 1.25e-3 }),
        of(Shape::Step { size: 2.5e-3 }),
        of(Shape::Step { size: 0.01 }),
        of(Shape::Step { size: 0.06 }),
        of(Shape::Noise { size: 2.0 * SIGMA }),
        of(Shape::Noise { size: 6.0 * SIGMA }),
        of(Shape::Incipient { size: 0.07, b: 1.0 }),
        of(Shape::Drift { rate: 1e-3 }),
        of(Shape::Drift { rate: 0.01 }),
        of(Shape::Drift { rate: 0.1 }),
        of(Shape::Scale { gain: 0.01 }),
        of(Shape::Freeze),
        of(Shape::Loss { probability: 1.0 }),
        Some(Wanted::OutOfRange(None)),
        Some(Wanted::BrokenWire(None)),
        None,
    ]
};

/// Machines on which the same faults are tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LastGroup {
    pub grade: Grade,
    /// The controller reads the faults of C1.
    pub in_loop: bool,
    /// The cylinders have no C2.
    pub single: bool,
}

impl LastGroup {
    /// The outages that are tried.
    pub const fn outages(&self) -> &'static [Outage] {
        if self.single {
            &[Outage::Absent]
        } else {
            &[Outage::Lost, Outage::Frozen, Outage::Stepped]
        }
    }
}

/// How long one machine without a fault of the last transducer is watched, s.
pub(super) const STRETCH: f64 = 600.0;
