//! Faults on which the detectors are compared.

use crate::evaluate::fault::{SIGMA, fault_label};
use crate::evaluate::grade::Grade;
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

/// A fault, and how it is tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContestRow {
    pub grade: Grade,
    pub course: Course,
    /// The fault, its size positive; `None`: no fault.
    pub wanted: Option<Wanted>,
    /// How long it is watched, s.
    pub watch: f64,
}

impl ContestRow {
    /// The fault in words.
    pub fn label(&self) -> String {
        let label = fault_label(self.wanted);
        match self.course {
            Course::Engaged => label,
            Course::Stop => format!("{label}, then the stop"),
        }
    }
}

/// The rows for transducers of `grade`.
pub(super) fn rows(grade: Grade) -> Vec<ContestRow> {
    let engaged = |wanted, watch| ContestRow { grade, course: Course::Engaged, wanted, watch };
    let of = |shape, watch| engaged(Some(Wanted::Shape(shape)), watch);
    let mut rows: Vec<ContestRow> = Vec::new();
    rows.extend(STEPS.map(|size| of(Shape::Step { size }, WATCH)));
    rows.extend(NOISES.map(|sigmas| of(Shape::Noise { size: sigmas * SIGMA }, WATCH)));
    rows.extend(DRIFTS.map(|(rate, watch)| of(Shape::Drift { rate }, watch)));
    rows.extend(GAINS.map(|gain| of(Shape::Scale { gain }, WATCH)));
    rows.push(of(Shape::Freeze, WATCH));
    rows.push(engaged(None, WATCH));
    rows.extend(
        CREEPS.map(|rate| ContestRow { course: Course::Stop, ..of(Shape::Drift { rate }, 0.0) }),
    );
    rows
}
