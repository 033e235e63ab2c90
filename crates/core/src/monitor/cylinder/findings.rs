//! Findings of the detectors of a cylinder, and the resulting states of its transducers.

use super::{Cylinder, Implausible, TRANSDUCERS};
use crate::alarm::detector::{PLACES, WarningPlace};
use crate::alarm::status::Health;
use crate::alarm::{Evidence, Finding, Level};
use crate::process::Malfunction;
use crate::sample::Quality;
use crate::sequential::Sequential;
use crate::verdict::{Fault, Suspect, Testimony, Verdict, bank::Detection};

impl Cylinder {
    /// Whether any detector has a finding now.
    pub fn finds_anything(&self) -> bool {
        self.detects_anything()
            || self.last.any_latched()
            || self.last.shared.is_some()
            || self.tilted.is_some()
            || self.plausibility.iter().any(|it| it.quality() == Quality::Doubtful)
            || self.implausible.iter().any(Implausible::raised)
    }

    /// Whether there are any [`Self::findings`]. What the stop finds of the only transducer stands for months, in which
    /// everything else has to supervise that transducer as if nothing were found.
    pub fn has_findings(&self) -> bool {
        self.finds_anything() || self.drifted.is_some()
    }

    /// Whether any detector beside the plausibility checks and the supervision of the last transducer has a finding now.
    #[inline(always)]
    pub(super) fn detects_anything(&self) -> bool {
        self.bank.any_found()
            || self.was_critical
            || self.sequential.as_ref().is_some_and(|sequential| sequential.alarm().is_some())
            || self.process.as_ref().is_some_and(|process| process.alarm().is_some())
    }

    /// Present findings of the detectors, in the places of the [`crate::alarm::Register`].
    pub fn findings(&self) -> [Option<Finding>; PLACES] {
        let [fde1, fde2, fde3] = self.bank.detections();
        let levels = &self.design.levels;
        let of_observer =
            |i, detection| self.observer_finding(self.told(i, self.agreed(i, detection)));
        let mut findings = [None; PLACES];
        let mut put = |place: WarningPlace, finding| findings[place as usize] = finding;
        for (i, place) in [WarningPlace::Fde1, WarningPlace::Fde2].into_iter().enumerate() {
            let found = [fde1, fde2][i];
            let usual = || found.map(|detection| of_observer(i, detection));
            // What both are off by comes after all that names one of them.
            let shared = || self.shared_finding().filter(|_| place == WarningPlace::Fde1);
            put(place, self.last_finding(i, found).or_else(usual).or_else(shared));
        }
        let fde3 = fde3.map(|detection| self.named(detection));
        put(WarningPlace::Fde3, self.difference_finding(fde3).map(|it| self.in_time(it)));
        put(WarningPlace::PlausibilityOfC1, self.implausible_finding(0, Suspect::C1));
        put(WarningPlace::PlausibilityOfC2, self.implausible_finding(1, Suspect::C2));
        put(WarningPlace::PlausibilityOfCommand, self.implausible_finding(2, Suspect::Process));
        let sequential = self.sequential_finding().map(|it| self.in_time(it));
        put(WarningPlace::Sequential, sequential.or_else(|| self.stop_finding()));
        put(WarningPlace::Process, self.process_finding());
        put(WarningPlace::Hexapod, self.hexapod_finding().map(|it| self.in_time(it)));
        let blames = |i: usize| {
            let own = [WarningPlace::Fde1, WarningPlace::Fde2][i] as usize;
            // A single sample of the last one is not yet the loss of both.
            let counts = |place| place != own || !self.last.is_tentative(i);
            let is_blamed = |f: &Finding| f.suspect == [Suspect::C1, Suspect::C2][i];
            (0..PLACES)
                .any(|place| counts(place) && findings[place].as_ref().is_some_and(is_blamed))
                || !self.has(TRANSDUCERS[i])
        };
        if blames(0) && blames(1) {
            for finding in findings.iter_mut().flatten() {
                if matches!(finding.suspect, Suspect::C1 | Suspect::C2) {
                    finding.level = finding.level.max(levels.both);
                }
            }
        }
        findings
    }

    /// The observer's detection, without the blame if the readings agree, or if spool and pressures explain it: the
    /// cylinder does not do what its command says, and nothing sets C1 and C2 apart.
    fn agreed(&self, i: usize, detection: Detection) -> Detection {
        let is_apart = self.bank.verdicts()[2] == Verdict::Faulty
            || self.sequential.as_ref().is_some_and(|it| it.alarm().is_some());
        let is_explained = self.process.as_ref().is_some_and(|it| it.alarm().is_some());
        if self.agreement.is_shared(i) && detection.suspect == [Suspect::C1, Suspect::C2][i] {
            return Detection { suspect: Suspect::Undecided, ..detection };
        }
        if self.agreement.is_process(i) || is_explained && !is_apart {
            return Detection { suspect: Suspect::Process, ..detection };
        }
        detection
    }

    /// The detection, unless plausibility clears the transducer that it blames.
    fn told(&self, k: usize, detection: Detection) -> Detection {
        Detection { suspect: self.precedence.suspect(k, detection.suspect), ..detection }
    }

    /// The detection of the difference, which cannot tell by itself whose it is: where the oil or the deck's attitude has
    /// named the reading that moved, it is the same displacement.
    fn named(&self, detection: Detection) -> Detection {
        let alarm = self.sequential.as_ref().and_then(|it| it.alarm());
        let named = alarm.filter(|it| it.by.is_some_and(Testimony::is_of_the_rod));
        let latched = [0, 1].map(|i| self.last.is_latched(i));
        match named {
            // It was out before the other one came back.
            None if detection.suspect == Suspect::Undecided && latched[0] != latched[1] => {
                let suspect = if latched[0] { Suspect::C1 } else { Suspect::C2 };
                Detection { suspect, ..detection }
            }
            Some(alarm) if detection.suspect == Suspect::Undecided => {
                let suspect = self.precedence.suspect_by_the_rod(2, alarm.suspect);
                Detection { suspect, ..detection }
            }
            _ => self.told(2, detection),
        }
    }

    pub(super) fn observer_finding(&self, detection: Detection) -> Finding {
        Finding {
            fault: detection.fault,
            suspect: detection.suspect,
            level: self.level(detection.suspect),
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

    fn sequential_finding(&self) -> Option<Finding> {
        let alarm = self.sequential.as_ref()?.alarm()?;
        let suspect = match alarm.by.is_some_and(Testimony::is_of_the_rod) {
            true => self.precedence.suspect_by_the_rod(3, alarm.suspect),
            false => self.precedence.suspect(3, alarm.suspect),
        };
        Some(Finding {
            fault: if alarm.scale.is_some() { Fault::Unclassified } else { alarm.fault },
            suspect,
            level: self.level(suspect),
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

    /// What the deck's attitude finds of the only transducer, or the finding of the sequential detector, where the deck's
    /// attitude has told whose it is.
    fn hexapod_finding(&self) -> Option<Finding> {
        if self.tilted.is_some() {
            return self.tilted_finding();
        }
        let by = self.sequential.as_ref()?.alarm()?.by;
        self.sequential_finding().filter(|_| by == Some(Testimony::Attitude))
    }

    /// The finding of a difference, of another level where that runs towards the machine's own limit. A gain that is off
    /// swings with the rod, and runs nowhere.
    fn in_time(&self, finding: Finding) -> Finding {
        let is_gain = self.sequential.as_deref().is_some_and(Sequential::is_gain);
        if is_gain {
            return finding;
        }
        let level = self.approach.urgency().level(&self.design.levels);
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
    fn difference_finding(&self, found: Option<Detection>) -> Option<Finding> {
        if !self.was_critical {
            return found.map(|detection| self.observer_finding(detection));
        }
        let (fault, suspect) = match found {
            // The machine trips, whatever nobody has calibrated.
            Some(detection) if detection.fault == Fault::NotCalibrated => Default::default(),
            Some(detection) => (detection.fault, detection.suspect),
            // C1 − Ĉ2 is not judged, since a reading is frozen; or it is within its bound.
            None => self.frozen_one().unwrap_or_default(),
        };
        Some(Finding {
            fault,
            suspect,
            level: self.design.levels.critical,
            residual: Some(self.apart),
            threshold: Some(self.design.critical),
            evidence: None,
            device: None,
        })
    }

    /// The only transducer that is frozen.
    fn frozen_one(&self) -> Option<(Fault, Suspect)> {
        match [0, 1].map(|i| self.is_frozen(i)) {
            [true, false] => Some((Fault::Frozen, Suspect::C1)),
            [false, true] => Some((Fault::Frozen, Suspect::C2)),
            _ => None,
        }
    }

    fn is_frozen(&self, i: usize) -> bool {
        self.implausible[i].raised() && self.implausible[i].fault == Fault::Frozen
    }

    fn implausible_finding(&self, i: usize, suspect: Suspect) -> Option<Finding> {
        let implausible = self.implausible.get(i).filter(|implausible| implausible.raised())?;
        let out_of_range = implausible.fault == Fault::OutOfRange;
        Some(Finding {
            fault: implausible.fault,
            suspect,
            level: self.design.levels.implausible,
            residual: out_of_range.then_some(implausible.beyond),
            threshold: out_of_range.then_some(0.0),
            evidence: None,
            device: implausible.report,
        })
    }

    /// Whether the reading of transducer `i` stands, off the ends of the stroke, while the command moves the rod.
    fn is_left_standing(&self, i: usize) -> bool {
        self.plausibility[i].is_left_standing()
            && self.plausibility[i].newest().is_some_and(|it| !self.is_near_end(it))
    }

    /// State of each transducer; `stands` tells whether the warnings of this cycle blame it.
    pub fn health(&self, stands: impl Fn(Suspect) -> bool) -> [Health; 2] {
        let verdicts = self.bank.verdicts();
        core::array::from_fn(|i| {
            let blamed = [Suspect::C1, Suspect::C2][i];
            if !self.has(TRANSDUCERS[i]) {
                Health::NotFitted
            } else if stands(blamed) {
                Health::Faulty
            } else if stands(Suspect::Undecided) {
                Health::Suspect
            } else if self.judged[i]
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
