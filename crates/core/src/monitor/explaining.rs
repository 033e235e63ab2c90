//! How the suspects of the newest cycle were named, rule by rule.

use super::Monitor;
use crate::alarm::detector::{DETECTORS, PLACES, WarningPlace};
use crate::alarm::{Detector, Finding};
use crate::blame::{Accuser, Rule};
use crate::verdict::Suspect;
use alloc::vec::Vec;

/// What a rule answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    pub rule: Rule,
    /// `None` where it did not apply.
    pub suspect: Option<Suspect>,
}

/// A finding of the newest cycle, and how its suspect was named.
#[derive(Clone, Debug, PartialEq)]
pub struct Explanation {
    /// Cylinder number, counted from 1.
    pub cylinder: u8,
    pub detector: Detector,
    pub finding: Finding,
    /// The rules that were asked, in their order; empty for a detector that names its suspect itself.
    pub answers: Vec<Answer>,
}

impl Monitor {
    /// All findings of the newest cycle of each cylinder, in the order of the cylinders and detectors.
    pub fn explain(&self) -> Vec<Explanation> {
        let mut all = Vec::new();
        for (cylinder, number) in self.cylinders.iter().zip(1..) {
            let findings = cylinder.findings();
            for place in 0..PLACES {
                let Some(finding) = findings[place] else { continue };
                let mut answers = Vec::new();
                if let Some(accuser) = accuser(place) {
                    let asked = |rule, suspect| answers.push(Answer { rule, suspect });
                    cylinder.blame(accuser, asked);
                }
                let detector = DETECTORS[place];
                all.push(Explanation { cylinder: number, detector, finding, answers });
            }
        }
        all
    }
}

/// The accuser whose finding stands in a place.
fn accuser(place: usize) -> Option<Accuser> {
    let places = [
        (WarningPlace::Fde1, Accuser::Fde1),
        (WarningPlace::Fde2, Accuser::Fde2),
        (WarningPlace::Fde3, Accuser::Fde3),
        (WarningPlace::Sequential, Accuser::Sequential),
    ];
    places.into_iter().find(|(of, _)| *of as usize == place).map(|(_, accuser)| accuser)
}
