//! The standing warnings, and the messages about each: raised, changed, cleared, repeated.

use super::Level;
use super::detector::Detector;
pub use super::detector::{DETECTORS, PLACES};
use super::warning::{Finding, State, Warning};
use crate::state::{state, whole};
use crate::time::{Span, Timestamp};
use crate::verdict::Suspect;
use alloc::vec;
use alloc::vec::Vec;

/// Period with which a standing warning is repeated.
const REPEAT: Span = Span::from_nanos(1_000_000_000);

#[derive(Clone, Copy, Debug)]
struct Standing {
    finding: Finding,
    repeat_at: Timestamp,
}

whole! { Standing { finding, repeat_at } }

/// All standing warnings, with one place for each detector of each cylinder, so that the register
/// never grows.
#[derive(Clone, Debug)]
pub struct Register {
    places: Vec<[Option<Standing>; PLACES]>,
    standing: u32,
    /// Earliest repetition of the standing warnings.
    due: Option<Timestamp>,
}

state! {
    Register { standing, due }
    parts { places }
    sound |it| it.is_reckoned()
}

impl Register {
    pub fn new(cylinders: usize) -> Self {
        Self { places: vec![[None; PLACES]; cylinders], standing: 0, due: None }
    }

    /// Number of standing warnings.
    pub const fn standing(&self) -> u32 {
        self.standing
    }

    /// Whether a warning of the cylinder of `index` (from 0) stands.
    pub fn any(&self, index: usize) -> bool {
        self.standing > 0 && self.places[index].iter().any(Option::is_some)
    }

    /// Whether a standing warning of the cylinder of `index` (from 0) blames `suspect`.
    #[inline]
    pub fn blames(&self, index: usize, suspect: Suspect) -> bool {
        self.standing > 0
            && self.places[index].iter().flatten().any(|place| place.finding.suspect == suspect)
    }

    /// Highest level of the standing warnings.
    pub fn level(&self) -> Level {
        if self.standing == 0 {
            return Level::None;
        }
        let standing = self.places.iter().flatten().flatten();
        standing.map(|standing| standing.finding.level).max().unwrap_or_default()
    }

    /// Takes the findings of the detectors of the cylinder of `index` at `at`, and passes a warning
    /// to `report` for each that is raised, changed or cleared. Returns whether there was one;
    /// [`Self::due`] may then have changed.
    pub fn update(
        &mut self,
        at: Timestamp,
        index: usize,
        findings: &[Option<Finding>; PLACES],
        mut report: impl FnMut(Warning),
    ) -> bool {
        let mut is_news = false;
        for (place, finding) in findings.iter().enumerate() {
            let standing = &mut self.places[index][place];
            let (state, finding) = match (&mut *standing, finding) {
                (None, None) => continue,
                (None, Some(finding)) => {
                    self.standing += 1;
                    *standing = Some(Standing { finding: *finding, repeat_at: at.after(REPEAT) });
                    (State::Raised, *finding)
                }
                (Some(known), Some(finding)) => {
                    let changed = !known.finding.says_as(finding);
                    known.finding = *finding;
                    if !changed {
                        continue;
                    }
                    known.repeat_at = at.after(REPEAT);
                    (State::Changed, *finding)
                }
                (Some(known), None) => {
                    let finding = known.finding;
                    self.standing -= 1;
                    *standing = None;
                    (State::Cleared, finding)
                }
            };
            let (cylinder, detector) = (index as u8 + 1, DETECTORS[place]);
            report(Warning { timestamp: at, cylinder, detector, place, state, finding });
            is_news = true;
        }
        if is_news {
            self.reckon_due();
        }
        is_news
    }

    /// Time of the next repetition.
    #[inline]
    pub const fn due(&self) -> Option<Timestamp> {
        self.due
    }

    fn reckon_due(&mut self) {
        self.due = self.times().min();
    }

    /// Times at which the standing warnings are repeated.
    pub fn times(&self) -> impl Iterator<Item = Timestamp> {
        self.places.iter().flatten().flatten().map(|standing| standing.repeat_at)
    }

    /// Whether the number of warnings and the earliest time are those of the places.
    fn is_reckoned(&self) -> bool {
        self.standing as usize == self.times().count() && self.due == self.times().min()
    }

    /// Passes to `report` every warning whose repetition is due by `at`.
    pub fn repeat(&mut self, at: Timestamp, mut report: impl FnMut(u8, Detector, &Finding)) {
        for (index, places) in self.places.iter_mut().enumerate() {
            for (place, standing) in places.iter_mut().enumerate() {
                if let Some(standing) = standing.as_mut().filter(|s| s.repeat_at <= at) {
                    standing.repeat_at = at.after(REPEAT);
                    report(index as u8 + 1, DETECTORS[place], &standing.finding);
                }
            }
        }
        self.reckon_due();
    }

    /// Restarts the periods of repetition at `at`, after a jump in time.
    pub fn rephase(&mut self, at: Timestamp) {
        for standing in self.places.iter_mut().flatten().flatten() {
            standing.repeat_at = at.after(REPEAT);
        }
        self.reckon_due();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blame::Rule;
    use crate::verdict::Fault;

    fn at(millis: i64) -> Timestamp {
        Timestamp::from_nanos(millis * 1_000_000)
    }

    fn found(suspect: Suspect, residual: f64) -> Option<Finding> {
        let fault = Fault::Abrupt;
        let (residual, threshold) = (Some(residual), Some(1e-3));
        let (evidence, device) = (None, None);
        let level = Level::Yellow;
        let rule = Rule::OneObserver;
        Some(Finding { fault, suspect, rule, level, residual, threshold, evidence, device })
    }

    fn with(places: &[(usize, Option<Finding>)]) -> [Option<Finding>; PLACES] {
        let mut findings = [None; PLACES];
        places.iter().for_each(|(place, finding)| findings[*place] = *finding);
        findings
    }

    #[test]
    fn the_earliest_repetition_of_those_that_stand_is_due() {
        let mut register = Register::new(2);
        assert_eq!(register.due(), None);
        let (first, second) = (found(Suspect::C1, 2e-3), found(Suspect::C2, 2e-3));
        assert!(register.update(at(0), 0, &with(&[(0, first)]), |_| {}));
        assert!(register.update(at(300), 1, &with(&[(2, second)]), |_| {}));
        assert_eq!(register.due(), Some(at(1000)));
        // A residual that moves says nothing new, and another suspect does.
        let moved = found(Suspect::C1, 3e-3);
        assert!(!register.update(at(500), 0, &with(&[(0, moved)]), |_| {}));
        assert_eq!(register.due(), Some(at(1000)));
        let changed = found(Suspect::Process, 3e-3);
        assert!(register.update(at(600), 0, &with(&[(0, changed)]), |_| {}));
        assert_eq!(register.due(), Some(at(1300)));
        let mut told = Vec::new();
        register.repeat(at(1300), |cylinder, detector, _| told.push((cylinder, detector)));
        assert_eq!((told, register.due()), (vec![(2, Detector::Fde3)], Some(at(1600))));
        register.rephase(at(100));
        assert_eq!(register.due(), Some(at(1100)));
        assert!(register.update(at(200), 0, &with(&[]), |_| {}));
        assert_eq!((register.due(), register.standing()), (Some(at(1100)), 1));
        assert!(register.update(at(300), 1, &with(&[]), |_| {}));
        assert_eq!((register.due(), register.level()), (None, Level::None));
    }

    #[test]
    fn blame_is_of_the_cylinder_that_the_warning_is_of() {
        let mut register = Register::new(2);
        register.update(at(0), 1, &with(&[(6, found(Suspect::C2, 1e-3))]), |_| {});
        assert!(register.blames(1, Suspect::C2) && !register.blames(1, Suspect::C1));
        assert!(!register.blames(0, Suspect::C2));
    }
}
