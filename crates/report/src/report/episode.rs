//! Episodes: warnings from raise to clear.

use tertius_core::alarm::register::PLACES;
use tertius_core::alarm::{Detector, Finding, State, Warning};
use tertius_core::time::Timestamp;
use tertius_core::verdict::Fault;

/// Most episodes that are kept for the page; further ones are counted.
pub const KEPT: usize = 500;

/// One warning from its raise to its clearing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Episode {
    pub cylinder: u8,
    pub detector: Detector,
    pub raised: Timestamp,
    /// Time of clearing; `None` while it stands.
    pub cleared: Option<Timestamp>,
    /// Fault that was named first, which later residuals may have corrected.
    pub first_fault: Fault,
    /// Finding as raised, with the fault, suspect, level and evidence as last changed.
    pub finding: Finding,
}

/// Episodes of a replay, in the order of their raise.
#[derive(Clone, Debug, Default)]
pub struct Episodes {
    kept: Vec<Episode>,
    left_out: u64,
    /// Number of warnings raised, for each detector in the order of [`Detector::ALL`].
    raised: [u64; Detector::ALL.len()],
    /// Counts of each cylinder, in order.
    cylinders: Vec<OfCylinder>,
}

#[derive(Clone, Debug, Default)]
struct OfCylinder {
    raised: u64,
    /// Index of the kept episode that stands at each place.
    standing: [Option<usize>; PLACES],
}

impl Episodes {
    /// Takes the next warning.
    pub fn take(&mut self, warning: &Warning) {
        match warning.state {
            State::Raised => self.raise(warning),
            State::Changed | State::Cleared => self.follow(warning),
        }
    }

    pub fn kept(&self) -> &[Episode] {
        &self.kept
    }

    /// Number of episodes beyond [`KEPT`].
    pub const fn left_out(&self) -> u64 {
        self.left_out
    }

    /// Number of warnings raised, for each detector in the order of [`Detector::ALL`].
    pub const fn raised(&self) -> &[u64; Detector::ALL.len()] {
        &self.raised
    }

    /// Number of warnings raised for the cylinder `n` (from 1).
    pub fn of_cylinder(&self, n: usize) -> u64 {
        self.cylinders.get(n - 1).map_or(0, |cylinder| cylinder.raised)
    }

    fn raise(&mut self, warning: &Warning) {
        self.raised[warning.detector as usize - 1] += 1;
        let kept = self.kept.len() < KEPT;
        let place = kept.then_some(self.kept.len());
        let cylinder = self.cylinder(warning);
        cylinder.raised += 1;
        cylinder.standing[warning.place] = place;
        if !kept {
            self.left_out += 1;
            return;
        }
        self.kept.push(Episode {
            cylinder: warning.cylinder,
            detector: warning.detector,
            raised: warning.timestamp,
            cleared: None,
            first_fault: warning.finding.fault,
            finding: warning.finding,
        });
    }

    fn follow(&mut self, warning: &Warning) {
        let Some(index) = self.cylinder(warning).standing[warning.place] else { return };
        let episode = &mut self.kept[index];
        let Finding { fault, suspect, level, evidence, device, .. } = warning.finding;
        episode.finding = Finding { fault, suspect, level, evidence, device, ..episode.finding };
        if warning.state == State::Cleared {
            episode.cleared = Some(warning.timestamp);
            self.cylinder(warning).standing[warning.place] = None;
        }
    }

    fn cylinder(&mut self, warning: &Warning) -> &mut OfCylinder {
        let index = usize::from(warning.cylinder) - 1;
        if self.cylinders.len() <= index {
            self.cylinders.resize_with(index + 1, OfCylinder::default);
        }
        &mut self.cylinders[index]
    }
}
