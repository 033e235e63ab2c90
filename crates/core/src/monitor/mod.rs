//! The monitor: time-stamped frames in, records, warnings and the gateway's frames out.
//!
//! It has no clock. Time passes with the time stamps of the frames it uses and with
//! [`Monitor::advance`]; whatever falls due in between is done first, at the time at which it was
//! due. A gateway that advances by its clock, some guard time behind the bus, and a replay of the
//! same frames therefore agree.

mod accounts;
mod counts;
mod cycles;
pub mod cylinder;
mod estimates;
mod evaluating;
mod explaining;
mod filling;
mod frames;
pub mod gate;
mod implausible;
mod intake;
mod machine;
mod page;
mod passage;
mod reporting;
mod saved;
mod silence;
pub mod sink;
pub mod subscriptions;

use crate::alarm::status::{MAX_CYLINDERS, Status};
use crate::alarm::{Encoder, Register};
use crate::frame::Buses;
use crate::hexapod::{Tilt, TiltDesign};
use crate::incident::Incidents;
use crate::process::{SupplyDesign, SupplyWatch};
use crate::sample::cycle::{CycleClock, CycleTiming, Due};
use crate::sample::sync_watch::SyncWatch;
use crate::sequential::Sampling;
use crate::time::Timestamp;
use alloc::{boxed::Box, vec::Vec};
pub use counts::Counts;
use cylinder::{Cylinder, CylinderDesign};
pub use estimates::Estimates;
pub use explaining::{Answer, Explained, Explanation};
use gate::Gate;
use page::Station;
pub use saved::{DesignChecksum, MAX_STATE, SavedState, StateRefusal};
use silence::Silence;
pub use sink::{Notice, Record, Sink};
use subscriptions::Subscriptions;

/// Everything a monitor is made from.
#[derive(Clone, Debug)]
pub struct MonitorDesign {
    pub subscriptions: Subscriptions,
    pub timing: CycleTiming,
    /// Most missing cycles over which observers predict; a longer silence is reported as a gap.
    pub gap_cycles: u64,
    pub gate: Gate,
    /// Designs of the cylinders, at most [`MAX_CYLINDERS`].
    pub cylinders: Vec<CylinderDesign>,
    /// Comparison of the deck's attitude with a sensor on it; only for a hexapod.
    pub tilt: Option<TiltDesign>,
    /// The supply of all cylinders, where it was taught.
    pub supply: Option<SupplyDesign>,
    pub estimates: Estimates,
    pub encoder: Encoder,
}

/// Location of a page: the index of its message, and its own among the pages of that message.
type Place = (usize, usize);

// `fill` has a bit for each cylinder.
const _: () = assert!(MAX_CYLINDERS <= u8::BITS as usize);

/// The monitor of one machine.
#[derive(Clone, Debug)]
pub struct Monitor {
    subscriptions: Subscriptions,
    /// The messages of `subscriptions`, in its order.
    stations: Vec<Station>,
    /// Whether any page keeps a frame.
    keeps: bool,
    /// Whether any device sends by a timer of its own.
    by_timers: bool,
    /// Whether any cylinder has a process detector.
    has_process: bool,
    /// `None` without a sensor on the deck.
    tilt: Option<Box<Tilt>>,
    /// `None` without a table of the supply.
    supply: Option<Box<SupplyWatch>>,
    clock: CycleClock,
    /// Unused on a machine without Sync.
    sync_watch: SyncWatch,
    gap_cycles: u64,
    gate: Gate,
    cylinders: Vec<Cylinder>,
    sampling: Sampling,
    /// Number of cylinders still to be evaluated in the open cycle.
    pending: usize,
    sends_estimates: bool,
    incomplete: bool,
    /// Number of missing cycles since the last real one.
    missing_run: u64,
    /// Buses from which anything that belongs to a cycle has arrived since the last cycle closed.
    heard: Buses,
    /// `None` if the machine has a single bus.
    silence: Option<Silence>,
    monitored_once: bool,
    /// Whether the platform was in a monitored state in some cycle.
    opened_once: bool,
    register: Register,
    incidents: Incidents,
    encoder: Encoder,
    counts: Counts,
    last: Option<Timestamp>,
    next_status: Timestamp,
    last_status: Option<(Timestamp, Status)>,
    /// Earliest time at which anything falls due, so that most frames need one comparison.
    next_due: Timestamp,
}

impl Monitor {
    pub fn new(design: MonitorDesign) -> Self {
        debug_assert!(design.cylinders.len() <= MAX_CYLINDERS);
        let silence = Silence::of(&design.subscriptions, design.gap_cycles);
        let of_incidents = |it: &CylinderDesign| (it.limits(), it.event_timing());
        let sample_time = design.timing.sample_time;
        let incidents = Incidents::new(design.cylinders.iter().map(of_incidents), sample_time);
        let cylinders = design.cylinders.into_iter().map(Cylinder::new);
        let cylinders: Vec<Cylinder> = match design.estimates {
            Estimates::None => cylinders.collect(),
            Estimates::Computed | Estimates::Sent => cylinders.map(Cylinder::estimating).collect(),
        };
        Self {
            stations: design.subscriptions.all().iter().map(Station::new).collect(),
            by_timers: design.subscriptions.all().iter().any(|message| message.by_timer),
            subscriptions: design.subscriptions,
            keeps: false,
            clock: CycleClock::new(design.timing),
            sync_watch: SyncWatch::default(),
            gap_cycles: design.gap_cycles,
            gate: design.gate,
            register: Register::new(cylinders.len()),
            has_process: cylinders.iter().any(|cylinder| cylinder.process().is_some()),
            tilt: design.tilt.as_ref().map(|design| Box::new(Tilt::new(design))),
            supply: design.supply.map(|design| Box::new(SupplyWatch::new(design))),
            incidents,
            cylinders,
            sampling: Sampling::default(),
            pending: 0,
            sends_estimates: design.estimates == Estimates::Sent,
            incomplete: false,
            missing_run: 0,
            heard: Buses::NONE,
            silence,
            monitored_once: false,
            opened_once: false,
            encoder: design.encoder,
            counts: Counts::default(),
            last: None,
            next_status: Timestamp::default(),
            last_status: None,
            next_due: Timestamp::default(),
        }
    }

    /// Number of the platform's state, if it is known at the time of the newest frame.
    pub fn platform(&self) -> Option<i64> {
        self.gate.number(self.last?)
    }

    fn reckon_due(&mut self) {
        let cycle = self.clock.due().map(Due::at);
        let times = [cycle, self.register.due()].into_iter().flatten();
        self.next_due = times.fold(self.next_status, Timestamp::min);
    }
}
