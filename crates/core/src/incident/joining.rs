//! Which warnings have one cause.
//!
//! Of one cylinder, warnings belong together that do not contradict each other about whom to
//! suspect and between which the fault is not known to have gone, and those of one moment: a fault of
//! one transducer reaches the other observer through the machine's controller. A fault of the
//! hydraulics, a command that does not come and readings that have parted are never one incident.

use super::cause::Cause;
use super::news::Reported;
use super::{Ending, EventTiming, Incident, IncidentParameters, Progress, Quantities, Quantity};
use crate::alarm::detector::{Basis, DETECTORS, WarningPlace};
use crate::alarm::{Detector, Finding, Warning};
use crate::blame::Rule;
use crate::state::whole;
use crate::time::{Span, Timestamp};
use crate::verdict::{Fault, LONGEST_WAIT, Suspect};

/// Cycles whose R3 is kept: those in which a residual is beyond its threshold before that is a fault, and the one before.
const KEPT_DIFFERENCES: usize = LONGEST_WAIT + 1;

const P: &IncidentParameters = &IncidentParameters::DEFAULT;

/// Places of detectors that see C1 and C2 part.
const PARTING: [WarningPlace; 2] = [WarningPlace::Fde3, WarningPlace::Sequential];

/// An incident that is not closed, and what decides whether a warning belongs to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Open {
    pub incident: Incident,
    /// Its place in the order in which incidents begin, over all cylinders.
    pub order: u32,
    /// Why it is a part of an incident of the machine, if it is.
    pub shared: Option<Cause>,
    /// Time of the newest raise or clearing.
    pub newest: Timestamp,
    /// Whether C1 − C2 grew at its begin, where that is known.
    grew: Option<bool>,
    /// R3 in the newest cycles, m, the newest first.
    differences: [Option<f64>; KEPT_DIFFERENCES],
    /// Whether the fault was seen to go.
    pub has_returned: bool,
    /// What was reported of it.
    pub reported: Option<Reported>,
}

whole! { Open { incident, order, shared, newest, grew, differences, has_returned, reported } }

impl Open {
    pub fn new(order: u32, incident: Incident) -> Self {
        Self {
            newest: incident.begin,
            incident,
            order,
            shared: None,
            grew: None,
            differences: [None; KEPT_DIFFERENCES],
            has_returned: false,
            reported: None,
        }
    }

    /// Time at which it is over, if no warning stands and none belongs to it until then.
    pub fn due(&self, timing: &EventTiming) -> Timestamp {
        let come_again = || Span::from_seconds(P.come_again);
        self.newest.after(if self.can_hide() { timing.shown_again() } else { come_again() })
    }

    /// Whether the fault may still be there, although nothing exceeds a threshold: unless it was seen to go, or
    /// is noise of a transducer, which leaves no offset behind.
    fn can_hide(&self) -> bool {
        let Incident { fault, suspect, .. } = self.incident;
        !self.has_returned && (fault != Fault::Noise || suspect == Suspect::Process)
    }

    /// Whether a warning that is raised belongs to it.
    pub fn takes(&self, warning: &Warning, timing: &EventTiming) -> bool {
        if !self.incident.stands() && warning.timestamp >= self.due(timing) {
            return false;
        }
        if self.is_of_another_kind(warning) || self.is_left_by(warning) {
            return false;
        }
        let (named, suspect) = (warning.finding.suspect, self.incident.suspect);
        if named == suspect || named == Suspect::Undecided {
            return true;
        }
        if suspect == Suspect::Undecided {
            return self.is_decided_by(warning, timing);
        }
        let at_once = warning.timestamp.since(self.newest) <= timing.coincidence;
        at_once && !(is_fact(warning) && self.has_facts())
    }

    /// Whether a warning is about the last transducer, and the incident about the other one, which is out. C1 was lost, and C2
    /// stepped 30 s later: FDE2 was undecided until the step had lasted, and C2's fault stayed a part of C1's incident.
    pub fn is_left_by(&self, warning: &Warning) -> bool {
        let Finding { suspect, rule, .. } = warning.finding;
        let is_of_last = matches!(rule, Rule::LastTransducer | Rule::DeadReckoning);
        let is_of_other = matches!(self.incident.suspect, Suspect::C1 | Suspect::C2);
        is_of_last && is_of_other && suspect != self.incident.suspect
    }

    /// Whether one of them is of the hydraulics, of a command that does not come or of a reading that has parted, and the
    /// other of another one of the three: no valve, pump or seal, and no missing command, makes C1 and C2 differ, no
    /// reading makes oil, and what is wrong with the oil outlives the command's return.
    fn is_of_another_kind(&self, warning: &Warning) -> bool {
        let has = |place: WarningPlace| self.incident.part(place).is_some();
        let names = |suspect: Suspect| matches!(suspect, Suspect::C1 | Suspect::C2);
        let (of_oil, of_command) =
            (has(WarningPlace::Process), has(WarningPlace::PlausibilityOfCommand));
        match warning.detector {
            Detector::Process => of_command || PARTING.into_iter().any(has),
            Detector::Plausibility if is_of_command(warning) => {
                of_oil || PARTING.into_iter().any(has) || names(self.incident.suspect)
            }
            Detector::Plausibility => of_command,
            Detector::Fde3 | Detector::Sequential => of_oil || of_command,
            Detector::Fde1 | Detector::Fde2 => names(warning.finding.suspect) && of_command,
        }
    }

    /// What of the `quantities` is its: of hydraulics or command not that the machine itself would trip, because the
    /// readings that differ so far are another fault's.
    pub fn own(&self, quantities: &Quantities) -> Quantities {
        let has = |place: WarningPlace| self.incident.part(place).is_some();
        let mut own = *quantities;
        if has(WarningPlace::Process) || has(WarningPlace::PlausibilityOfCommand) {
            own[Quantity::Measured as usize] = None;
        }
        own
    }

    /// Whether a warning that names a suspect is about this fault, whose suspect is open: one near its begin, one that
    /// sees it go, or one that weighs all samples since. Any other sees a new fault beside it.
    fn is_decided_by(&self, warning: &Warning, timing: &EventTiming) -> bool {
        let age = warning.timestamp.since(self.incident.begin);
        match warning.detector.basis() {
            Basis::Readings => age.as_seconds() <= P.fact_within,
            Basis::Residual(0 | 1) => age <= timing.shown_again() || self.sees_it_go(warning),
            Basis::Residual(_) | Basis::Samples => true,
        }
    }

    /// Takes R3 of a cycle, m.
    pub fn take_difference(&mut self, difference: Option<f64>) {
        self.differences.rotate_right(1);
        self.differences[0] = difference;
    }

    /// Whether what an observer sees takes the difference away that was there before; without a difference, whether it is
    /// against the fault's first direction.
    fn sees_it_go(&self, warning: &Warning) -> bool {
        let Some(growth) = growth(warning) else { return false };
        let goes = |before: f64| (before + growth).abs() < P.left * before.abs();
        match self.differences[0] {
            // A drift of minutes that went back at once was another incident: when its observer was raised, after the third
            // sample, the difference had been gone for two cycles.
            Some(_) => self.differences.into_iter().flatten().any(goes),
            None => self.grew.is_some_and(|grew| grew != (growth > 0.0)),
        }
    }

    fn has_facts(&self) -> bool {
        let mut parts = DETECTORS.into_iter().zip(&self.incident.parts);
        parts.any(|(detector, part)| {
            detector.basis() == Basis::Readings && part.is_some_and(|part| part.stands)
        })
    }

    /// Whether it was reported.
    pub const fn is_reported(&self) -> bool {
        self.reported.is_some()
    }

    /// The incident as it is reported at `at`, if there is news.
    pub fn news(&mut self, at: Timestamp) -> Option<&Incident> {
        let now = Reported::of(&self.incident);
        let since = at.since(self.incident.timestamp);
        let progress = now.progress(self.reported.as_ref(), since)?;
        self.reported = Some(now);
        (self.incident.progress, self.incident.timestamp) = (progress, at);
        Some(&self.incident)
    }

    /// How it ended, if no warning stands any more.
    pub const fn ending(&self) -> Ending {
        if self.has_returned { Ending::Returned } else { Ending::Quiet }
    }

    /// The incident as it is over at `at`.
    pub fn closed(&self, at: Timestamp, ending: Ending) -> Incident {
        // One that joins the machine's stands until then. It lasted 0 ms in every report, since nothing had changed meanwhile.
        let end = Some((if ending == Ending::Joined { at } else { self.newest }, ending));
        Incident { progress: Progress::Closed, timestamp: at, end, ..self.incident }
    }

    /// Notes a warning that was raised: whether the fault goes or comes again.
    pub fn follow(&mut self, warning: &Warning, coincidence: Span) {
        self.newest = warning.timestamp;
        let Some(growth) = growth(warning) else { return };
        self.grew.get_or_insert(growth > 0.0);
        let at_onset = warning.timestamp.since(self.incident.begin) <= coincidence;
        let by_observer = matches!(warning.detector.basis(), Basis::Residual(0 | 1));
        // Noise comes and goes in every cycle.
        if !by_observer || at_onset || self.incident.fault == Fault::Noise {
            return;
        }
        if self.sees_it_go(warning) {
            self.has_returned = true;
        } else if self.is_own(warning) {
            self.has_returned = false;
        }
    }

    /// Whether an observer is that of the suspect. The other one only sees what the machine's controller makes of
    /// a fault.
    fn is_own(&self, warning: &Warning) -> bool {
        match self.incident.suspect {
            Suspect::C1 => warning.detector == Detector::Fde1,
            Suspect::C2 => warning.detector == Detector::Fde2,
            Suspect::Undecided | Suspect::Process => true,
        }
    }

    /// Notes a warning that has cleared.
    pub fn clear(&mut self, warning: &Warning) {
        self.newest = warning.timestamp;
        self.has_returned |= is_fact(warning);
    }
}

fn is_of_command(warning: &Warning) -> bool {
    warning.place == WarningPlace::PlausibilityOfCommand as usize
}

fn is_fact(warning: &Warning) -> bool {
    warning.detector.basis() == Basis::Readings
}

/// By how much C1 − C2 grows by what a residual shows, m; `None` for a detector that shows none.
fn growth(warning: &Warning) -> Option<f64> {
    let residual = warning.finding.residual.filter(|residual| *residual != 0.0)?;
    match warning.detector.basis() {
        Basis::Residual(1) => Some(-residual),
        Basis::Residual(_) => Some(residual),
        Basis::Readings | Basis::Samples => None,
    }
}
