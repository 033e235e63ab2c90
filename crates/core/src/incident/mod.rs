//! Incidents: the warnings of a cylinder that have one cause, as one story.
//!
//! A fault raises several detectors, some of them again when it ends, and some only now and then while it is
//! near their thresholds. A person asks what is wrong, since when, how bad it is and how sure that is. An
//! [`Incident`] answers: it begins with the first warning, takes in those that belong to it (`joining`), ends
//! when the last of them has cleared and none came after it, and says what all of them together (`fusing`)
//! mean. What most cylinders show in one moment, and what is wrong with the supply that they share, is one incident of
//! the machine (`shared`).

mod adding;
mod cause;
mod drifting;
mod fusing;
mod joining;
mod news;
mod parameters;
mod scope;
mod shared;
#[cfg(test)]
mod tests;
mod tracker;

use crate::alarm::detector::{PLACES, WarningPlace};
use crate::alarm::{Finding, Level};
use crate::state::{choice, whole};
use crate::time::Timestamp;
use crate::verdict::{Fault, Suspect};
pub use parameters::{EventTiming, IncidentParameters};
pub use scope::{Cylinders, Scope};
pub use tracker::{Incidents, MOST_AT_ONCE};

/// What happened to an incident.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    Opened,
    /// Its suspect, its kind or its level is another one now, a further detector was raised, or it has grown (`news`).
    Revised,
    /// It stands at the end of the data.
    Standing,
    Closed,
}

choice! { Progress { Opened, Revised, Standing, Closed } }

impl Progress {
    /// Name in files and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Opened => "opened",
            Self::Revised => "revised",
            Self::Standing => "standing",
            Self::Closed => "closed",
        }
    }
}

/// Why an incident is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The fault was seen to go: a reading came back by a step against its first direction, or
    /// passed the plausibility checks again.
    Returned,
    /// Nothing exceeds a threshold any more. The fault may be there still, below them.
    Quiet,
    /// The bus was lost, the clock was set or the recording ended before it could be known whether
    /// it would come again.
    Cut,
    /// Most other cylinders show the same: it goes on as a part of an incident of the machine.
    Joined,
}

choice! { Ending { Returned, Quiet, Cut, Joined } }

impl Ending {
    /// Name in files and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Returned => "returned",
            Self::Quiet => "quiet",
            Self::Cut => "cut",
            Self::Joined => "joined",
        }
    }
}

/// A quantity that is compared with a limit in each cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    R1,
    R2,
    R3,
    /// C1 − C2 as measured, on which the machine trips.
    Measured,
}

/// Number of quantities.
pub const QUANTITIES: usize = 4;

impl Quantity {
    pub const ALL: [Self; QUANTITIES] = [Self::R1, Self::R2, Self::R3, Self::Measured];

    /// Name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::R1 => "r1",
            Self::R2 => "r2",
            Self::R3 => "r3",
            Self::Measured => "c1_c2",
        }
    }
}

/// The quantities of a cylinder in one cycle, in the order of [`Quantity::ALL`], m, signed; `None` where one was
/// not judged.
pub type Quantities = [Option<f64>; QUANTITIES];

/// Largest absolute value of a quantity during an incident.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excursion {
    /// m, signed.
    pub value: f64,
    /// Opening of the cycle.
    pub at: Timestamp,
}

whole! { Excursion { value, at } }

/// When the present suspect of an incident was first named.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Naming {
    pub at: Timestamp,
    /// Whether it was named by the end of the fault: by the step that took the difference away.
    pub by_its_end: bool,
}

whole! { Naming { at, by_its_end } }

/// What the detectors of R1, R2 and R3 did in the cycle in which an incident opened.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outset {
    /// Whether each of them judged.
    pub judged: [bool; 3],
    /// Whether a warning of each stood already, for another incident.
    pub elsewhere: [bool; 3],
}

whole! { Outset { judged, elsewhere } }

/// One detector's share in an incident.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Time of the first raise.
    pub raised: Timestamp,
    /// Number of raises.
    pub raises: u32,
    /// Whether the warning stands.
    pub stands: bool,
    /// Finding as first raised, with fault, suspect and evidence as last revised before it first cleared.
    pub finding: Finding,
    /// Whether it has cleared once. What it says when it is raised again is about the fault's
    /// course or end, and fills in only what was not known.
    pub has_cleared: bool,
}

whole! { Part { raised, raises, stands, finding, has_cleared } }

/// What the warnings of a cylinder that have one cause say together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Incident {
    /// Number, from 1 in the order in which they are reported, over all cylinders.
    pub number: u32,
    pub scope: Scope,
    pub progress: Progress,
    /// Time of this report.
    pub timestamp: Timestamp,
    /// Time of its first warning.
    pub begin: Timestamp,
    /// When the fault began, as far as the data show it: [`Self::begin`] or earlier.
    pub onset: Timestamp,
    /// Time at which its last warning cleared, and why it is over; `None` until it is closed.
    pub end: Option<(Timestamp, Ending)>,
    pub suspect: Suspect,
    /// When that suspect was named; `None` while it is undecided.
    pub named: Option<Naming>,
    pub fault: Fault,
    /// Gain error where the fault is one, m per m, see [`crate::alarm::Evidence::gain`].
    pub gain: Option<f64>,
    /// Size of a step or of a difference that the evidence of many samples gives, m, signed.
    pub size: Option<f64>,
    /// R3 in the cycle in which FDE3 was first raised, m: unlike C1 − C2 as measured, by which the machine trips, it is
    /// without what the readings differ by when nothing is wrong.
    pub parted: Option<f64>,
    /// Highest level that it has reached.
    pub level: Level,
    /// Parts of the detectors, in the order of [`WarningPlace`].
    pub parts: [Option<Part>; PLACES],
    /// Peaks in the order of [`Quantity::ALL`]; [`Quantity::Measured`] only beyond the machine's own limit.
    pub peaks: [Option<Excursion>; QUANTITIES],
    /// The quantities in the newest cycle.
    pub now: Quantities,
    pub outset: Outset,
    /// Limits of the quantities, m; infinite where the cylinder has no such quantity.
    pub limits: [f64; QUANTITIES],
}

whole! {
    Incident {
        number, scope, progress, timestamp, begin, onset, end, suspect, named, fault, gain, size, parted, level,
        parts, peaks, now, outset, limits,
    }
}

impl Incident {
    /// The part of a detector's place.
    pub const fn part(&self, place: WarningPlace) -> Option<&Part> {
        self.parts[place as usize].as_ref()
    }

    /// Whether its cylinder has C1 alone, so that nothing is compared with another reading.
    pub const fn is_alone(&self) -> bool {
        self.limits[Quantity::R2 as usize].is_infinite()
    }

    /// Whether a warning of it stands.
    pub fn stands(&self) -> bool {
        self.parts.iter().flatten().any(|part| part.stands)
    }

    /// The quantity that was largest against its limit, with its peak: of those by which a detector of this incident was
    /// raised, but the measured difference where the machine itself would trip.
    pub fn worst(&self) -> Option<(Quantity, Excursion)> {
        let raised = |place: WarningPlace| self.part(place).is_some();
        let compared = [
            (Quantity::R1, raised(WarningPlace::Fde1)),
            (Quantity::R2, raised(WarningPlace::Fde2)),
            (Quantity::R3, raised(WarningPlace::Fde3) || raised(WarningPlace::Sequential)),
        ];
        let compared = compared.into_iter().filter(|(_, counts)| *counts);
        let peaks = compared.filter_map(|(quantity, _)| self.peak(quantity));
        let largest = peaks.max_by(|(a, _), (b, _)| self.share(*a).total_cmp(&self.share(*b)));
        self.peak(Quantity::Measured).filter(|_| self.trips()).or(largest)
    }

    /// Newest value of the quantity of [`Self::worst`]; `None` where it was not compared, and once the incident is over.
    pub fn worst_now(&self) -> Option<f64> {
        let (quantity, _) = self.worst()?;
        self.now[quantity as usize].filter(|_| self.end.is_none())
    }

    /// How bad [`Self::worst`] is, for comparison with others: whether the machine itself would trip, and the peak in terms
    /// of its limit, 0 where nothing was compared.
    pub fn severity(&self) -> (bool, f64) {
        (self.trips(), self.worst().map_or(0.0, |(quantity, _)| self.share(quantity)))
    }

    fn trips(&self) -> bool {
        self.share(Quantity::Measured) >= 1.0
    }

    fn peak(&self, quantity: Quantity) -> Option<(Quantity, Excursion)> {
        Some((quantity, self.peaks[quantity as usize]?))
    }

    /// Peak of a quantity in terms of its limit; 0 without one.
    fn share(&self, quantity: Quantity) -> f64 {
        let limit = self.limits[quantity as usize];
        self.peaks[quantity as usize].map_or(0.0, |peak| peak.value.abs() / limit)
    }
}
