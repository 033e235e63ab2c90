//! What a monitor hands on to the next one of the same machine: what was read on the stops.

use super::Monitor;
use crate::sequential::Archive;

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
}
