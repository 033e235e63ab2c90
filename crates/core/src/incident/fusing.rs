//! What the detectors say together.
//!
//! Facts about a reading come first, then the evidence of many samples, then the difference, then spool and pressures,
//! then the observers in the order in which they were raised. A detector that has not decided says nothing here.

use super::{Incident, Part};
use crate::alarm::detector::WarningPlace;
use crate::time::Span;
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

const OBSERVERS: [WarningPlace; 2] = [WarningPlace::Fde1, WarningPlace::Fde2];

/// Time after the begin within which a detector still sees the onset. What is raised later sees the
/// fault's course or its end, and does not name its kind.
const ONSET: Span = Span::from_nanos(500_000_000);

impl Incident {
    /// Sums up the parts: suspect, kind, size and onset.
    pub(super) fn fuse(&mut self) {
        self.suspect = self.fused_suspect();
        let sequential = self.part(WarningPlace::Sequential).map(|part| part.finding);
        let evidence = sequential.and_then(|finding| finding.evidence);
        self.gain = evidence.and_then(|evidence| evidence.gain);
        self.onset = evidence.map_or(self.begin, |evidence| evidence.onset.min(self.begin));
        self.fault = self.fused_fault();
        self.size = sequential.and_then(|finding| finding.residual).or_else(|| self.step());
    }

    fn observers(&self) -> [Option<&Part>; 2] {
        let [mut first, mut second] = OBSERVERS.map(|place| self.part(place));
        let is_later = |a: &Part, b: &Part| a.raised > b.raised;
        if first.zip(second).is_some_and(|(a, b)| is_later(a, b)) {
            core::mem::swap(&mut first, &mut second);
        }
        [first, second]
    }

    fn fused_suspect(&self) -> Suspect {
        let before = FACTS.into_iter().chain(BEFORE_OBSERVERS).map(|place| self.part(place));
        let parts = before.chain(self.observers()).flatten();
        let mut suspects = parts.map(|part| part.finding.suspect);
        suspects.find(|suspect| *suspect != Suspect::Undecided).unwrap_or_default()
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
        let at_onset = |part: &&Part| part.raised.since(self.begin) <= ONSET;
        let named = |part: &&Part| part.finding.fault != Fault::Unclassified;
        let parts = || [own].into_iter().chain(others).chain(self.observers()).flatten();
        // What is wrong with a cylinder takes as long to tell as it takes.
        if let Some(part) = own.filter(|part| self.suspect == Suspect::Process && named(part)) {
            return part.finding.fault;
        }
        let by_onset = parts().filter(at_onset).find(named);
        by_onset.or_else(|| parts().find(named)).map_or(Fault::Unclassified, |it| it.finding.fault)
    }

    /// Size of a step: the innovation as it was raised, or else the difference.
    fn step(&self) -> Option<f64> {
        if self.fault != Fault::Abrupt {
            return None;
        }
        let place = match self.suspect {
            Suspect::C1 => WarningPlace::Fde1,
            Suspect::C2 => WarningPlace::Fde2,
            Suspect::Undecided | Suspect::Process => WarningPlace::Fde3,
        };
        let at_onset = |part: &&Part| part.raised.since(self.begin) <= ONSET;
        self.part(place).filter(at_onset)?.finding.residual
    }
}
