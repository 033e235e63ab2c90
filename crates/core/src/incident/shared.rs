//! Incidents of the machine: what most cylinders show in one moment, their slow drifts at the same time, and the supply, which
//! all of them have in common.
//!
//! The incidents of the cylinders go on, each by its own warnings, but are not reported: they are the members of one incident
//! of the machine, which sums them up and suspects no transducer. A member with which one cylinder is left, when the others
//! have recovered, is that cylinder's own again.

use super::cause::Cause;
use super::joining::Open;
use super::{Cylinders, Ending, Incident, Outset, Part, Progress, QUANTITIES, Scope};
use crate::alarm::Level;
use crate::alarm::detector::{PLACES, WarningPlace};
use crate::state::whole;
use crate::time::Timestamp;
use crate::verdict::{Fault, Suspect};

/// What an incident of the machine says that is news to a person when it changes.
type Said = (Cylinders, Fault, bool, Level);

/// An incident of the machine that is not closed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shared {
    pub incident: Incident,
    /// Time of the newest raise or clearing of a member.
    pub newest: Timestamp,
    /// The least certain ending of the members that are over.
    ending: Option<Ending>,
    reported: Option<Said>,
}

whole! { Shared { incident, newest, ending, reported } }

impl Shared {
    /// The incident that begins with `open`, which it does not yet include.
    pub fn new(number: u32, open: &Open) -> Self {
        let incident = Incident {
            number,
            scope: Scope::Machine(Cylinders::NONE),
            suspect: Suspect::Process,
            named: None,
            fault: Fault::Unclassified,
            gain: None,
            size: None,
            parted: None,
            level: Level::None,
            parts: [None; PLACES],
            peaks: [None; QUANTITIES],
            now: [None; QUANTITIES],
            outset: Outset::default(),
            ..open.incident
        };
        Self { incident, newest: open.newest, ending: None, reported: None }
    }

    /// Begins to sum up the members anew; what is over stays.
    pub fn begin(&mut self) {
        self.incident.parts.iter_mut().flatten().for_each(|part| part.stands = false);
    }

    /// Takes the member of the cylinder of `index`, counted from 0.
    pub fn take(&mut self, index: usize, open: &Open) {
        let (own, other) = (&mut self.incident, &open.incident);
        let mut cylinders = own.scope.cylinders();
        cylinders.insert(index);
        own.scope = Scope::Machine(cylinders);
        own.begin = own.begin.min(other.begin);
        own.onset = own.onset.min(other.onset);
        own.level = own.level.max(other.level);
        self.newest = self.newest.max(open.newest);
        for (own, other) in own.parts.iter_mut().zip(&other.parts) {
            if let Some(other) = other {
                join(own, other);
            }
        }
        for i in 0..QUANTITIES {
            let share = |it: &Incident| it.peaks[i].map(|peak| peak.value.abs() / it.limits[i]);
            if share(other) > share(own) {
                (own.peaks[i], own.limits[i]) = (other.peaks[i], other.limits[i]);
            }
        }
    }

    /// Notes that a member is over.
    pub fn release(&mut self, ending: Ending) {
        let certainty = |ending: Ending| match ending {
            Ending::Returned => 0,
            Ending::Quiet => 1,
            Ending::Cut | Ending::Joined => 2,
        };
        self.ending = match self.ending {
            Some(known) if certainty(known) >= certainty(ending) => Some(known),
            _ => Some(ending),
        };
    }

    /// The incident as it is reported at `at`, if it says something new.
    pub fn news(&mut self, cause: Cause, at: Timestamp) -> Option<&Incident> {
        let own = &mut self.incident;
        own.fault = if cause == Cause::Supply { Fault::Supply } else { fault(own) };
        let has_size = own.parts.iter().flatten().any(|part| part.finding.size().is_some());
        let said = (own.scope.cylinders(), own.fault, has_size, own.level);
        let before = self.reported.replace(said);
        if before == Some(said) {
            return None;
        }
        own.progress = before.map_or(Progress::Opened, |_| Progress::Revised);
        own.timestamp = at;
        Some(own)
    }

    /// The incident as it is over at `at`.
    pub fn closed(&self, at: Timestamp) -> Incident {
        let end = Some((self.newest, self.ending.unwrap_or(Ending::Quiet)));
        Incident { progress: Progress::Closed, timestamp: at, end, ..self.incident }
    }
}

/// Adds what a detector has found on one cylinder to what it has found on others. It accuses no transducer: what they
/// have in common is none.
fn join(own: &mut Option<Part>, other: &Part) {
    let joined = own.get_or_insert(Part { stands: false, ..*other });
    joined.raised = joined.raised.min(other.raised);
    joined.raises = joined.raises.max(other.raises);
    joined.stands |= other.stands;
    let (known, new) = (&mut joined.finding, &other.finding);
    if known.fault == Fault::Unclassified {
        known.fault = new.fault;
    }
    if known.fault == new.fault {
        known.evidence = new.evidence.or(known.evidence);
    }
    known.level = known.level.max(new.level);
    known.suspect = Suspect::Process;
}

/// The kind: that of a fact about readings or commands, else of what was raised first.
fn fault(incident: &Incident) -> Fault {
    const FACTS: [WarningPlace; 3] = [
        WarningPlace::PlausibilityOfC1,
        WarningPlace::PlausibilityOfC2,
        WarningPlace::PlausibilityOfCommand,
    ];
    let facts = FACTS.into_iter().filter_map(|place| incident.part(place)).next();
    let named = |part: &&Part| part.finding.fault != Fault::Unclassified;
    let first = || incident.parts.iter().flatten().filter(named).min_by_key(|part| part.raised);
    facts.or_else(first).map_or(Fault::Unclassified, |part| part.finding.fault)
}
