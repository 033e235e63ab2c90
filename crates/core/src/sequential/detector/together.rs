//! What the detectors of all cylinders know together: the sampling of both transducers.

use super::{Design, Sequential};
use crate::sequential::alarm::Alarm;
use crate::sequential::noise::Noise;
use crate::sequential::parameters::{SamplingParameters, SequentialCycles};
use crate::sequential::sampling::{Apart, SamplingEvidence};
use crate::sequential::witness::Claim;
use crate::verdict::{Fault, Suspect};

impl Sequential {
    /// What the residuals show of the sampling times of C1 and C2; `None` while one of them is at
    /// fault.
    pub fn sampling(&self) -> Option<SamplingEvidence> {
        let evidence =
            || SamplingEvidence { seen: self.skew.seen(), known: self.design.noise.timing };
        self.is_witness().then(evidence)
    }

    /// Whether this cylinder can be asked. One with a noise that blames nobody may be affected by
    /// the sampling: if it were not asked, those without an alarm would be the majority.
    pub(super) fn is_witness(&self) -> bool {
        self.alarm
            .is_none_or(|alarm| alarm.fault == Fault::Noise && alarm.suspect == Suspect::Undecided)
    }

    /// Allows for the time between the samples of C1 and C2, as found from all cylinders.
    pub fn allow(&mut self, apart: &Apart) {
        let Noise { rest, timing } = self.design.noise.relied_on();
        self.noise = Noise { rest, timing: apart.timing(timing) };
        self.sooner = apart.mean;
        self.sampled_anew = apart.changed;
        if apart.changing {
            self.lay_to_timing();
        }
    }

    /// The claim that the noise of an alarm that blames nobody comes from the sampling; the other
    /// cylinders are asked about it before the alarm is next examined.
    pub fn claim(&self) -> Option<Claim> {
        let alarm = self.alarm.as_ref().filter(|alarm| alarm.is_to_be_claimed(&self.cycles))?;
        let cycles = (alarm.age as usize).saturating_add(alarm.back).min(self.cycles.newest);
        let Design { noise, sample_time, .. } = &self.design;
        Some(self.witness.claim(cycles, &noise.relied_on(), *sample_time))
    }

    /// Evidence for `claim`, nats: 0 where the cylinder has none, `None` where one of its readings
    /// is to blame.
    pub fn evidence(&self, claim: &Claim) -> Option<f64> {
        if self.alarm.is_some_and(|alarm| alarm.suspect != Suspect::Undecided) {
            return None;
        }
        let noise = if self.sampled_anew { self.noise } else { self.design.noise.relied_on() };
        Some(if self.is_witness() {
            self.witness.evidence(claim, &noise, self.design.outliers)
        } else {
            0.0
        })
    }

    /// Takes whether the noise may come from the sampling.
    pub const fn allow_timing(&mut self, may_be_timing: bool) {
        self.may_be_timing = may_be_timing;
    }
}

impl Alarm {
    /// Whether the alarm blames nobody and will soon be examined, so that the others must be asked
    /// about the sampling.
    fn is_to_be_claimed(&self, cycles: &SequentialCycles) -> bool {
        // Those of a look before they are asked again.
        let ahead = SamplingParameters::DEFAULT.every;
        let soon = self.age.max(cycles.noise_told - 1) + 1..=self.age + ahead;
        let asks = self.suspect == Suspect::Undecided && !self.of_timing;
        asks && cycles.looks.iter().any(|look| soon.contains(look))
    }
}
