//! The warning of a reading that fails a plausibility check.

use crate::sample::Quality;
use crate::time::{Span, Timestamp};
use crate::verdict::{Fault, Thresholds, Trigger};

/// A plausibility warning: raised at once, cleared with hysteresis.
#[derive(Clone, Debug)]
pub struct Implausible {
    pub trigger: Trigger,
    pub fault: Fault,
    /// Distance of the reading beyond its limits, m, signed.
    pub beyond: f64,
}

impl Implausible {
    pub fn new(clear: Span) -> Self {
        let trigger = Trigger::new(Thresholds { low: 0.5, high: 0.5, clear });
        Self { trigger, fault: Fault::Unclassified, beyond: 0.0 }
    }

    pub fn judge(&mut self, at: Timestamp, quality: Quality, beyond: f64) {
        // Nearly always: what is good and stands for nothing changes nothing.
        if quality.is_good() && !self.raised() {
            return;
        }
        let fault = match quality {
            Quality::Good | Quality::Missing => None,
            Quality::Stale => Some(Fault::Stale),
            Quality::BrokenWire => Some(Fault::BrokenWire),
            Quality::OutOfRange => Some(Fault::OutOfRange),
            Quality::Frozen => Some(Fault::Frozen),
        };
        if let Some(fault) = fault {
            (self.fault, self.beyond) = (fault, beyond);
        }
        let evidence = match (fault, quality) {
            (Some(_), _) => Some(1.0),
            (None, Quality::Good) => Some(0.0),
            (None, _) => None,
        };
        self.trigger.judge(at, evidence);
    }

    pub fn raised(&self) -> bool {
        self.trigger.raised().is_some()
    }
}
