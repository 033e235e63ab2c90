//! Alarms of a process detector.

use crate::alarm::Urgency;
use crate::state::{choice, whole};
use crate::time::Timestamp;

/// What is wrong with a cylinder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Malfunction {
    /// Its hydraulics; nobody knows what yet.
    Unclassified,
    /// The spool sticks. Sizes are in the unit of the spool's signal.
    Sticking,
    /// The spool stands beside its command.
    Offset,
    /// The command comes late; the size is in cycles.
    Late,
    /// The valve gets, or follows, another command.
    OtherCommand,
    /// The pressures do not add up. The size is in bar.
    Chambers,
    /// Oil passes the piston, or the valve's worn edges. The size is the speed that is lost at 24 bar, m/s.
    Leakage,
    /// The valve passes oil as if its spool stood further out. The size is in the unit of the spool's signal.
    Null,
    /// The valve's ports open later. The size is in the unit of the spool's signal.
    DeadBand,
    /// The rod goes harder. The size is the load pressure that it takes more, bar.
    Friction,
    /// The supply's pressure falls short of what the rods leave of it. The size is by how much it is beside what a sound
    /// pump would have brought about, bar.
    Supply,
}

choice! {
    Malfunction {
        Unclassified, Sticking, Offset, Late, OtherCommand, Chambers, Leakage, Null, DeadBand,
        Friction, Supply,
    }
}

/// An alarm that stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProcessAlarm {
    pub malfunction: Malfunction,
    /// Its size, in the unit of the malfunction, where it is known.
    pub size: Option<f64>,
    /// The most evidence so far, nats.
    pub nats: f64,
    /// How soon the supply no longer carries the load; none for what is of one cylinder.
    pub urgency: Urgency,
    /// Begin of the window in which it was found.
    pub onset: Timestamp,
    /// Cycles since it was raised.
    pub(super) age: u32,
    /// Cycles without evidence.
    pub(super) quiet: u32,
}

whole! { ProcessAlarm { malfunction, size, nats, urgency, onset, age, quiet } }

impl ProcessAlarm {
    /// Takes evidence of `nats` of so many `cycles`, which is for it from `least` nats on; returns whether it has not been
    /// for more than `clear` cycles.
    pub(super) fn follow(&mut self, nats: f64, least: f64, cycles: u32, clear: u32) -> bool {
        self.age = self.age.saturating_add(cycles);
        self.nats = self.nats.max(nats);
        self.quiet = if nats < least { self.quiet.saturating_add(cycles) } else { 0 };
        self.quiet > clear
    }
}
