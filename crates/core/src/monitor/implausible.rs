//! The warning of a reading that fails a plausibility check.

use crate::sample::{DeviceReport, Quality};
use crate::state::state;
use crate::time::{Span, Timestamp};
use crate::verdict::{Fault, Thresholds, Trigger};

/// A plausibility warning: raised at once, cleared with hysteresis.
#[derive(Clone, Debug)]
pub struct Implausible {
    pub trigger: Trigger,
    pub fault: Fault,
    /// Distance of the reading beyond its limits, m, signed.
    pub beyond: f64,
    /// What the device says of it.
    pub report: Option<DeviceReport>,
}

state! { Implausible { trigger, fault, beyond, report } }

/// What a check found in a cycle.
#[derive(Clone, Copy, Debug)]
pub struct Checked {
    pub quality: Quality,
    /// Distance of the reading beyond its limits, m, signed.
    pub beyond: f64,
    /// What the device says of it, where it says anything.
    pub report: Option<DeviceReport>,
}

impl Implausible {
    pub fn new(clear: Span) -> Self {
        let trigger = Trigger::new(Thresholds { low: 0.5, high: 0.5, clear });
        Self { trigger, fault: Fault::Unclassified, beyond: 0.0, report: None }
    }

    pub fn judge(&mut self, at: Timestamp, checked: Checked) {
        let Checked { quality, beyond, report } = checked;
        let fault = match quality {
            Quality::Good | Quality::Missing => None,
            Quality::NotOperational | Quality::Doubtful => {
                // That there is no reading is explained; whatever else was found stands.
                if self.fault == Fault::Stale {
                    self.trigger.withdraw();
                }
                None
            }
            Quality::Stale => Some(Fault::Stale),
            // The sensor has failed, as a broken wire or a status bit also tells.
            Quality::Failed | Quality::BrokenWire => Some(Fault::BrokenWire),
            Quality::OutOfRange => Some(Fault::OutOfRange),
            Quality::Frozen => Some(Fault::Frozen),
        };
        if let Some(fault) = fault {
            (self.fault, self.beyond, self.report) = (fault, beyond, report);
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
