//! One machine with a fault on each cylinder, and the response of every detector.

use super::ladder::{Ladder, Rival};
use crate::evaluate::learning::Learnt;
use crate::evaluate::outcome::{Blame, Outcome};
use crate::evaluate::stand::{Stand, StandError};
use crate::evaluate::tried::{TriedFault, Try};
use tertius_core::alarm::{Detector, State, Warning};
use tertius_core::monitor::{Monitor, Record, Sink};
use tertius_core::sequential::{Input, Sequential};
use tertius_core::time::{Span, Timestamp};
use tertius_core::verdict::{Fault, Suspect, Verdict};
use tertius_machine::plant::CYLINDERS;
use tertius_machine::simulator::Options;

/// What became of one fault.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// A sequential alarm already stood when the fault began.
    pub spoilt: bool,
    /// From the sampling of the first faulty reading to the warning of the observers, of the
    /// comparator and of the sequential detector, s.
    pub delays: [Option<f64>; Rival::ALL.len()],
    /// Suspect that the sequential detector blames in the end; wrong if it was ever wrong.
    pub blame: Option<Blame>,
    /// Fault that the sequential detector names in the end.
    pub kind: Option<Fault>,
    pub ladder: Ladder,
}

/// Hears the monitor, and goes through its records with detectors of its own that never alarm.
pub(super) struct Listener {
    pub warnings: Vec<Warning>,
    detectors: Vec<Sequential>,
    values: [[Option<f64>; Rival::ALL.len()]; CYLINDERS],
}

impl Listener {
    pub fn new(learnt: &Learnt) -> Self {
        let detectors = learnt.detectors.iter().cloned().map(Sequential::new).collect();
        Self { warnings: Vec::new(), detectors, values: Default::default() }
    }
}

impl Sink for Listener {
    fn warning(&mut self, warning: &Warning) {
        self.warnings.push(*warning);
    }

    fn record(&mut self, record: &Record) {
        let index = usize::from(record.cylinder) - 1;
        let good = record.qualities.map(|quality| quality.is_good());
        let detector = &mut self.detectors[index];
        detector.step(&Input {
            lengths: [record.c1.filter(|_| good[0]), record.c2.filter(|_| good[1])],
            velocity: record.velocities[1].filter(|_| good[1]),
            command: record.command,
            monitored: record.monitored,
            at: record.timestamp,
        });
        self.values[index] = values(record, detector);
    }
}

/// Value that each rival judges in a cycle, in the order of [`Rival::ALL`].
pub(super) fn values(record: &Record, detector: &Sequential) -> [Option<f64>; Rival::ALL.len()] {
    let [r1, r2, r3] = record.residuals.map(|residual| residual.map(f64::abs));
    let [r1, r2] = [r1.filter(|_| record.judged[0]), r2.filter(|_| record.judged[1])];
    let judges = detector.verdict() != Verdict::Unknown;
    let [mean, variance] = detector.peaks();
    [r1.into_iter().chain(r2).reduce(f64::max), r3, judges.then(|| mean.nats.max(variance.nats))]
}

/// A fault that is being followed.
struct Followed<'a> {
    fault: &'a TriedFault,
    /// The Sync at which the first faulty reading was sampled.
    onset: Option<Timestamp>,
    ladder: Ladder,
}

impl Followed<'_> {
    /// Takes the cycle that opened at `opening`; `altered`: the fault was in it.
    fn take(&mut self, opening: Timestamp, altered: bool, listener: &Listener, stand: &Stand) {
        if altered {
            self.onset.get_or_insert(opening);
        }
        let Some(onset) = self.onset else { return };
        let number = stand.cycles_since(onset, opening) + 1;
        let cylinder = usize::from(self.fault.cylinder) - 1;
        self.ladder.take(number, listener.values[cylinder]);
    }
}

impl Stand<'_> {
    /// Plays `one` in `sea` for `watch` seconds after its faults' onsets, the machine engaged and its
    /// controller reading the faults: an entry for each of them.
    ///
    /// # Errors
    /// If there is no such machine, or no place for such a fault on it.
    pub fn contest(
        &self,
        learnt: &Learnt,
        one: &Try,
        sea: [f64; 2],
        watch: f64,
    ) -> Result<Vec<Entry>, StandError> {
        let faults = self.placed(one)?;
        let options =
            Options { seed: one.seed, sea: Some(sea), in_loop: true, faults, ..Options::default() };
        let mut simulator = self.steady(learnt.grade, &options)?;
        let mut monitor = Monitor::new(learnt.design.clone());
        let mut listener = Listener::new(learnt);
        let begun = simulator.opening();
        let latest = one.faults.iter().map(|fault| fault.at).fold(0.0, f64::max);
        let mut followed: Vec<Followed> = one.faults.iter().map(Followed::new).collect();
        for _ in 0..self.cycles(latest + watch + 1.0) {
            let opening = simulator.opening();
            simulator.step(&mut |frame| monitor.take(frame, &mut listener));
            for (index, followed) in followed.iter_mut().enumerate() {
                let altered = match followed.fault.wanted {
                    Some(_) => simulator.tallies()[index].altered > 0,
                    None => opening.since(begun).as_seconds() >= followed.fault.at,
                };
                followed.take(opening, altered, &listener, self);
            }
        }
        monitor.finish(&mut listener);
        let entry = |followed: Followed| {
            let asked = begun.after(Span::from_seconds(followed.fault.at));
            let onset = followed.onset.unwrap_or(asked);
            let end = onset.after(Span::from_seconds(watch));
            let heard = Heard { warnings: &listener.warnings, onset, end };
            heard.entry(followed.fault.cylinder, followed.fault.transducer, followed.ladder)
        };
        Ok(followed.into_iter().map(entry).collect())
    }

    fn cycles_since(&self, onset: Timestamp, now: Timestamp) -> u32 {
        (now.since(onset).as_seconds() / self.settings.machine.sample_time).round() as u32
    }
}

impl<'a> Followed<'a> {
    fn new(fault: &'a TriedFault) -> Self {
        Self { fault, onset: None, ladder: Ladder::default() }
    }
}

/// Warnings from a fault's onset to the end of its watch.
pub(super) struct Heard<'a> {
    pub warnings: &'a [Warning],
    pub onset: Timestamp,
    pub end: Timestamp,
}

impl Heard<'_> {
    /// The entry for a fault of `transducer` of `cylinder` (from 1).
    pub fn entry(&self, cylinder: u8, transducer: Suspect, ladder: Ladder) -> Entry {
        let own = |sequential: bool| -> Vec<Warning> {
            let is = |it: &&Warning| (it.detector == Detector::Sequential) == sequential;
            self.warnings.iter().filter(is).copied().collect()
        };
        let [others, sequential] = [own(false), own(true)];
        let read = |it: &[Warning]| Outcome::read(it, cylinder, transducer, self.onset, self.end);
        let (others, outcome) = (read(&others), read(&sequential));
        let told = |it: &&Warning| {
            let in_time = (self.onset..=self.end).contains(&it.timestamp);
            it.cylinder == cylinder && in_time && it.state != State::Cleared
        };
        let wrong = |it: &Warning| {
            !matches!(it.finding.suspect, Suspect::Undecided | Suspect::Process)
                && it.finding.suspect != transducer
        };
        let blame = if sequential.iter().filter(told).any(wrong) {
            Some(Blame::Wrong)
        } else {
            outcome.blame
        };
        let by = |detector: Detector| detector as usize - 1;
        let delay =
            |one: Option<f64>, other: Option<f64>| one.into_iter().chain(other).reduce(f64::min);
        Entry {
            spoilt: outcome.spoilt,
            delays: [
                delay(others.delays[by(Detector::Fde1)], others.delays[by(Detector::Fde2)]),
                others.delays[by(Detector::Fde3)],
                outcome.delays[by(Detector::Sequential)],
            ],
            blame,
            kind: sequential.iter().rfind(told).map(|it| it.finding.fault),
            ladder,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tertius_core::alarm::{Finding, Level};
    use tertius_core::blame::Rule;

    /// A warning of cylinder 2 by its sequential detector, at `at` ms.
    fn warning(at: i64, state: State, fault: Fault, suspect: Suspect) -> Warning {
        let place = tertius_core::alarm::register::DETECTORS
            .iter()
            .position(|detector| *detector == Detector::Sequential);
        Warning {
            timestamp: Timestamp::from_nanos(at * 1_000_000),
            cylinder: 2,
            detector: Detector::Sequential,
            place: place.expect("it has a place"),
            state,
            finding: Finding {
                fault,
                suspect,
                rule: Rule::OneObserver,
                level: Level::Yellow,
                residual: None,
                threshold: None,
                evidence: None,
                device: None,
            },
        }
    }

    fn heard(suspects: &[Suspect]) -> Entry {
        let mut warnings = vec![warning(1020, State::Raised, Fault::Noise, Suspect::Undecided)];
        warnings.extend(
            (0..).zip(suspects).map(|(k, suspect)| {
                warning(1200 + 100 * k, State::Changed, Fault::Abrupt, *suspect)
            }),
        );
        let [onset, end] = [1000, 2000].map(|ms| Timestamp::from_nanos(ms * 1_000_000));
        Heard { warnings: &warnings, onset, end }.entry(2, Suspect::C2, Ladder::default())
    }

    #[test]
    fn whoever_was_wrong_once_is_not_right_in_the_end() {
        let right = heard(&[Suspect::C2]);
        assert_eq!((right.blame, right.kind), (Some(Blame::Right), Some(Fault::Abrupt)));
        assert_eq!((right.delays, right.spoilt), ([None, None, Some(0.02)], false));
        assert_eq!(heard(&[]).blame, Some(Blame::Undecided));
        assert_eq!(heard(&[Suspect::C1, Suspect::C2]).blame, Some(Blame::Wrong));
    }
}
