//! What a process detector has found, by what it judged, and what it is told of the supply.

use super::super::alarm::ProcessAlarm;
use super::super::input::OilReading;
use super::super::relation::{RELATIONS, Relation};
use super::Process;

impl Process {
    /// The alarm that counts: pressures that do not add up explain a spool that is off, either of them a supply that falls
    /// short, all of them what the oil does, and that the rod goes harder; not the other way round.
    #[inline]
    pub fn alarm(&self) -> Option<&ProcessAlarm> {
        if !self.is_raised {
            return None;
        }
        let [spool, chambers, flow, friction, supply] = &self.alarms;
        let chambers = chambers.as_ref().filter(|alarm| alarm.age >= self.counts.company);
        let [spool, supply, flow, friction] = [spool, supply, flow, friction].map(Option::as_ref);
        chambers.or(spool).or(supply).or(flow).or(friction)
    }

    /// What the newest cycle told of the machine's supply.
    pub const fn oil(&self) -> OilReading {
        self.oil
    }

    /// Takes what is known of the machine's supply at the end of a cycle in which it has changed: its alarm, and whether it
    /// is judged.
    #[inline]
    pub fn take_supply(&mut self, alarm: Option<ProcessAlarm>, is_judged: bool) {
        self.alarms[Relation::Supply as usize] = alarm;
        self.is_raised = self.alarms.iter().any(Option::is_some);
        self.is_supply_judged = is_judged;
    }

    /// Whether the chambers' pressures do not add up.
    #[inline]
    pub const fn has_odd_chambers(&self) -> bool {
        self.alarms[Relation::Chambers as usize].is_some()
    }

    /// Whether it compares the chambers' pressures.
    pub const fn knows_chambers(&self) -> bool {
        self.design.chambers.is_some()
    }

    /// Which relations it can judge by.
    pub const fn knows(&self) -> [bool; RELATIONS] {
        let [spool, chambers] = &self.weighings;
        let flow = self.design.is_pair && self.flow.is_some();
        [spool.is_some(), chambers.is_some(), flow, self.friction.is_some(), self.design.supply]
    }

    /// A bit for each relation that judged the newest cycle, and for that of the supply if it judged the one before.
    #[inline]
    pub const fn judged(&self) -> u8 {
        self.judged
    }
}
