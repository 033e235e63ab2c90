//! What the detectors say together.
//!
//! Facts about a reading come first, then the evidence of many samples, then the difference, then spool and pressures, then the
//! observers in the order in which they were raised. A detector that has not decided says nothing here.

use super::{Incident, IncidentParameters, Naming, Part};
use crate::alarm::detector::WarningPlace;
use crate::blame::Rule;
use crate::time::Timestamp;
use crate::verdict::{Fault, Suspect};

/// Places of facts about a reading.
const FACTS: [WarningPlace; 3] = [
    WarningPlace::PlausibilityOfC1,
    WarningPlace::PlausibilityOfC2,
    WarningPlace::PlausibilityOfCommand,
];

/// Places that follow on facts and precede the observers where the suspect is named.
const BEFORE_OBSERVERS: [WarningPlace; 3] =
    [WarningPlace::Sequential, WarningPlace::Fde3, WarningPlace::Process];

/// The detectors of R1 and R2, which are the first two quantities.
pub(super) const OBSERVERS: [WarningPlace; 2] = [WarningPlace::Fde1, WarningPlace::Fde2];

const P: &IncidentParameters = &IncidentParameters::DEFAULT;

impl Incident {
    /// Sums up the parts after a warning at `at`: suspect, kind, size and onset.
    pub(super) fn fuse(&mut self, at: Timestamp) {
        self.name(self.naming_part().map_or(Suspect::Undecided, |(_, suspect)| suspect), at);
        let weighed = self.part(WarningPlace::Sequential).map(|part| part.finding);
        let evidence = weighed.and_then(|finding| finding.evidence);
        self.gain = evidence.and_then(|evidence| evidence.gain);
        self.onset = evidence.map_or(self.begin, |evidence| evidence.onset.min(self.begin));
        self.fault = self.fused_fault();
        let size = weighed.and_then(|finding| finding.residual);
        // The observer sees a step in its first sample, the deck's attitude only as a mean that is on its way.
        self.size =
            if self.is_alone() { self.step().or(size) } else { size.or_else(|| self.step()) };
    }

    /// Takes the cycle of its newest warning, in which R3 was `difference`: by how much the readings have parted.
    pub(super) fn part_by(&mut self, difference: Option<f64>, at: Timestamp) {
        let is_first = self.part(WarningPlace::Fde3).is_some_and(|part| part.raised == at);
        if is_first && self.parted.is_none() {
            self.parted = difference;
            self.fuse(at);
        }
    }

    fn name(&mut self, suspect: Suspect, at: Timestamp) {
        if suspect != self.suspect {
            let named = Naming { at, by_its_end: false };
            (self.suspect, self.named) =
                (suspect, Some(named).filter(|_| suspect != Suspect::Undecided));
        }
    }

    /// The observers, that which was raised first before the other.
    fn observers(&self) -> [WarningPlace; 2] {
        let [first, second] = OBSERVERS;
        let raised = |place: WarningPlace| self.part(place).map(|part| part.raised);
        let swapped = raised(first).zip(raised(second)).is_some_and(|(a, b)| a > b);
        if swapped { [second, first] } else { [first, second] }
    }

    /// The detector that named the suspect; `None` while it is undecided.
    pub fn namer(&self) -> Option<WarningPlace> {
        self.naming_part().map(|(place, _)| place)
    }

    /// The rule by which that detector has named it; `None` while it is undecided.
    pub fn rule(&self) -> Option<Rule> {
        self.part(self.namer()?).map(|part| part.finding.rule)
    }

    /// The detector that is listened to, and whom it suspects; `None` while none has decided.
    fn naming_part(&self) -> Option<(WarningPlace, Suspect)> {
        let places = FACTS.into_iter().chain(BEFORE_OBSERVERS).chain(self.observers());
        let mut suspects =
            places.filter_map(|place| Some((place, self.part(place)?.finding.suspect)));
        suspects.find(|(_, suspect)| *suspect != Suspect::Undecided)
    }

    fn fused_fault(&self) -> Fault {
        if self.gain.is_some() {
            return Fault::Unclassified;
        }
        if let Some(fact) = FACTS.iter().find_map(|place| self.part(*place)) {
            return fact.finding.fault;
        }
        let own = match self.suspect {
            Suspect::C1 => self.part(WarningPlace::Fde1),
            Suspect::C2 => self.part(WarningPlace::Fde2),
            Suspect::Process => self.part(WarningPlace::Process),
            Suspect::Undecided => None,
        };
        let others = [WarningPlace::Fde3, WarningPlace::Sequential].map(|place| self.part(place));
        let at_onset = |part: &&Part| part.raised.since(self.begin).as_seconds() <= P.onset;
        let named = |part: &&Part| part.finding.fault != Fault::Unclassified;
        let observers = self.observers().map(|place| self.part(place));
        let parts = || [own].into_iter().chain(others).chain(observers).flatten();
        // What is wrong with a cylinder takes as long to tell as it takes.
        if let Some(part) = own.filter(|part| self.suspect == Suspect::Process && named(part)) {
            return part.finding.fault;
        }
        let by_onset = parts().filter(at_onset).find(named);
        by_onset.or_else(|| parts().find(named)).map_or(Fault::Unclassified, |it| it.finding.fault)
    }

    /// Size of a step at its onset: the innovation, or else the difference.
    fn step(&self) -> Option<f64> {
        if self.fault != Fault::Abrupt {
            return None;
        }
        let place = match self.suspect {
            Suspect::C1 => WarningPlace::Fde1,
            Suspect::C2 => WarningPlace::Fde2,
            Suspect::Undecided | Suspect::Process => WarningPlace::Fde3,
        };
        let at_onset = |part: &&Part| part.raised.since(self.begin).as_seconds() <= P.onset;
        let residual = self.part(place).filter(at_onset)?.finding.residual;
        self.parted.filter(|_| place == WarningPlace::Fde3).or(residual)
    }
}
