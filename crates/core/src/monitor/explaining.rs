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

/// Everything that was found in the newest cycle of each cylinder.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Explained {
    /// In the order of the cylinders and detectors.
    pub findings: Vec<Explanation>,
    /// Numbers of the cylinders of which a transducer was not judged, counted from 1.
    pub unjudged: Vec<u8>,
    pub cylinders: usize,
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
    /// The findings of the newest cycle of each cylinder, with what each rule answered.
    pub fn explain(&self) -> Explained {
        let mut all = Explained { cylinders: self.cylinders.len(), ..Explained::default() };
        for (cylinder, number) in self.cylinders.iter().zip(1..) {
            if !cylinder.judges() {
                all.unjudged.push(number);
            }
            let findings = cylinder.findings();
            for place in 0..PLACES {
                let Some(finding) = findings[place] else { continue };
                let mut answers = Vec::new();
                if let Some(accuser) = accuser(place) {
                    let asked = |rule, suspect| answers.push(Answer { rule, suspect });
                    cylinder.blame(accuser, asked);
                }
                let detector = DETECTORS[place];
                all.findings.push(Explanation { cylinder: number, detector, finding, answers });
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
