//! The warnings that stand, and what is said of each: raised, changed, cleared, repeated.

use super::Level;
use super::warning::{Detector, Finding, State, Warning};
use crate::time::{Span, Timestamp};

/// Where a warning of a cylinder has its place: FDE1, FDE2, FDE3, the plausibility of C1, C2 and the
/// command, then the sequential detector.
pub const PLACES: usize = 7;

/// The detector of each place.
pub const DETECTORS: [Detector; PLACES] = [
    Detector::Fde1,
    Detector::Fde2,
    Detector::Fde3,
    Detector::Plausibility,
    Detector::Plausibility,
    Detector::Plausibility,
    Detector::Sequential,
];

/// A standing warning is sent again this often.
const REPEAT: Span = Span::from_nanos(1_000_000_000);

#[derive(Clone, Copy, Debug)]
struct Standing {
    finding: Finding,
    repeat_at: Timestamp,
}

/// All warnings that stand; one place for each detector of each cylinder, so it never grows.
#[derive(Clone, Debug)]
pub struct Register {
    places: Vec<[Option<Standing>; PLACES]>,
    standing: u32,
}

impl Register {
    pub fn new(cylinders: usize) -> Self {
        Self { places: vec![[None; PLACES]; cylinders], standing: 0 }
    }

    /// How many warnings stand.
    pub const fn standing(&self) -> u32 {
        self.standing
    }

    /// Whether a warning of the cylinder of `index` (from 0) stands.
    pub fn any(&self, index: usize) -> bool {
        self.standing > 0 && self.places[index].iter().any(Option::is_some)
    }

    /// What stands for the cylinder of `index` (from 0).
    pub fn findings(&self, index: usize) -> [Option<Finding>; PLACES] {
        self.places[index].map(|place| place.map(|standing| standing.finding))
    }

    /// The highest level that stands.
    pub fn level(&self) -> Level {
        let standing = self.places.iter().flatten().flatten();
        standing.map(|standing| standing.finding.level).max().unwrap_or_default()
    }

    /// Takes what the detectors of the cylinder of `index` find at `at`, and gives `say` a warning
    /// for each that is raised, changed or cleared by it.
    pub fn update(
        &mut self,
        at: Timestamp,
        index: usize,
        findings: &[Option<Finding>; PLACES],
        mut say: impl FnMut(Warning),
    ) {
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
            say(Warning { timestamp: at, cylinder, detector, place, state, finding });
        }
    }

    /// When the next repetition is due.
    pub fn due(&self) -> Option<Timestamp> {
        if self.standing == 0 {
            return None;
        }
        self.places.iter().flatten().flatten().map(|standing| standing.repeat_at).min()
    }

    /// Gives `say` every warning whose repetition is due by `at`.
    pub fn repeat(&mut self, at: Timestamp, mut say: impl FnMut(u8, Detector, &Finding)) {
        for (index, places) in self.places.iter_mut().enumerate() {
            for (place, standing) in places.iter_mut().enumerate() {
                if let Some(standing) = standing.as_mut().filter(|s| s.repeat_at <= at) {
                    standing.repeat_at = at.after(REPEAT);
                    say(index as u8 + 1, DETECTORS[place], &standing.finding);
                }
            }
        }
    }

    /// Counts the repetitions from `at`, after a jump in time.
    pub fn rephase(&mut self, at: Timestamp) {
        for standing in self.places.iter_mut().flatten().flatten() {
            standing.repeat_at = at.after(REPEAT);
        }
    }
}
