//! The faults that are tried, and the policies that are compared.

use crate::evaluate::fault::SIGMA;
use serde::Serialize;
use tertius_machine::controller::Measurement;
use tertius_machine::inject::Shape;

/// What the machine's controller makes of a warning that blames a transducer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Policy {
    /// Nothing: it stays on C1, as the machine does today.
    Stay,
    /// It takes C2 as it reads where C1 is blamed, and the blamed one out of the 5 cm rule.
    Second,
    /// The same with Fd_Estimate, and C2 where that is not valid.
    Estimate,
}

impl Policy {
    pub const ALL: [Self; 3] = [Self::Stay, Self::Second, Self::Estimate];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Stay => "a: stay",
            Self::Second => "b: to C2",
            Self::Estimate => "c: to the estimate",
        }
    }

    /// Its letter.
    pub const fn letter(self) -> &'static str {
        match self {
            Self::Stay => "a",
            Self::Second => "b",
            Self::Estimate => "c",
        }
    }

    /// What it takes instead of a C1 that is blamed; `None`: it takes no notice.
    pub const fn instead(self) -> Option<Measurement> {
        match self {
            Self::Stay => None,
            Self::Second => Some(Measurement::C2),
            Self::Estimate => Some(Measurement::Estimated),
        }
    }
}

/// A fault of a transducer that the controller reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandoverCase {
    pub label: &'static str,
    /// The fault, its size positive; negative sizes are tried as often. `None`: no fault.
    pub shape: Option<Shape>,
    /// How long it is watched, s; a drift until it is far beyond 5 cm.
    pub watch: f64,
}

const fn case(label: &'static str, shape: Shape, watch: f64) -> HandoverCase {
    HandoverCase { label, shape: Some(shape), watch }
}

pub const CASES: [HandoverCase; 12] = [
    HandoverCase { label: "none", shape: None, watch: 60.0 },
    case("step 5 mm", Shape::Step { size: 5e-3 }, 20.0),
    case("step 20 mm", Shape::Step { size: 0.02 }, 20.0),
    case("step 60 mm", Shape::Step { size: 0.06 }, 20.0),
    case("drift 0.5 mm/s", Shape::Drift { rate: 5e-4 }, 140.0),
    case("drift 1 mm/s", Shape::Drift { rate: 1e-3 }, 75.0),
    case("drift 5 mm/s", Shape::Drift { rate: 5e-3 }, 20.0),
    case("drift 20 mm/s", Shape::Drift { rate: 0.02 }, 10.0),
    case("frozen", Shape::Freeze, 20.0),
    case("noise 4 σ", Shape::Noise { size: 4.0 * SIGMA }, 20.0),
    case("scale 1 %", Shape::Scale { gain: 0.01 }, 30.0),
    case("incipient 70 mm", Shape::Incipient { size: 0.07, b: 1.0 }, 20.0),
];
