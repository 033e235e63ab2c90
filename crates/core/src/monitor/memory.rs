//! The history of dwells, which one monitor saves and the next one of the same machine restores.

use super::Monitor;
use super::cylinder::Cylinder;
use crate::sequential::{Archive, DwellHistory, stops};
use crate::time::Timestamp;

impl Monitor {
    /// Restores the dwells of an earlier monitor of the same machine.
    pub fn restore(&mut self, archive: &Archive) {
        for (cylinder, dwells) in self.cylinders.iter_mut().zip(&archive.cylinders) {
            cylinder.restore(dwells);
        }
    }

    /// Cylinder number and readings on the stop of each cylinder that keeps them.
    pub fn dwells(&self) -> impl Iterator<Item = (u8, &DwellHistory)> {
        self.cylinders.iter().filter_map(Cylinder::dwells)
    }

    /// Saves the dwells in `archive`. The dwells there of a cylinder that keeps none stay.
    pub fn save(&self, archive: &mut Archive) {
        for (n, dwells) in self.dwells() {
            if let Some(place) = archive.cylinders.get_mut(usize::from(n).wrapping_sub(1)) {
                place.clone_from(dwells);
            }
        }
    }

    /// Judges every cylinder after a rod was read on its stop. The others serve as the thermometer,
    /// so each is judged again with each reading.
    pub(super) fn judge_stops(&mut self, at: Timestamp) {
        let judged = stops::judge(self.dwells().map(|(_, dwells)| dwells));
        let known = self.cylinders.iter_mut().filter(|cylinder| cylinder.dwells().is_some());
        for (cylinder, judgement) in known.zip(judged) {
            if let Some(judgement) = judgement {
                cylinder.judge_stop(at, &judgement);
            }
        }
    }
}
