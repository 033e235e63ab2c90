//! What befalls the process, and is no fault of a transducer.

use crate::controller::Commands;
use crate::plant::{CYLINDERS, ValveTable};
use serde::Deserialize;

/// The table of it; what is not there does not happen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Disturbance {
    /// `part` times the load, of all cylinders.
    pub load: Option<Change>,
    /// `part` of the pump's flow.
    pub pump: Option<Change>,
    /// Spools stick.
    pub sticking: Option<Sticking>,
    /// The valves that are built in, where they are others than those that the controller's look-up
    /// tables were measured on.
    pub valve: Option<ValveTable>,
}

/// Something is another part of what it is usually.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Change {
    /// From and until, s after the first cycle.
    pub time: [f64; 2],
    pub part: f64,
}

/// Stiction of a spool: it stays until its command is further away than `band`, and then goes there.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sticking {
    /// From and until, s after the first cycle.
    pub time: [f64; 2],
    /// Part of the spool's full stroke.
    pub band: f64,
}

impl Disturbance {
    /// What the loads are multiplied by at `time`, s.
    pub fn load(&self, time: f64) -> f64 {
        part(self.load, time)
    }

    /// What of the pump's flow is missing at `time`, s: 0 to 1.
    pub fn pump_lost(&self, time: f64) -> f64 {
        1.0 - part(self.pump, time)
    }

    /// Where spools go at `time`, s, that are at `before`, by their commands.
    pub fn spools(
        &self,
        time: f64,
        before: &[f64; CYLINDERS],
        commands: &Commands,
    ) -> [f64; CYLINDERS] {
        let band = self.sticking.filter(|it| is_in(it.time, time)).map_or(0.0, |it| it.band);
        std::array::from_fn(|leg| {
            let (before, wanted) = (before[leg], commands.spools[leg]);
            if (wanted - before).abs() < band { before } else { wanted }
        })
    }
}

fn is_in([from, until]: [f64; 2], time: f64) -> bool {
    (from..until).contains(&time)
}

fn part(change: Option<Change>, time: f64) -> f64 {
    change.filter(|change| is_in(change.time, time)).map_or(1.0, |change| change.part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sticking_spool_goes_only_where_it_is_far_from() {
        let sticking = Some(Sticking { time: [1.0, 2.0], band: 0.02 });
        let disturbance = Disturbance { sticking, ..Disturbance::default() };
        let commands = |spool: f64| Commands { spools: [spool; CYLINDERS], ..Commands::default() };
        for (time, before, wanted, expected) in [
            (0.5, 0.1, 0.105, 0.105),
            (1.5, 0.1, 0.119, 0.1),
            (1.5, 0.1, 0.081, 0.1),
            (1.5, 0.1, 0.121, 0.121),
            (2.5, 0.1, 0.105, 0.105),
        ] {
            let spools = disturbance.spools(time, &[before; CYLINDERS], &commands(wanted));
            assert_eq!(spools, [expected; CYLINDERS], "{time} {wanted}");
        }
    }

    #[test]
    fn without_a_table_nothing_happens() {
        let none = Disturbance::default();
        assert_eq!((none.load(7.0), none.pump_lost(7.0)), (1.0, 0.0));
    }
}
