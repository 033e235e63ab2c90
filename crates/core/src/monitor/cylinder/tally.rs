//! Counts and extremes of a cylinder.

use crate::process::ProcessCoverage;
use crate::sequential::Coverage;
use crate::state::whole;
use crate::verdict::Residuals;

/// Counts and extremes of one cylinder, for reports.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Cycles evaluated, whether complete or not.
    pub cycles: u64,
    /// Cycles that neither FDE1 nor FDE2 judged.
    pub gated: u64,
    /// Cycles in which something configured did not arrive.
    pub incomplete: u64,
    /// Readings of C1 and C2 that did not pass the plausibility checks, without missing ones.
    pub implausible: [u64; 2],
    /// Largest |R1| and |R2| judged, and largest |R3|, m.
    pub worst: [Option<f64>; 3],
    /// Coverage of the sequential detector; `None` without one.
    pub sequential: Option<Coverage>,
    /// Coverage of the process detector; `None` without one, or before the platform was monitored.
    pub process: Option<ProcessCoverage>,
}

whole! { Tally { cycles, gated, incomplete, implausible, worst, sequential, process } }

impl Tally {
    /// Counts a cycle.
    pub(super) fn count(&mut self, residuals: &Residuals, judged: bool, complete: bool) {
        self.cycles += 1;
        self.gated += u64::from(!judged);
        self.incomplete += u64::from(!complete);
        for (worst, residual) in self.worst.iter_mut().zip(residuals.r) {
            if let Some(magnitude) = residual.map(f64::abs)
                && worst.is_none_or(|worst| worst < magnitude)
            {
                *worst = Some(magnitude);
            }
        }
    }
}
