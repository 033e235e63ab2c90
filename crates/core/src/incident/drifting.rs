//! Slow differences of most cylinders at once, of which no transducer is accused.
//!
//! Transducers that warm as the sun comes out, or whose common supply sags, drift within minutes of each other. Six incidents
//! of six cylinders sent people to twelve sound transducers.

use super::cause::Cause;
use super::joining::Open;
use crate::alarm::detector::{DETECTORS, WarningPlace};
use crate::alarm::{Detector, Warning};
use crate::verdict::{Fault, Suspect};

/// Whether `warning` is of a slow difference of C1 and C2.
pub(super) fn is_of_drift(warning: &Warning) -> bool {
    let Warning { detector, finding, .. } = warning;
    *detector == Detector::Sequential && finding.fault == Fault::Incipient && !finding.is_of_stop()
}

impl Open {
    /// Whether it is a slow difference that stands, and nothing else.
    pub fn is_drift(&self) -> bool {
        const SEES: [WarningPlace; 2] = [WarningPlace::Sequential, WarningPlace::Fde3];
        let seen = self.incident.part(WarningPlace::Sequential);
        let mut parts = DETECTORS.iter().zip(&self.incident.parts);
        let is_only = parts.all(|(detector, part)| {
            part.is_none() || SEES.into_iter().any(|place| DETECTORS[place as usize] == *detector)
        });
        let Self { incident, shared, .. } = self;
        incident.fault == Fault::Incipient
            && incident.suspect == Suspect::Undecided
            && incident.gain.is_none()
            && is_only
            && seen.is_some_and(|part| part.stands && !part.finding.is_of_stop())
            && shared.is_none_or(|it| it == Cause::Drift)
    }
}
