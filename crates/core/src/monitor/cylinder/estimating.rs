//! The estimated length: what the virtual sensor is given in a cycle.

use super::estimated::EstimatedLength;
use super::findings::standing;
use super::last::SharedDeparture;
use super::{Cycle, Cylinder};
use crate::alarm::Finding;
use crate::alarm::detector::{PLACES, WarningPlace};
use crate::estimate::{Estimate, SensorInput};
use crate::sample::Transducer;
use crate::verdict::{FDE3, Fault, Suspect};
use alloc::boxed::Box;

impl Cylinder {
    /// This cylinder with a virtual sensor.
    pub fn estimating(mut self) -> Self {
        self.estimated = Some(Box::new(EstimatedLength::new(self.design.estimate.clone())));
        self
    }

    /// The estimate of the newest cycle: `None` where none is made, `Some(None)` where the length
    /// is not known.
    #[inline]
    pub fn estimated(&self) -> Option<Option<&Estimate>> {
        self.estimated.as_ref().map(|it| it.newest())
    }

    /// Whether no transducer is trusted, and the reading of one may have been wrong before it was blamed: what is found by
    /// its innovation, or once it has stood for long enough, is found later than it began.
    fn is_last_doubted(&self, found: &[Option<Finding>; PLACES], trusted: [bool; 2]) -> bool {
        let is_left = |i: usize| self.has(Transducer::ALL[i]) && trusted[i];
        let facts = [WarningPlace::PlausibilityOfC1, WarningPlace::PlausibilityOfC2];
        let is_fact = |place: usize| facts.iter().any(|fact| *fact as usize == place);
        let is_late = |(place, it): (usize, &Finding)| {
            matches!(it.suspect, Suspect::C1 | Suspect::C2)
                && (!is_fact(place) || it.fault == Fault::Frozen)
        };
        let mut each = found.iter().enumerate().filter_map(|(k, it)| Some((k, it.as_ref()?)));
        !is_left(0) && !is_left(1) && each.any(is_late)
    }

    /// The largest step, m, of the transducer that is left that its observer would not find; 0 where two are left, or none.
    fn unseen_step(&self, is_left: [bool; 2]) -> f64 {
        match is_left {
            [true, false] => self.last.least_step(0, &self.design),
            [false, true] => self.last.least_step(1, &self.design),
            _ => 0.0,
        }
    }

    /// Estimates the length, after everything that blames a transducer in this cycle has done so.
    pub(super) fn estimate(&mut self, cycle: &Cycle) {
        let found = if self.finds_anything() { self.findings() } else { Default::default() };
        let blames = |suspect| found.iter().flatten().any(|it: &Finding| it.suspect == suspect);
        let unblamed = [!blames(Suspect::C1), !blames(Suspect::C2)];
        // A reading that may be wild is not used until it is known, where another one is.
        let sound = [0, 1].map(|i| unblamed[i] && !self.fde.bank.is_open(i));
        let trusted = [0, 1].map(|i| unblamed[i] && (sound[i] || !sound[1 - i]));
        let is_parted = self.fde.bank.is_open(FDE3) && sound == [true; 2];
        let high = self.design.bank.observer.high;
        let is_beyond = |innovation: f64| innovation.abs() > high;
        let input = SensorInput {
            cycle: cycle.now.cycle,
            lengths: cycle.lengths(),
            velocity: cycle.good[1].and_then(|reading| reading.velocity),
            command: self.inputs.command_value(),
            follows: cycle.is_monitored() && !self.command.is_stale(),
            trusted,
            // The two differ by the error of one of them: by a blamed one's, or by that of a reading of which neither observer
            // shows yet whether it is wild, as where a rod moves slowly away from a frozen one.
            undecided: (found.iter().flatten().any(is_dispute) || is_parted)
                && unblamed == [true; 2],
            resolved: is_resolved(&found) || self.last.any_latched(),
            process: blames(Suspect::Process),
            departs: self.last.shared.as_ref().map_or(0.0, SharedDeparture::size),
            unseen: self.unseen_step([0, 1].map(|i| self.has(Transducer::ALL[i]) && unblamed[i])),
            displaced: [Suspect::C1, Suspect::C2].map(|suspect| is_displaced(&found, suspect)),
            beyond: [0, 1].map(|i| cycle.residuals.r[i].is_some_and(is_beyond)),
            doubted: self.is_last_doubted(&found, unblamed),
        };
        if let Some(estimated) = &mut self.estimated {
            estimated.step(&input);
        }
    }
}

/// Whether it is not known which of the two is wrong. What a stop finds of the only transducer is no such dispute.
fn is_dispute(finding: &Finding) -> bool {
    finding.suspect == Suspect::Undecided && !finding.is_of_stop()
}

/// Whether a detector of a difference that stands names a transducer.
fn is_resolved(found: &[Option<Finding>; PLACES]) -> bool {
    standing(found).any(|it| matches!(it.suspect, Suspect::C1 | Suspect::C2))
}

/// Whether `suspect` is blamed for a step, and for nothing else.
fn is_displaced(found: &[Option<Finding>; PLACES], suspect: Suspect) -> bool {
    let mut blaming = found.iter().flatten().filter(|it| it.suspect == suspect).peekable();
    blaming.peek().is_some() && blaming.all(|it| it.fault == Fault::Abrupt)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alarm::{Evidence, Level};
    use crate::blame::Rule;
    use crate::time::Timestamp;
    use crate::verdict::Testimony;

    /// For months nothing else would be left to estimate by.
    #[test]
    fn what_the_stop_finds_of_an_only_transducer_disputes_no_reading() {
        let evidence = |by| Evidence {
            fault: 0.0,
            location: None,
            by,
            onset: Timestamp::default(),
            gain: None,
            size: None,
        };
        for (suspect, by, disputes) in [
            (Suspect::Undecided, None, true),
            (Suspect::Undecided, Some(Testimony::Innovations), true),
            (Suspect::Undecided, Some(Testimony::Stop), false),
            (Suspect::C1, None, false),
        ] {
            let finding = Finding {
                fault: Fault::Incipient,
                suspect,
                rule: Rule::OneObserver,
                level: Level::Yellow,
                residual: None,
                threshold: None,
                evidence: Some(evidence(by)),
                device: None,
            };
            assert_eq!(is_dispute(&finding), disputes, "{suspect:?} by {by:?}");
        }
    }

    #[test]
    fn what_noise_raises_for_a_second_ends_no_dispute() {
        let finding = Finding {
            fault: Fault::Noise,
            suspect: Suspect::C2,
            rule: Rule::OneObserver,
            level: Level::Red,
            residual: None,
            threshold: None,
            evidence: None,
            device: None,
        };
        for (place, suspect, ends) in [
            (WarningPlace::Fde2, Suspect::C2, false),
            (WarningPlace::PlausibilityOfC2, Suspect::C2, false),
            (WarningPlace::Fde3, Suspect::Undecided, false),
            (WarningPlace::Fde3, Suspect::C2, true),
            (WarningPlace::Sequential, Suspect::C1, true),
        ] {
            let mut found = [None; PLACES];
            found[place as usize] = Some(Finding { suspect, ..finding });
            assert_eq!(is_resolved(&found), ends, "{place:?} {suspect:?}");
        }
    }
}
