//! The threshold of joint evidence: R1 or R2 alone, while C1 − C2 has moved with it.

use super::evidence::Evidence;
use crate::calibrate::watch::Watch;
use crate::survey::{Row, Surveyor};
use tertius_core::verdict::{Jump, VerdictParameters};

/// Least threshold of joint evidence, that of the thesis, m: below it two fluctuations and an error of the model make it now and
/// then (in 30 h of simulated seas twice beyond 0.85 mm, never beyond 1 mm).
const LEAST_JOINT: f64 = 1e-3;

/// Factor by which the threshold exceeds the largest residual that the recording has: it is not extrapolated, and the recording
/// need not have had the largest one.
const ABOVE: f64 = 1.25;

/// The observers and the sequential detectors side by side, for what both show in one cycle.
#[derive(Debug)]
pub struct JointEvidence<'a> {
    pub evidence: &'a mut Evidence,
    pub watch: &'a mut Watch,
    /// Largest R1 or R2 with joint evidence, m.
    largest: f64,
    /// Whether a cylinder was judged by all of it.
    judged: bool,
}

impl<'a> JointEvidence<'a> {
    pub const fn new(evidence: &'a mut Evidence, watch: &'a mut Watch) -> Self {
        Self { evidence, watch, largest: 0.0, judged: false }
    }

    /// The threshold, m: the thesis's, or more where the recording had more; `None` where no cylinder has tables of the
    /// sequential detector.
    pub fn threshold(&self) -> Option<f64> {
        self.judged.then(|| (ABOVE * self.largest).max(LEAST_JOINT))
    }
}

impl Surveyor for JointEvidence<'_> {
    fn row(&mut self, row: &Row) {
        self.evidence.row(row);
        self.watch.row(row);
        let [r1, r2] = self.evidence.newest(row.cylinder);
        let Some(((r1, r2), jump)) = r1.zip(r2).zip(self.watch.jump(row.cylinder)) else { return };
        self.judged = true;
        let parameters = &VerdictParameters::DEFAULT;
        for (own, other, jump) in [(r1, r2, jump), (r2, r1, jump.reversed())] {
            if own.abs() > self.largest && Jump::shows(jump, own, other, parameters) {
                self.largest = own.abs();
            }
        }
    }

    fn gap(&mut self, cylinder: u8) {
        self.evidence.gap(cylinder);
        self.watch.gap(cylinder);
    }
}
