//! Flow and friction of a machine, as plain data.

use super::flow::{FlowCurve, FlowSources, NoFlow};
use super::friction::{FrictionCurve, NoFriction};
use super::valve::{IdentifiedValve, NoValve};

/// Flow and friction of section 3-3-1, by cylinder from 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Nonlinear {
    pub sources: FlowSources,
    /// Flow curves out and in.
    pub flow: Vec<[Result<FlowCurve, NoFlow>; 2]>,
    /// Samples of the flow curves' data, x_m and f_NL over A_p, m/s/√bar, for figures.
    pub points: Vec<Vec<(f64, f64)>>,
    /// The valves' curves for a plant, each with its trial.
    pub valves: Vec<Result<IdentifiedValve, NoValve>>,
    pub friction: Vec<Result<FrictionCurve, NoFriction>>,
}
