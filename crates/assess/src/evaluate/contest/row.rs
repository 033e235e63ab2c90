//! Faults on which the detectors are compared.

use crate::evaluate::grade::Grade;
use crate::evaluate::row::{SIGMA, Study};
use crate::evaluate::{Cell, Row};
use tertius_machine::inject::{Shape, Wanted};

/// How a fault is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Course {
    /// The fault begins while the machine is engaged.
    Engaged,
    /// The fault grows while the machine is engaged, and then the rods go to their stops, where
    /// they have been before.
    Stop,
}

/// Steps, m.
const STEPS: [f64; 6] = [2.5e-4, 3.5e-4, 5e-4, 7.5e-4, 1e-3, 1.25e-3];

/// Amplitudes of noise (5-17), in [`SIGMA`].
const NOISES: [f64; 3] = [0.5, 1.0, 2.0];

/// Drifts, m/s, with the time that each is watched, s.
const DRIFTS: [(f64, f64); 6] =
    [(1e-2, 10.0), (5e-3, 10.0), (2e-3, 10.0), (1e-3, 10.0), (1e-4, 20.0), (1e-5, 60.0)];

/// Gain errors, as parts of the reading.
const GAINS: [f64; 2] = [2e-3, 5e-3];

/// Slow drifts, m/s: at the stop about a minute later they amount to more than 1 mm, and to more
/// than 5 mm.
const CREEPS: [f64; 2] = [2.5e-5, 1e-4];

const WATCH: f64 = 10.0;

/// A row: a fault, and how it is tried.
pub type TriedRow = (Row, Course);

/// The rows for transducers of `grade`, in the seas of the plan by turns.
pub fn rows(grade: Grade, seas: &[[f64; 2]]) -> Vec<TriedRow> {
    let open = Row {
        study: Study::Contest,
        cell: Cell { grade, sea: seas.first().copied().unwrap_or_default() },
        in_loop: true,
        wanted: None,
        watch: WATCH,
        claim: None,
        stream: 0,
    };
    let of = |shape, watch| Row { wanted: Some(Wanted::Shape(shape)), watch, ..open };
    let mut rows: Vec<TriedRow> = Vec::new();
    let mut engaged = |row| rows.push((row, Course::Engaged));
    STEPS.into_iter().for_each(|size| engaged(of(Shape::Step { size }, WATCH)));
    for sigmas in NOISES {
        engaged(of(Shape::Noise { size: sigmas * SIGMA }, WATCH));
    }
    DRIFTS.into_iter().for_each(|(rate, watch)| engaged(of(Shape::Drift { rate }, watch)));
    GAINS.into_iter().for_each(|gain| engaged(of(Shape::Scale { gain }, WATCH)));
    engaged(of(Shape::Freeze, WATCH));
    engaged(open);
    rows.extend(CREEPS.map(|rate| (of(Shape::Drift { rate }, 0.0), Course::Stop)));
    rows
}
