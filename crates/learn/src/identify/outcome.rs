//! Results of an identification, as plain data.

use super::estimate::Estimate;
use super::nonlinear::Nonlinear;
use super::refusal::IdentificationRefusal;
use super::shaper::{Shaping, Sources};
use super::validate::{Fit, Trials, TriedModel};
use crate::survey::{Timeline, Window};
use nalgebra::{Complex, Matrix3, SVD};
use tertius_core::observe::model::{Model, POSITION};

/// Result for a machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    pub machine: String,
    /// Names of the recordings.
    pub inputs: String,
    /// Times of the recording's frames.
    pub timeline: Timeline,
    pub shaping: Shaping,
    /// Part that the models were identified on.
    pub fitted: Window,
    /// Part that the models were validated on; equal to `fitted` where nothing is held back.
    pub validated: Window,
    /// Results of all configured cylinders, from cylinder 1.
    pub cylinders: Vec<CylinderOutcome>,
    /// Choice of the machine's model; `None` where there is none.
    pub choice: Option<Choice>,
    pub remarks: Vec<String>,
    /// Flow and friction, where requested.
    pub nonlinear: Option<Nonlinear>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct CylinderOutcome {
    pub number: u8,
    pub sources: Sources,
    pub result: Result<Identified, IdentificationRefusal>,
    /// Results of every model on this cylinder; `None` where none could be tried.
    pub trials: Option<Trials>,
    pub remarks: Vec<String>,
}

/// One cylinder's own model.
#[derive(Clone, Debug, PartialEq)]
pub struct Identified {
    pub estimate: Estimate,
    pub model: Model,
    /// Eigenvalues of A, the largest first.
    pub poles: Option<[Complex<f64>; 3]>,
    /// Gain from u to l̇, see [`Model::velocity_gain`].
    pub velocity_gain: Option<f64>,
    /// Observability of [C; CA; CA²] for a position reading, with states in units of their root
    /// mean squares.
    pub observability: Observability,
    /// Why the model has no observer with the configured weights.
    pub no_observer: Option<String>,
}

/// Observability of the state from the readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observability {
    /// Rank, at most 3.
    pub rank: usize,
    /// Condition number; infinite where the rank is not full.
    pub condition: f64,
}

/// The model chosen for the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// Cylinder that it was identified on.
    pub of: u8,
    /// Smallest position VAF over all cylinders, %.
    pub worst: f64,
    /// Whether the user requested it.
    pub asked: bool,
}

impl Observability {
    /// Observability of `model` with states of the root mean squares `sizes`.
    pub fn new(model: &Model, sizes: [f64; 3]) -> Self {
        let size = |i: usize| if sizes[i] > 0.0 { sizes[i] } else { 1.0 };
        let a = Matrix3::from_fn(|i, j| model.a[(i, j)] * size(j) / size(i));
        let rows = [POSITION, POSITION * a, POSITION * a * a];
        let matrix = Matrix3::from_rows(&rows);
        let Some(svd) = SVD::try_new(matrix, false, false, f64::EPSILON, 300) else {
            return Self { rank: 0, condition: f64::INFINITY };
        };
        let (largest, smallest) = (svd.singular_values.max(), svd.singular_values.min());
        let rank = svd.singular_values.iter().filter(|value| **value > 1e-12 * largest).count();
        let condition = if rank == 3 { largest / smallest } else { f64::INFINITY };
        Self { rank, condition }
    }
}

impl Outcome {
    /// Open-loop fit of the model of cylinder `of` on cylinder `on`: an entry of Figure 4-3.
    pub fn simulated(&self, of: u8, on: u8) -> Option<&Fit> {
        self.tried(of, on).map(|tried| &tried.simulated)
    }

    pub fn tried(&self, of: u8, on: u8) -> Option<&TriedModel> {
        let cylinder = self.cylinders.iter().find(|cylinder| cylinder.number == on)?;
        cylinder.trials.as_ref()?.tried.iter().find(|tried| tried.of == of)
    }

    pub fn identified(&self, of: u8) -> Option<&Identified> {
        let cylinder = self.cylinders.iter().find(|cylinder| cylinder.number == of)?;
        cylinder.result.as_ref().ok()
    }

    /// The smallest position VAF of the model of cylinder `of` over all cylinders it was tried on.
    pub fn worst(&self, of: u8) -> Option<f64> {
        let vafs = self.cylinders.iter().filter_map(|on| self.simulated(of, on.number));
        vafs.map(|fit| fit.position.vaf()).map(finite_or_worst).reduce(f64::min)
    }

    /// The model whose worst cylinder is the best, as the thesis discards a model that does badly
    /// on a single cylinder.
    pub fn choose(&self, asked: Option<u8>) -> Option<Choice> {
        if let Some(of) = asked {
            return self.worst(of).map(|worst| Choice { of, worst, asked: true });
        }
        let all = self.cylinders.iter().filter_map(|cylinder| {
            let of = cylinder.number;
            self.worst(of).map(|worst| Choice { of, worst, asked: false })
        });
        all.reduce(|best, next| if next.worst > best.worst { next } else { best })
    }
}

/// Open-loop VAF below which a model is worse than the signal's mean, %.
const SAYS_NOTHING: f64 = 0.0;

/// Open-loop VAF below which a position is farther off than another one of the recording taken at
/// random, which has twice the variance, %.
const SAYS_LESS_THAN_CHANCE: f64 = -100.0;

/// VAF that the thesis requires of a model, % (section 4-3).
pub const ASKED: f64 = 90.0;

/// A model that does not follow a cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stray {
    /// Cylinder that it was tried on.
    pub on: u8,
    /// VAF of the position, simulated open loop, %.
    pub position: f64,
    /// VAF of the velocity, simulated open loop, %.
    pub velocity: f64,
}

impl Outcome {
    /// The cylinders that the model of cylinder `of` does not follow: simulated from the commands
    /// alone, its velocity is worse than a constant, or its position worse than chance. A position
    /// that merely drifts off does not count (see [`CylinderOutcome::runs_away`]).
    pub fn strays(&self, of: u8) -> Vec<Stray> {
        let stray = |on: u8| {
            let fit = self.simulated(of, on).filter(|fit| fit.position.count() > 0)?;
            let (position, velocity) = (fit.position.vaf(), fit.velocity.vaf());
            // What ran beyond the finite numbers has no VAF at all.
            let follows = velocity > SAYS_NOTHING && position >= SAYS_LESS_THAN_CHANCE;
            (!follows).then_some(Stray { on, position, velocity })
        };
        self.cylinders.iter().filter_map(|cylinder| stray(cylinder.number)).collect()
    }
}

impl CylinderOutcome {
    /// Whether the model of cylinder `of` runs away from this cylinder when it is simulated.
    pub fn runs_away(&self, of: u8) -> bool {
        let tried = self.trials.iter().flat_map(|trials| &trials.tried);
        let mut positions = tried.filter(|tried| tried.of == of).map(|it| it.simulated.position);
        // What ran beyond the finite numbers has no VAF at all.
        positions
            .any(|score| score.count() > 0 && (score.vaf().is_nan() || score.vaf() < SAYS_NOTHING))
    }
}

/// `vaf`, or the worst value for a model that ran away.
fn finite_or_worst(vaf: f64) -> f64 {
    if vaf.is_finite() { vaf } else { f64::NEG_INFINITY }
}
