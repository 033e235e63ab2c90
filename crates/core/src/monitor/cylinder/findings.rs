//! Findings of the detectors of a cylinder, and the resulting states of its transducers.

use super::Cylinder;
use super::last::{Latch, SharedDeparture};
use crate::alarm::detector::{PLACES, WarningPlace};
use crate::alarm::status::Health;
use crate::alarm::{Evidence, Finding, Level};
use crate::blame::{Accuser, Blamed, Case, Facts, Rule, blame, suspect_of};
use crate::process::Malfunction;
use crate::sample::{Quality, Transducer};
use crate::sequential::{Alarm, Sequential};
use crate::time::Timestamp;
use crate::verdict::{Fault, Suspect, Testimony, Verdict, bank::Detection};

/// The findings of the detectors of a difference that stands. An observer alone is raised for a second by noise, too: while
/// coarse readings drifted apart, that made the one that had drifted by 150 mm the one to rely on.
pub(super) fn standing(found: &[Option<Finding>; PLACES]) -> impl Iterator<Item = &Finding> {
    let places = [WarningPlace::Fde3, WarningPlace::Sequential];
    places.into_iter().filter_map(|place| found[place as usize].as_ref())
}

impl Cylinder {
    /// Whether any detector has a finding now.
    pub fn finds_anything(&self) -> bool {
        self.detects_anything()
            || self.last.any_latched()
            || self.last.shared.is_some()
            || self.tilted.is_some()
            || self.readings.plausibility.iter().any(|it| it.quality() == Quality::Doubtful)
            || self.readings.any_implausible()
    }

    /// Whether there are any [`Self::findings`]. What the stop finds of the only transducer stands for months, in which
    /// everything else has to supervise that transducer as if nothing were found.
    pub fn has_findings(&self) -> bool {
        self.finds_anything() || self.has_drifted()
    }

    /// Whether any detector beside the plausibility checks and the supervision of the last transducer has a finding now.
    #[inline(always)]
    pub(super) fn detects_anything(&self) -> bool {
        self.fde.bank.any_found()
            || self.trip.beyond().is_some()
            || self.sequential.as_ref().is_some_and(|sequential| sequential.alarm().is_some())
            || self.process.as_ref().is_some_and(|process| process.alarm().is_some())
    }

    /// Present findings of the detectors, in the places of the [`crate::alarm::Register`].
    pub fn findings(&self) -> [Option<Finding>; PLACES] {
        let mut findings = [None; PLACES];
        let mut put = |place: WarningPlace, finding| findings[place as usize] = finding;
        // What both are off by comes after all that names one of them.
        let fde1 = self.observer_finding(Accuser::Fde1).or_else(|| self.shared_finding());
        put(WarningPlace::Fde1, fde1);
        put(WarningPlace::Fde2, self.observer_finding(Accuser::Fde2));
        put(WarningPlace::Fde3, self.difference_finding().map(|it| self.in_time(it)));
        put(WarningPlace::PlausibilityOfC1, self.implausible_finding(0, Suspect::C1));
        put(WarningPlace::PlausibilityOfC2, self.implausible_finding(1, Suspect::C2));
        put(WarningPlace::PlausibilityOfCommand, self.implausible_finding(2, Suspect::Process));
        let tilted = || self.tilted.map(|it| it.finding(self.design.levels.both));
        let sequential = self.sequential_finding().or_else(tilted);
        let sequential = sequential.map(|it| self.in_time(it));
        // What the stop finds of an only transducer stands for months, and comes last.
        let undecided = self.design.levels.undecided;
        let stop = || self.on_stop.as_ref().and_then(|it| it.finding(undecided));
        put(WarningPlace::Sequential, sequential.or_else(stop));
        put(WarningPlace::Process, self.process_finding());
        self.raise_where_both_are_blamed(&mut findings);
        findings
    }

    /// Whether the stop finds anything of the only transducer.
    #[inline]
    pub(super) fn has_drifted(&self) -> bool {
        self.on_stop.as_ref().is_some_and(|it| it.has_drifted())
    }

    /// Whether a transducer is under suspicion, and whether the readings have parted that are both plausible.
    #[inline]
    pub(super) fn doubts(&self) -> (bool, bool) {
        let difference = self.fde.bank.any_found() && self.fde.bank.difference_age().is_some();
        let (sequential, is_implausible) = (
            self.sequential.as_deref(),
            Transducer::ALL.into_iter().any(|t| self.readings.is_implausible(t as usize)),
        );
        let is_doubted =
            difference || is_implausible || sequential.is_some_and(|it| it.alarm().is_some());
        (is_doubted, !is_implausible && sequential.is_some_and(Sequential::is_displaced))
    }

    /// What blames either transducer has the level of both, where each is blamed by something, or does not exist.
    fn raise_where_both_are_blamed(&self, findings: &mut [Option<Finding>; PLACES]) {
        let is_blamed = |transducer: Transducer| {
            let own = [WarningPlace::Fde1, WarningPlace::Fde2][transducer as usize] as usize;
            // A single sample of the last one is not yet the loss of both.
            let counts = |place| place != own || !self.last.is_tentative(transducer as usize);
            let mut each =
                findings.iter().enumerate().filter_map(|(k, it)| Some((k, it.as_ref()?)));
            let suspect = suspect_of(transducer);
            !self.has(transducer) || each.any(|(k, it)| counts(k) && it.suspect == suspect)
        };
        if Transducer::ALL.into_iter().all(is_blamed) {
            for finding in findings.iter_mut().flatten() {
                if matches!(finding.suspect, Suspect::C1 | Suspect::C2) {
                    finding.level = finding.level.max(self.design.levels.both);
                }
            }
        }
    }

    /// What a detector proposes that has found something, see [`crate::blame`].
    pub(super) fn proposal(&self, accuser: Accuser) -> Option<Blamed> {
        match accuser {
            Accuser::Fde1 | Accuser::Fde2 | Accuser::Fde3 => {
                self.blame.pattern.proposal(accuser).or_else(|| {
                    let own = accuser.observed().filter(|it| self.last.is_latched(*it as usize));
                    own.map(|own| Blamed::new(suspect_of(own), Rule::LastTransducer))
                })
            }
            Accuser::Sequential => self.sequential.as_deref()?.alarm().map(proposal_of_samples),
        }
    }

    /// Names the suspect of the finding of `accuser`, if it has one. Calls `asked` with the answer of each rule, up to the one
    /// that decides.
    pub fn blame(
        &self,
        accuser: Accuser,
        asked: impl FnMut(Rule, Option<Suspect>),
    ) -> Option<Blamed> {
        let proposal = self.proposal(accuser)?;
        let alarm = self.sequential.as_deref().and_then(Sequential::alarm);
        let facts = Facts {
            is_last: [0, 1].map(|i| self.last.names(i)),
            is_latched: [0, 1].map(|i| self.last.is_latched(i)),
            departs: [0, 1].map(|i| self.last.departs(i)),
            memory: &self.blame,
            by_the_rod: alarm.and_then(seen_of_the_rod),
            is_process_found: self.process.as_ref().is_some_and(|it| it.alarm().is_some()),
            is_apart: self.fde.bank.verdicts()[2] == Verdict::Faulty || alarm.is_some(),
        };
        Some(blame(&Case { accuser, proposal, facts: &facts }, asked))
    }

    pub(super) fn found(&self, detection: Detection, blamed: Blamed) -> Finding {
        Finding {
            fault: detection.fault,
            suspect: blamed.suspect,
            rule: blamed.rule,
            level: self.level(blamed.suspect),
            residual: Some(detection.residual),
            threshold: Some(detection.threshold),
            evidence: None,
            device: None,
        }
    }

    const fn level(&self, suspect: Suspect) -> Level {
        let levels = &self.design.levels;
        match suspect {
            Suspect::C1 | Suspect::C2 => levels.located,
            Suspect::Process => levels.process,
            Suspect::Undecided => levels.undecided,
        }
    }

    /// The finding of an observer, or what is latched of its transducer.
    pub(super) fn observer_finding(&self, accuser: Accuser) -> Option<Finding> {
        let i = accuser.observed()? as usize;
        let blamed = self.blame(accuser, |_, _| {})?;
        let found = self.fde.bank.detections()[i];
        let Some(latch) = self.last.latch(i) else {
            return found.map(|found| self.found(found, blamed));
        };
        let Latch { fault, residual, threshold, departs, .. } = latch;
        let latched = Detection { fault, residual, threshold };
        let found = found.filter(|_| departs.is_none()).unwrap_or(latched);
        let evidence = departs.map(|onset| self.departure_evidence([residual, threshold], onset));
        let level = self.design.levels.both;
        Some(Finding { level, evidence, ..self.found(found, blamed) })
    }

    /// The finding of both transducers, which depart alike.
    fn shared_finding(&self) -> Option<Finding> {
        let SharedDeparture { off: residual, limit: threshold, since, is_jump } =
            self.last.shared?;
        let (fault, rule) = match is_jump {
            true => (Fault::Abrupt, Rule::BothJump),
            false => (Fault::Incipient, Rule::BothDepart),
        };
        let found = Detection { fault, residual, threshold };
        let evidence = self.departure_evidence([residual, threshold], since);
        let by = if is_jump { Testimony::Innovations } else { Testimony::Way };
        // That it is latched is news where FDE1 stands already.
        let evidence = Some(Evidence { by: Some(by), size: Some(residual), ..evidence });
        Some(Finding { evidence, ..self.found(found, Blamed::new(Suspect::Process, rule)) })
    }

    /// As improbable as a Gaussian error of so many deviations.
    fn departure_evidence(&self, [error, limit]: [f64; 2], onset: Timestamp) -> Evidence {
        let deviations = self.design.reckoning.deviations * error / limit;
        Evidence {
            fault: 0.5 * deviations * deviations,
            location: None,
            by: Some(Testimony::Way),
            onset,
            gain: None,
            size: None,
        }
    }

    fn sequential_finding(&self) -> Option<Finding> {
        let alarm = self.sequential.as_ref()?.alarm()?;
        let blamed = self.blame(Accuser::Sequential, |_, _| {})?;
        Some(Finding {
            fault: if alarm.scale.is_some() { Fault::Unclassified } else { alarm.fault },
            suspect: blamed.suspect,
            rule: blamed.rule,
            level: self.level(blamed.suspect),
            residual: Some(alarm.size),
            threshold: None,
            evidence: Some(Evidence {
                fault: alarm.peak.nats,
                location: alarm.evidence,
                by: alarm.by,
                onset: alarm.onset,
                gain: alarm.scale.map(|scale| scale.gain),
                size: None,
            }),
            device: None,
        })
    }

    /// The finding of a difference, of another level where that runs towards the machine's own limit. A gain that is off
    /// swings with the rod, and runs nowhere.
    fn in_time(&self, finding: Finding) -> Finding {
        let is_gain = self.sequential.as_deref().is_some_and(Sequential::is_gain);
        if is_gain {
            return finding;
        }
        let level = self.trip.urgency().level(&self.design.levels);
        Finding { level: finding.level.max(level), ..finding }
    }

    fn process_finding(&self) -> Option<Finding> {
        let alarm = self.process.as_ref()?.alarm()?;
        let fault = match alarm.malfunction {
            Malfunction::Unclassified => Fault::Unclassified,
            Malfunction::DeadBand => Fault::ValveDeadBand,
            Malfunction::Leakage => Fault::Leakage,
            Malfunction::Friction => Fault::Friction,
            Malfunction::Sticking => Fault::ValveSticking,
            Malfunction::Offset | Malfunction::Null => Fault::ValveOffset,
            Malfunction::Late | Malfunction::OtherCommand => Fault::Command,
            Malfunction::Supply => Fault::Supply,
            Malfunction::Chambers if self.supply_is_odd => Fault::Supply,
            Malfunction::Chambers => Fault::PressureSensor,
        };
        Some(Finding {
            fault,
            suspect: Suspect::Process,
            rule: Rule::ProcessDetector,
            level: self.level(Suspect::Process).max(alarm.urgency.level(&self.design.levels)),
            residual: None,
            threshold: None,
            evidence: Some(Evidence {
                fault: alarm.nats,
                location: None,
                by: None,
                onset: alarm.onset,
                gain: None,
                size: alarm.size,
            }),
            device: None,
        })
    }

    /// The finding of R3, or of the machine's own rule where that is broken: then with the measured
    /// difference and its limit.
    fn difference_finding(&self) -> Option<Finding> {
        let [.., found] = self.fde.bank.detections();
        let found = found.zip(self.blame(Accuser::Fde3, |_, _| {}));
        let Some(apart) = self.trip.beyond() else {
            return found.map(|(detection, blamed)| self.found(detection, blamed));
        };
        let nobodys = (Fault::Unclassified, Blamed::new(Suspect::Undecided, Rule::MeasuredLimit));
        let (fault, Blamed { suspect, rule }) = match found {
            // The machine trips, whatever nobody has calibrated.
            Some((detection, _)) if detection.fault == Fault::NotCalibrated => nobodys,
            Some((detection, blamed)) => (detection.fault, blamed),
            // C1 − Ĉ2 is not judged, since a reading is frozen; or it is within its bound.
            None => self.frozen_one().map_or(nobodys, |suspect| {
                (Fault::Frozen, Blamed::new(suspect, Rule::StandingReading))
            }),
        };
        Some(Finding {
            fault,
            suspect,
            rule,
            level: self.design.levels.critical,
            residual: Some(apart),
            threshold: Some(self.design.critical),
            evidence: None,
            device: None,
        })
    }

    /// The only transducer that is frozen.
    fn frozen_one(&self) -> Option<Suspect> {
        match [0, 1].map(|i| self.readings.is_frozen(i)) {
            [true, false] => Some(Suspect::C1),
            [false, true] => Some(Suspect::C2),
            _ => None,
        }
    }

    fn implausible_finding(&self, i: usize, suspect: Suspect) -> Option<Finding> {
        let implausible =
            self.readings.implausible.get(i).filter(|implausible| implausible.raised())?;
        let out_of_range = implausible.fault == Fault::OutOfRange;
        Some(Finding {
            fault: implausible.fault,
            suspect,
            rule: Rule::Plausibility,
            level: self.design.levels.implausible,
            residual: out_of_range.then_some(implausible.beyond),
            threshold: out_of_range.then_some(0.0),
            evidence: None,
            device: implausible.report,
        })
    }

    /// Whether the reading of transducer `i` stands, off the ends of the stroke, while the command moves the rod.
    fn is_left_standing(&self, i: usize) -> bool {
        let reading = &self.readings.plausibility[i];
        reading.is_left_standing()
            && reading.newest().is_some_and(|it| !self.design.is_near_end(it))
    }

    /// State of each transducer; `stands` tells whether the warnings of this cycle blame it.
    pub fn health(&self, stands: impl Fn(Suspect) -> bool) -> [Health; 2] {
        let verdicts = self.fde.bank.verdicts();
        core::array::from_fn(|i| {
            let blamed = suspect_of(Transducer::ALL[i]);
            if !self.has(Transducer::ALL[i]) {
                Health::NotFitted
            } else if stands(blamed) {
                Health::Faulty
            } else if stands(Suspect::Undecided) {
                Health::Suspect
            } else if self.account.judged[i]
                && (verdicts[i] == Verdict::Healthy || !self.design.observes)
                && !stands(Suspect::Process)
                && !self.is_left_standing(i)
            {
                Health::Healthy
            } else {
                Health::Unknown
            }
        })
    }
}

/// What the samples weigh, where the sequential detector has found something.
fn proposal_of_samples(alarm: &Alarm) -> Blamed {
    let rule = match alarm.by {
        Some(Testimony::Flow) => Rule::FlowOfOil,
        Some(Testimony::Attitude) => Rule::DeckAttitude,
        Some(Testimony::Stop) => Rule::Stop,
        Some(Testimony::Innovations | Testimony::Way) => Rule::Innovations,
        None => Rule::NoSide,
    };
    Blamed::new(alarm.suspect, rule)
}

/// Whose reading the rod itself contradicts.
fn seen_of_the_rod(alarm: &Alarm) -> Option<Blamed> {
    alarm.by.is_some_and(Testimony::is_of_the_rod).then(|| proposal_of_samples(alarm))
}
