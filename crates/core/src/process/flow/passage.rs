//! What drives the oil, from cycle to cycle.

use crate::state::whole;

/// Pressure drop at which f holds, bar.
const DROP: f64 = 210.0;

/// A cylinder in one cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlowSample {
    /// C1 and the corrected C2, m; `None` where one of them is missing.
    pub lengths: Option<[f64; 2]>,
    /// Position of the spool, in its unit.
    pub spool: f64,
    /// P_L and P_S, bar.
    pub load: f64,
    pub supply: f64,
    /// C1 beyond what C2 has it at, m, where a calibration along the stroke tells.
    pub apart: Option<f64>,
}

whole! { FlowSample { lengths, spool, load, supply, apart } }

/// What drives oil through the valve from one cycle to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passage {
    /// x̄.
    pub position: f64,
    /// P̄_L, bar.
    pub load: f64,
    /// √((P_S ∓ P̄_L)/210 bar).
    pub root: f64,
}

impl Passage {
    /// Between two cycles, with the spool's mean at the part `between` of its way.
    pub fn of(from: &FlowSample, to: &FlowSample, between: f64) -> Self {
        let position = from.spool + between * (to.spool - from.spool);
        let [load, supply] = [from.load + to.load, from.supply + to.supply].map(|sum| 0.5 * sum);
        let drop = if position >= 0.0 { supply - load } else { supply + load };
        Self { position, load, root: libm::sqrt(drop.max(0.0) / DROP) }
    }
}
