//! What the detectors of all cylinders know together: how both transducers are sampled.

use super::{Design, Sequential};
use crate::sequential::alarm::Alarm;
use crate::sequential::noise::Noise;
use crate::sequential::parameters::Cycles;
use crate::sequential::sampling::{Apart, Said};
use crate::sequential::witness::Claim;
use crate::verdict::{Fault, Suspect};

/// Cycles before a look in which the other cylinders are asked: as many as lie between two times that the
/// monitor asks.
const AHEAD: u32 = 5;

impl Sequential {
    /// What its residuals say of when C1 and C2 are sampled; `None` while one of both is at fault.
    pub fn said(&self) -> Option<Said> {
        let said = || Said { seen: self.skew.seen(), known: self.design.noise.timing };
        self.is_witness().then(said)
    }

    /// A noise that is nobody's may be the sampling's: were it not asked, those that have no alarm yet would
    /// be the majority.
    pub(super) fn is_witness(&self) -> bool {
        self.alarm
            .is_none_or(|alarm| alarm.fault == Fault::Noise && alarm.suspect == Suspect::Undecided)
    }

    /// C1 and C2 are sampled so far apart, as all cylinders together have it.
    pub fn allow(&mut self, apart: &Apart) {
        let Noise { rest, timing } = self.design.noise.relied_on();
        self.noise = Noise { rest, timing: apart.timing(timing) };
        self.sooner = apart.mean;
        self.sampled_anew = apart.changed;
        if apart.changing {
            self.lay_to_timing();
        }
    }

    /// What the noise of an alarm that is nobody's would be of the sampling, which the other cylinders are
    /// asked for before the next look at it.
    pub fn claim(&self) -> Option<Claim> {
        let alarm = self.alarm.as_ref().filter(|alarm| alarm.is_to_be_claimed(&self.cycles))?;
        let cycles = (alarm.age as usize + alarm.back).min(self.cycles.newest);
        let Design { noise, sample_time, .. } = &self.design;
        Some(self.witness.claim(cycles, &noise.relied_on(), *sample_time))
    }

    /// Its evidence that `claim` is right, nats: 0 where it can say nothing, `None` where one of both
    /// readings is to blame.
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

    /// Hears whether its noise may be the sampling's.
    pub const fn hear(&mut self, may_be_timing: bool) {
        self.may_be_timing = may_be_timing;
    }
}

impl Alarm {
    /// It is nobody's, and will soon be looked at: whether it may be the sampling's is to be asked.
    fn is_to_be_claimed(&self, cycles: &Cycles) -> bool {
        let soon = self.age.max(cycles.noise_told - 1) + 1..=self.age + AHEAD;
        let asks = self.suspect == Suspect::Undecided && !self.of_timing;
        asks && cycles.looks.iter().any(|look| soon.contains(look))
    }
}
