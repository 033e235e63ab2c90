//! The faults that are tried.

use crate::evaluate::fault::shape_label;
use tertius_machine::inject::Shape;

/// Faults of the transducer that is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccommodateCase {
    /// While the other transducer is there.
    pub first: Shape,
    /// Added while it is alone.
    pub second: Option<Shape>,
}

impl AccommodateCase {
    const fn alone(first: Shape, second: Shape) -> Self {
        Self { first, second: Some(second) }
    }

    /// The faults in words.
    pub fn label(&self) -> String {
        let second = self.second.map(|shape| format!(", then {}", shape_label(shape)));
        shape_label(self.first) + &second.unwrap_or_default()
    }
}

/// What is tried. An observer follows the drift of the last case: no residual shows it.
pub const CASES: [AccommodateCase; 7] = {
    const STEP: Shape = Shape::Step { size: 0.01 };
    const fn only(first: Shape) -> AccommodateCase {
        AccommodateCase { first, second: None }
    }
    [
        only(Shape::Step { size: 2.5e-3 }),
        only(STEP),
        only(Shape::Step { size: 0.06 }),
        only(Shape::Drift { rate: 1e-3 }),
        AccommodateCase::alone(STEP, Shape::Step { size: 2.5e-3 }),
        AccommodateCase::alone(STEP, STEP),
        AccommodateCase::alone(STEP, Shape::Drift { rate: 1e-4 }),
    ]
};
