//! What the monitor of a cylinder is made from.

use super::dead_reckoning::ReckoningParameters;
use super::last::LastParameters;
use crate::alarm::{Deadlines, Levels};
use crate::compare::Comparator;
use crate::estimate;
use crate::frame::BusNumber;
use crate::incident::{EventTiming, QUANTITIES};
use crate::observe::commands::LearntCommands;
use crate::observe::observer::ObserverDesign;
use crate::process::ProcessDesign;
use crate::sample::device::DeviceDesign;
use crate::sample::plausibility::PlausibilityLimits;
use crate::sample::{Field, Transducer};
use crate::sequential;
use crate::time::Span;
use crate::verdict::{BankDesign, Thresholds, Trigger};

/// Design of the monitor of one cylinder.
#[derive(Clone, Debug)]
pub struct CylinderDesign {
    /// Cylinder number, counted from 1.
    pub number: u8,
    /// Fields that a complete cycle has, by [`crate::sample::Field::bit`].
    pub required: u16,
    /// Fields for which a cycle is held open until its deadline: the required ones, and pressures and the spool where they are
    /// read, which never make a cycle incomplete. Those that come too seldom are no longer awaited then, see
    /// [`crate::sample::Awaited`].
    pub awaited: u16,
    /// Plausibility limits of C1 and C2; those of C2 are unused on a cylinder without it.
    pub limits: [PlausibilityLimits; 2],
    /// Buses of C1, C2 and the command, by [`crate::sample::DeviceRole`].
    pub buses: [BusNumber; 3],
    /// CANopen devices that tell of themselves, by [`crate::sample::DeviceRole`].
    pub devices: [Option<DeviceDesign>; 3],
    /// Command at which the cylinder rests, m/s.
    pub command_offset: f64,
    /// Cycles without a command after which it is stale.
    pub command_stale: u32,
    /// Commands that the thresholds of R1 and R2 were learnt with.
    pub commands: LearntCommands,
    /// Command speed beyond which it moves the cylinder, m/s.
    pub moving_speed: f64,
    pub observers: [ObserverDesign; 2],
    pub comparator: Comparator,
    pub bank: BankDesign,
    /// Whether FDE1 and FDE2 judge by their threshold; where not, they find a fault by joint evidence alone, and no transducer is
    /// healthy by them.
    pub observes: bool,
    /// Whether FDE3 judges by its threshold.
    pub compares: bool,
    /// What the last transducer, and a departure from dead reckoning, are judged by.
    pub last: &'static LastParameters,
    pub reckoning: &'static ReckoningParameters,
    /// Sequential detector; `None` where no calibration for it is configured.
    pub sequential: Option<sequential::Design>,
    /// Process detector; `None` where nothing of it is configured.
    pub process: Option<ProcessDesign>,
    pub estimate: estimate::SensorDesign,
    /// Measured |C1 − C2| beyond which the machine itself trips, m.
    pub critical: f64,
    pub levels: Levels,
    /// Times until the machine trips at which a difference is of another level.
    pub deadlines: Deadlines,
    /// Time within which findings belong to one event, and the same in cycles.
    pub coincidence: Span,
    pub coincidence_cycles: u32,
    /// Time of good readings that clears a plausibility warning.
    pub clear: Span,
}

impl CylinderDesign {
    /// Trigger of the measured C1 − C2.
    pub fn trip(&self) -> Trigger {
        Trigger::new(Thresholds { low: self.critical, high: self.critical, clear: self.clear })
    }

    /// The bank that judges: a threshold that is not to be judged by is never exceeded.
    pub fn judging_bank(&self) -> BankDesign {
        let never = |it: Thresholds| Thresholds { low: f64::INFINITY, high: f64::INFINITY, ..it };
        let BankDesign { observer, difference, .. } = self.bank;
        BankDesign {
            observer: if self.observes { observer } else { never(observer) },
            difference: if self.compares { difference } else { never(difference) },
            ..self.bank.clone()
        }
    }

    /// Times by which its warnings are one event.
    pub const fn event_timing(&self) -> EventTiming {
        EventTiming { coincidence: self.coincidence, clear: self.clear }
    }

    /// Limits of the quantities of an incident, m; infinite where a quantity does not exist, as R2 without C2.
    pub const fn limits(&self) -> [f64; QUANTITIES] {
        let (observer, difference) = (self.bank.observer.high, self.bank.difference.high);
        if self.has(Transducer::C2) {
            [observer, observer, difference, self.critical]
        } else {
            [observer, f64::INFINITY, f64::INFINITY, f64::INFINITY]
        }
    }

    /// Whether the cylinder has this transducer.
    pub const fn has(&self, transducer: Transducer) -> bool {
        self.required & Field::Position(transducer).bit() != 0
    }
    /// The stroke without its ends, where a stop may hold the rod, m.
    pub fn inner_stroke(&self) -> [f64; 2] {
        let (least, most) = self.limits[0].lengths;
        let end = self.last.stop * (most - least);
        [least + end, most - end]
    }

    /// Whether a stop may hold a rod of this length, m.
    pub fn is_near_end(&self, length: f64) -> bool {
        let [least, most] = self.inner_stroke();
        !(least..=most).contains(&length)
    }
}
