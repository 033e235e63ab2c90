//! What all cylinders together say of their supply.

use super::Monitor;
use super::cylinder::Cylinder;
use super::gate::Opening;
use crate::process::{OilSample, Process, ProcessParameters, SupplyWatch};
use crate::time::Timestamp;

/// Fewer cylinders than this are no many.
const LEAST: usize = 2;

impl Monitor {
    /// The supply of all cylinders, if it is watched.
    pub fn supply(&self) -> Option<&SupplyWatch> {
        self.supply.as_deref()
    }

    /// Takes what all cylinders say of their supply at the end of a cycle.
    pub(super) fn follow_supply(&mut self, at: Timestamp) {
        let odd = |cylinder: &Cylinder| cylinder.process().is_some_and(Process::has_odd_chambers);
        let odd = self.cylinders.iter().filter(|cylinder| odd(cylinder)).count();
        // All of them know the same.
        if odd > 0 || self.cylinders.first().is_some_and(|cylinder| cylinder.supply_is_odd) {
            self.follow_chambers(odd);
        }
        if self.supply.is_some() {
            self.watch_supply(at);
        }
    }

    /// Compares the supply's pressure with what all rods have taken.
    #[inline(never)]
    fn watch_supply(&mut self, at: Timestamp) {
        let is_open = self.gate.look(at).0 == Opening::Open;
        let Self { supply: Some(supply), cylinders, .. } = self else { return };
        supply.step(read(cylinders).as_ref(), is_open, at);
        if let Some((alarm, is_judging)) = supply.news() {
            for process in cylinders.iter_mut().filter_map(Cylinder::process_mut) {
                process.take_supply(alarm, is_judging);
            }
        }
    }

    /// Takes a cycle that did not come.
    pub(super) fn lose_supply(&mut self) {
        self.supply.iter_mut().for_each(|supply| supply.lose());
    }

    /// Forgets what was going on, after a time of which nothing is known.
    pub(super) fn interrupt_supply(&mut self) {
        self.supply.iter_mut().for_each(|supply| supply.interrupt());
    }

    /// Lays pressures that do not add up in most cylinders at once, of which `odd` are, on the supply, which is what they
    /// have in common.
    #[cold]
    fn follow_chambers(&mut self, odd: usize) {
        let comparing = self.cylinders.iter().filter_map(Cylinder::process);
        let known = comparing.filter(|process| process.knows_chambers()).count();
        let is_many = odd as f64 >= ProcessParameters::DEFAULT.many * known as f64;
        let is_odd = odd >= LEAST && is_many;
        self.cylinders.iter_mut().for_each(|cylinder| cylinder.supply_is_odd = is_odd);
    }
}

/// The supply's pressure and every rod's length in the newest cycle; `None` if anything is missing.
fn read(cylinders: &[Cylinder]) -> Option<OilSample> {
    let mut sample = OilSample::default();
    for (length, cylinder) in sample.lengths.iter_mut().zip(cylinders) {
        let oil = cylinder.process()?.oil();
        *length = oil.length?;
        sample.pressure = oil.pressure?;
    }
    Some(sample)
}
