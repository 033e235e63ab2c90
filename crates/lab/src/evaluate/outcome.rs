//! What became of one fault.

use serde::Serialize;
use tertius_core::alarm::detector::{PLACES, WarningPlace};
use tertius_core::alarm::{Detector, Finding, State, Warning};
use tertius_core::incident::{Incident, Progress};
use tertius_core::time::Timestamp;
use tertius_core::verdict::{Fault, Suspect};

/// Number of detectors.
pub const DETECTORS: usize = Detector::ALL.len();

/// Places of the detectors that warn of bad data of C1 and of C2.
const DATA: [usize; 2] =
    [WarningPlace::PlausibilityOfC1 as usize, WarningPlace::PlausibilityOfC2 as usize];

/// The first warning after the onset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct First {
    pub suspect: Suspect,
    pub fault: Fault,
}

/// Whom the warnings blame, compared with the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Blame {
    Right,
    Undecided,
    Process,
    /// The other transducer is blamed.
    Wrong,
}

impl Blame {
    fn new(suspect: Suspect, faulty: Suspect) -> Self {
        match suspect {
            Suspect::Undecided => Self::Undecided,
            Suspect::Process => Self::Process,
            suspect if suspect == faulty => Self::Right,
            _ => Self::Wrong,
        }
    }
}

/// What the incidents of the faulty cylinder say: one fault is one incident.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IncidentOutcome {
    /// Number of incidents that began while the fault was watched.
    pub count: u32,
    /// Whom the first of them blames in the end.
    pub blame: Option<Blame>,
    /// How the first of them names the fault in the end.
    pub kind: Option<Fault>,
}

impl IncidentOutcome {
    /// What `incidents`, in the order of their reports, say until `end` of a fault of `transducer` of
    /// `cylinder` (from 1) that began at `onset`.
    pub fn read(
        incidents: &[Incident],
        cylinder: u8,
        transducer: Suspect,
        onset: Timestamp,
        end: Timestamp,
    ) -> Self {
        let of = |it: &&Incident| {
            it.scope.has(cylinder.into()) && it.begin >= onset && it.timestamp <= end
        };
        let count = incidents.iter().filter(of).filter(|it| it.progress == Progress::Opened);
        let count = count.count() as u32;
        let first = incidents.iter().find(of).map(|it| it.number);
        let newest = incidents.iter().filter(of).rfind(|it| Some(it.number) == first);
        Self {
            count,
            blame: newest.map(|it| Blame::new(it.suspect, transducer)),
            kind: newest.map(|it| it.fault),
        }
    }
}

/// What the monitor reported of one fault.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// The faulty transducer, C1 or C2.
    pub transducer: Suspect,
    /// A warning of the cylinder already stood when the fault began, so later ones mean nothing.
    pub spoilt: bool,
    /// Warnings of the cylinder before the fault.
    pub early: u32,
    /// From the sampling of the first faulty reading to the raise of each detector, in the order of
    /// [`Detector::ALL`], s.
    pub delays: [Option<f64>; DETECTORS],
    pub first: Option<First>,
    /// Name of the fault in the end: that of a warning of bad data, which no model judges, or else
    /// that of the first warning.
    pub kind: Option<Fault>,
    /// Blame of all warnings in the end: an innocent one takes precedence over the right one, and
    /// that over nobody.
    pub blame: Option<Blame>,
    /// The incidents that were told of the fault.
    pub incidents: IncidentOutcome,
    /// Warnings of cylinders without a fault, after the onset.
    pub beside: u32,
    /// Largest |R1|, |R2|, |R3| while it was watched, m.
    pub worst: [f64; 3],
    /// Largest distance of the rod from where it would be without the fault, m; known where the
    /// machine has a healthy twin.
    pub rod: Option<f64>,
    /// Difference of C1's reading from what it would be without the fault, RMS over the last
    /// second, m.
    pub reading: Option<f64>,
}

impl Outcome {
    /// Delay of the first detector, s.
    pub fn delay(&self) -> Option<f64> {
        self.delays.iter().flatten().copied().reduce(f64::min)
    }

    /// The delay of the observer on the faulty transducer, s.
    pub fn own(&self) -> Option<f64> {
        self.delays[usize::from(self.transducer == Suspect::C2)]
    }

    /// What the `warnings` of a whole run say of a fault of `transducer` of `cylinder` (from 1)
    /// whose first reading is at `onset` and which is watched until `end`.
    pub fn read(
        warnings: &[Warning],
        cylinder: u8,
        transducer: Suspect,
        onset: Timestamp,
        end: Timestamp,
    ) -> Self {
        let mut outcome = Self::nothing(transducer);
        let mut standing = [false; PLACES];
        let mut newest: [Option<Finding>; PLACES] = [None; PLACES];
        let mut first_place = None;
        for warning in warnings.iter().filter(|warning| warning.timestamp <= end) {
            let raised = warning.state == State::Raised;
            if warning.cylinder != cylinder {
                outcome.beside += u32::from(raised && warning.timestamp >= onset);
                continue;
            }
            if warning.timestamp < onset {
                standing[warning.place] = warning.state != State::Cleared;
                outcome.early += u32::from(raised);
                continue;
            }
            if warning.state == State::Cleared {
                continue;
            }
            newest[warning.place] = Some(warning.finding);
            if raised {
                let delay = warning.timestamp.since(onset).as_seconds();
                outcome.delays[warning.detector as usize - 1].get_or_insert(delay);
                let Finding { suspect, fault, .. } = warning.finding;
                outcome.first.get_or_insert(First { suspect, fault });
                first_place.get_or_insert(warning.place);
            }
        }
        outcome.spoilt = standing.contains(&true);
        let implausible = DATA[usize::from(transducer == Suspect::C2)];
        let by_model = || first_place.and_then(|place: usize| newest[place]);
        outcome.kind = newest[implausible].or_else(by_model).map(|it| it.fault);
        outcome.blame = blame(newest.iter().flatten(), transducer);
        outcome
    }

    /// Whom the first warning blamed.
    pub fn first_blame(&self) -> Option<Blame> {
        self.first.map(|first| Blame::new(first.suspect, self.transducer))
    }

    const fn nothing(transducer: Suspect) -> Self {
        Self {
            transducer,
            spoilt: false,
            early: 0,
            delays: [None; DETECTORS],
            first: None,
            kind: None,
            blame: None,
            incidents: IncidentOutcome { count: 0, blame: None, kind: None },
            beside: 0,
            worst: [0.0; 3],
            rod: None,
            reading: None,
        }
    }
}

fn blame<'a>(findings: impl Iterator<Item = &'a Finding>, faulty: Suspect) -> Option<Blame> {
    let weight = |blame: &Blame| match blame {
        Blame::Undecided => 0,
        Blame::Right => 1,
        Blame::Process => 2,
        Blame::Wrong => 3,
    };
    findings.map(|finding| Blame::new(finding.suspect, faulty)).max_by_key(weight)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tertius_core::alarm::Level;
    use tertius_core::alarm::register;
    use tertius_core::blame::Rule;

    fn warning(at: i64, place: usize, state: State, suspect: Suspect) -> Warning {
        let finding = Finding {
            fault: Fault::Abrupt,
            suspect,
            rule: Rule::OneObserver,
            level: Level::Yellow,
            residual: None,
            threshold: None,
            evidence: None,
            device: None,
        };
        Warning {
            timestamp: Timestamp::from_nanos(at),
            cylinder: 2,
            detector: register::DETECTORS[place],
            place,
            state,
            finding,
        }
    }

    fn read(warnings: &[Warning]) -> Outcome {
        let at = Timestamp::from_nanos;
        Outcome::read(warnings, 2, Suspect::C2, at(1_000_000_000), at(11_000_000_000))
    }

    #[test]
    fn delays_count_from_the_onset_and_the_first_raise_counts() {
        let outcome = read(&[
            warning(1_020_000_000, 1, State::Raised, Suspect::Undecided),
            warning(1_060_000_000, 1, State::Changed, Suspect::C2),
            warning(3_000_000_000, 1, State::Cleared, Suspect::C2),
            warning(4_000_000_000, 1, State::Raised, Suspect::C2),
            warning(1_500_000_000, 2, State::Raised, Suspect::Undecided),
            warning(12_000_000_000, 0, State::Raised, Suspect::C1),
        ]);
        assert_eq!(outcome.delays[..3], [None, Some(0.02), Some(0.5)]);
        assert_eq!((outcome.delay(), outcome.own()), (Some(0.02), Some(0.02)));
        assert_eq!(outcome.first_blame(), Some(Blame::Undecided));
        assert_eq!((outcome.blame, outcome.kind), (Some(Blame::Right), Some(Fault::Abrupt)));
        assert!(!outcome.spoilt);
    }

    #[test]
    fn what_stood_before_spoils_and_what_was_over_does_not() {
        let raised = warning(10, 0, State::Raised, Suspect::C1);
        let cleared = warning(20, 0, State::Cleared, Suspect::C1);
        assert!(read(&[raised]).spoilt);
        let over = read(&[raised, cleared]);
        assert_eq!((over.spoilt, over.early, over.delay()), (false, 1, None));
    }

    #[test]
    fn one_who_blames_the_innocent_outweighs_those_who_are_right() {
        let both = [
            warning(1_020_000_000, 1, State::Raised, Suspect::C2),
            warning(1_040_000_000, 0, State::Raised, Suspect::C1),
        ];
        assert_eq!(read(&both).blame, Some(Blame::Wrong));
        assert_eq!(read(&both[..1]).blame, Some(Blame::Right));
        assert_eq!(read(&[]).blame, None);
    }

    #[test]
    fn who_says_that_the_data_are_bad_names_the_fault() {
        let frozen = |place| {
            let said = warning(1_120_000_000, place, State::Raised, Suspect::C2);
            Warning { finding: Finding { fault: Fault::Frozen, ..said.finding }, ..said }
        };
        let abrupt = warning(1_020_000_000, 1, State::Raised, Suspect::C2);
        assert_eq!(read(&[abrupt, frozen(4)]).kind, Some(Fault::Frozen));
        assert_eq!(read(&[abrupt, frozen(3)]).kind, Some(Fault::Abrupt), "C1 is not C2");
        assert_eq!((DATA[0], register::DETECTORS[DATA[0]]), (3, Detector::Plausibility));
    }

    #[test]
    fn other_cylinders_are_beside() {
        let other =
            Warning { cylinder: 3, ..warning(1_020_000_000, 1, State::Raised, Suspect::C1) };
        let outcome = read(&[other]);
        assert_eq!((outcome.beside, outcome.delay(), outcome.blame), (1, None, None));
    }
}
