//! What a monitor knows of its own work: counts, tallies, and what it could not judge.

use super::cylinder::{Blank, Cylinder, Tally};
use super::page::Page;
use super::{Counts, Monitor};
use crate::incident::Incident;
use crate::sample::Transducer;

impl Monitor {
    pub const fn counts(&self) -> &Counts {
        &self.counts
    }

    /// Tallies of the cylinders, in their order.
    pub fn tallies(&self) -> impl Iterator<Item = &Tally> {
        self.cylinders.iter().map(Cylinder::tally)
    }

    /// The longest times in which the observers of each cylinder did not judge, in the order of the cylinders.
    pub fn blanks(&self) -> impl Iterator<Item = impl Iterator<Item = Blank>> {
        let newest = self.last.unwrap_or_default();
        self.cylinders.iter().map(move |cylinder| cylinder.blanks(newest))
    }

    /// Cycles that the observers on C1 and C2 of each cylinder did not judge, in the order of the cylinders; `None`
    /// for a transducer that is not configured.
    pub fn unjudged(&self) -> impl Iterator<Item = [Option<u64>; 2]> {
        self.cylinders.iter().map(Cylinder::unjudged)
    }

    /// Incidents that are not over, as they stand.
    pub fn standing(&self) -> impl Iterator<Item = Incident> {
        self.incidents.standing(self.last.unwrap_or_default())
    }

    /// Counts anew: from here the accounts are those of the frames that follow.
    pub fn count_anew(&mut self) {
        (self.counts, self.opened_once) = (Counts::default(), false);
        self.cylinders.iter_mut().for_each(Cylinder::count_anew);
        let pages = self.stations.iter_mut().flat_map(|station| &mut station.pages);
        pages.for_each(|page| page.slot.count_anew());
    }

    /// Whether the platform was in a monitored state in any cycle.
    pub const fn has_opened(&self) -> bool {
        self.opened_once
    }

    /// Jumps of the alive counters of C1 and C2, in the order of the cylinders.
    pub fn counter_jumps(&self) -> impl Iterator<Item = [u64; 2]> {
        let pages = || self.stations.iter().flat_map(|station| &station.pages);
        (0..self.cylinders.len() as u8).map(move |index| {
            [Transducer::C1, Transducer::C2].map(|transducer| {
                let counts = |page: &&Page| page.counted.contains(&(index, transducer));
                pages().filter(counts).map(|page| page.slot.jumps()).sum()
            })
        })
    }
}
