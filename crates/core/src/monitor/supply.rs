//! What the chambers' pressures of all cylinders together say of the supply's.

use super::Monitor;
use super::cylinder::Cylinder;
use crate::process::ProcessParameters;

/// Fewer cylinders than this are no many.
const LEAST: usize = 2;

impl Monitor {
    /// Lays pressures that do not add up in most cylinders at once on the supply, which is what they have in
    /// common.
    pub(super) fn follow_supply(&mut self) {
        let comparing = || self.cylinders.iter().filter_map(Cylinder::process);
        let odd = comparing().filter(|process| process.has_odd_chambers()).count();
        let is_many = || {
            let known = comparing().filter(|process| process.knows_chambers()).count();
            odd as f64 >= ProcessParameters::DEFAULT.many * known as f64
        };
        let is_odd = odd >= LEAST && is_many();
        self.cylinders.iter_mut().for_each(|cylinder| cylinder.supply_is_odd = is_odd);
    }
}
