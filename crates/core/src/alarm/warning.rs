//! Warnings as they leave the monitor.

use super::detector::Detector;
use super::level::Level;
use crate::blame::Rule;
use crate::sample::DeviceReport;
use crate::state::whole;
use crate::time::Timestamp;
use crate::verdict::{Fault, Suspect, Testimony};

/// What happened to a warning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    Raised,
    /// Its fault, suspect or level has changed.
    Changed,
    Cleared,
}

impl State {
    pub const fn name(self) -> &'static str {
        match self {
            Self::Raised => "raised",
            Self::Changed => "changed",
            Self::Cleared => "cleared",
        }
    }
}

/// Finding of a detector, for as long as it lasts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finding {
    pub fault: Fault,
    pub suspect: Suspect,
    /// The rule that named the suspect.
    pub rule: Rule,
    pub level: Level,
    /// Residual, m, signed; `None` where the detector has none (a missing reading).
    pub residual: Option<f64>,
    /// Threshold, m; `None` where there is no residual.
    pub threshold: Option<f64>,
    /// Evidence of a detector that weighs it; `None` for other detectors.
    pub evidence: Option<Evidence>,
    /// What the device says of its fault, where it says anything.
    pub device: Option<DeviceReport>,
}

whole! { Finding { fault, suspect, rule, level, residual, threshold, evidence, device } }

/// Certainty and onset of a finding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// Evidence of a fault, nats: the readings are improbable for a healthy cylinder by a factor of
    /// exp(this).
    pub fault: f64,
    /// Evidence for the location, nats: positive for C1, negative for C2; `None` where they were
    /// not compared.
    pub location: Option<f64>,
    /// What has told the suspect, where the detector knows several that can.
    pub by: Option<Testimony>,
    /// Onset of the fault, as far as the data show it.
    pub onset: Timestamp,
    /// Gain error, where the fault is one: how much more C1 grows with the length than C2, m per m.
    /// Fd_Warning has no code for it, and the fault is unclassified.
    pub gain: Option<f64>,
    /// Size of a fault of the process, where it is known: of a spool in the unit of its signal, of a command that is
    /// late in cycles, of pressures in bar.
    pub size: Option<f64>,
}

whole! { Evidence { fault, location, by, onset, gain, size } }

impl Finding {
    /// [`Evidence::gain`] of a fault that is a gain error.
    pub fn gain(&self) -> Option<f64> {
        self.evidence?.gain
    }

    /// [`Evidence::size`] of a fault of the process, where it is known.
    pub fn size(&self) -> Option<f64> {
        self.evidence?.size
    }

    /// Whether readings on the mechanical stop are what shows it.
    pub fn is_of_stop(&self) -> bool {
        self.evidence.is_some_and(|it| it.by == Some(Testimony::Stop))
    }

    /// Whether `other` means the same to a person; numbers, which change all the time, are not compared, but whether
    /// they are known.
    pub fn says_as(&self, other: &Self) -> bool {
        let meaning = |it: &Self| it.device.map(|device| device.meaning());
        let sizes = |it: &Self| [it.gain(), it.size()].map(|size| size.is_some());
        (self.fault, self.suspect, self.level, sizes(self), meaning(self))
            == (other.fault, other.suspect, other.level, sizes(other), meaning(other))
    }
}

/// A warning that is raised, changed or cleared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Warning {
    pub timestamp: Timestamp,
    /// Cylinder number, counted from 1.
    pub cylinder: u8,
    pub detector: Detector,
    /// Place of the warning among those of the cylinder, see [`super::detector::WarningPlace`].
    pub place: usize,
    pub state: State,
    pub finding: Finding,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(gain: Option<f64>) -> Finding {
        let onset = Timestamp::default();
        Finding {
            fault: Fault::Unclassified,
            suspect: Suspect::Undecided,
            rule: Rule::OneObserver,
            level: Level::Yellow,
            residual: Some(1e-3),
            threshold: Some(8e-4),
            evidence: Some(Evidence {
                fault: 20.0,
                location: None,
                by: None,
                onset,
                gain,
                size: None,
            }),
            device: None,
        }
    }

    #[test]
    fn a_finding_changes_for_a_person_when_a_size_is_known_but_not_with_its_numbers() {
        let [scale, other_scale, none] = [Some(0.01), Some(0.02), None].map(finding);
        assert_eq!((scale.gain(), none.gain()), (Some(0.01), None));
        assert_eq!(Finding { evidence: None, ..scale }.gain(), None);
        assert!(scale.says_as(&other_scale) && !scale.says_as(&none));
        let sized = |size| {
            let evidence = scale.evidence.map(|it| Evidence { size, ..it });
            Finding { evidence, ..scale }
        };
        assert!(sized(Some(1.0)).says_as(&sized(Some(2.0))) && !sized(Some(1.0)).says_as(&scale));
        assert!(scale.says_as(&Finding { residual: Some(2e-3), ..scale }));
        for changed in [
            Finding { fault: Fault::Noise, ..scale },
            Finding { suspect: Suspect::C1, ..scale },
            Finding { level: Level::Orange, ..scale },
        ] {
            assert!(!scale.says_as(&changed), "{changed:?}");
        }
    }
}
