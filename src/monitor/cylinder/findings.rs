//! What the detectors of a cylinder find, and what that makes of its transducers.

use super::{Cylinder, Implausible, TRANSDUCERS};
use crate::alarm::register::PLACES;
use crate::alarm::status::Health;
use crate::alarm::{Evidence, Finding, Level};
use crate::verdict::{Fault, Suspect, Verdict, bank::Detection};

impl Cylinder {
    /// Whether any detector finds anything now.
    #[inline]
    pub fn finds_anything(&self) -> bool {
        self.bank.any_found()
            || self.implausible.iter().any(Implausible::raised)
            || self.sequential.as_ref().is_some_and(|sequential| sequential.alarm().is_some())
    }

    /// What the detectors find now, in the places of the [`crate::alarm::Register`].
    pub fn findings(&self) -> [Option<Finding>; PLACES] {
        let [fde1, fde2, fde3] = self.bank.detections();
        let levels = &self.design.levels;
        let mut findings = [
            fde1.map(|detection| self.observer_finding(self.agreed(0, detection))),
            fde2.map(|detection| self.observer_finding(self.agreed(1, detection))),
            fde3.map(|detection| self.difference_finding(detection)),
            self.implausible_finding(0, Suspect::C1),
            self.implausible_finding(1, Suspect::C2),
            self.implausible_finding(2, Suspect::Process),
            self.sequential_finding(),
        ];
        let blames = |suspect| findings.iter().flatten().any(|f: &Finding| f.suspect == suspect);
        if blames(Suspect::C1) && blames(Suspect::C2) {
            for finding in findings.iter_mut().flatten() {
                if matches!(finding.suspect, Suspect::C1 | Suspect::C2) {
                    finding.level = finding.level.max(levels.both);
                }
            }
        }
        findings
    }

    /// The observer's detection, less the blame where the readings agree.
    const fn agreed(&self, i: usize, detection: Detection) -> Detection {
        if self.agreement.is_process(i) {
            return Detection { suspect: Suspect::Process, ..detection };
        }
        detection
    }

    fn observer_finding(&self, detection: Detection) -> Finding {
        finding(detection, self.level(detection.suspect), detection.threshold)
    }

    const fn level(&self, suspect: Suspect) -> Level {
        let levels = &self.design.levels;
        match suspect {
            Suspect::C1 | Suspect::C2 => levels.located,
            Suspect::Process => levels.process,
            Suspect::Undecided => levels.undecided,
        }
    }

    fn sequential_finding(&self) -> Option<Finding> {
        let alarm = self.sequential.as_ref()?.alarm()?;
        Some(Finding {
            fault: if alarm.scale.is_some() { Fault::Unclassified } else { alarm.fault },
            suspect: alarm.suspect,
            level: self.level(alarm.suspect),
            residual: Some(alarm.size),
            threshold: None,
            evidence: Some(Evidence {
                fault: alarm.peak.nats,
                location: alarm.evidence,
                onset: alarm.onset,
                gain: alarm.scale.map(|scale| scale.gain),
            }),
        })
    }

    fn difference_finding(&self, detection: Detection) -> Finding {
        if self.was_critical {
            return finding(detection, self.design.levels.critical, self.design.critical);
        }
        self.observer_finding(detection)
    }

    fn implausible_finding(&self, i: usize, suspect: Suspect) -> Option<Finding> {
        let implausible = self.implausible.get(i).filter(|implausible| implausible.raised())?;
        let frozen =
            |i: usize| self.implausible[i].raised() && self.implausible[i].fault == Fault::Frozen;
        // Two transducers do not freeze at once: it is the cylinder that does not follow.
        let suspect = if i < 2 && frozen(0) && frozen(1) { Suspect::Process } else { suspect };
        let out_of_range = implausible.fault == Fault::OutOfRange;
        Some(Finding {
            fault: implausible.fault,
            suspect,
            level: self.design.levels.implausible,
            residual: out_of_range.then_some(implausible.beyond),
            threshold: out_of_range.then_some(0.0),
            evidence: None,
        })
    }

    /// The state of each transducer, given the `findings` that stand for this cylinder.
    pub fn health(&self, findings: &[Option<Finding>; PLACES]) -> [Health; 2] {
        let stands = |suspect| findings.iter().flatten().any(|finding| finding.suspect == suspect);
        let verdicts = self.bank.verdicts();
        std::array::from_fn(|i| {
            let blamed = [Suspect::C1, Suspect::C2][i];
            if !self.has(TRANSDUCERS[i]) {
                Health::Unknown
            } else if stands(blamed) {
                Health::Faulty
            } else if stands(Suspect::Undecided) {
                Health::Suspect
            } else if self.judged[i] && verdicts[i] == Verdict::Healthy && !stands(Suspect::Process)
            {
                Health::Healthy
            } else {
                Health::Unknown
            }
        })
    }
}

fn finding(detection: Detection, level: Level, threshold: f64) -> Finding {
    Finding {
        fault: detection.fault,
        suspect: detection.suspect,
        level,
        residual: Some(detection.residual),
        threshold: Some(threshold),
        evidence: None,
    }
}
