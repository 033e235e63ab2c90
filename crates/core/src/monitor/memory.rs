//! What a monitor hands on to the next one of the same machine: what was read on the stops.

use super::Monitor;
use crate::sequential::{Archive, stops};
use crate::time::Timestamp;

impl Monitor {
    /// Goes on with the dwells of an earlier monitor of the same machine.
    pub fn inherit(&mut self, archive: &Archive) {
        for (cylinder, dwells) in self.cylinders.iter_mut().zip(&archive.cylinders) {
            cylinder.inherit(dwells);
        }
    }

    /// Puts the dwells into `archive`. A cylinder that has no detector keeps there what it has.
    pub fn bequeath(&self, archive: &mut Archive) {
        for (n, sequential) in self.sequential() {
            if let Some(place) = archive.cylinders.get_mut(usize::from(n).wrapping_sub(1)) {
                place.clone_from(sequential.dwells());
            }
        }
    }

    /// A rod was read on its stop: what that says of any of them. The others are the thermometer, so each
    /// is judged anew with each that was read.
    pub(super) fn judge_stops(&mut self, at: Timestamp) {
        let judged = stops::judge(self.sequential().map(|(_, sequential)| sequential.dwells()));
        let known = self.cylinders.iter_mut().filter(|cylinder| cylinder.sequential().is_some());
        for (cylinder, judgement) in known.zip(judged) {
            if let Some(judgement) = judgement {
                cylinder.judge_stop(at, &judgement);
            }
        }
    }
}
