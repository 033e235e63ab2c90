//! One machine whose transducers drift, or without a fault.

use super::cases::{IN_TIME, STRETCH, SideCase};
use crate::evaluate::machines::{ProcessMachine, varied};
use crate::evaluate::stand::{Stand, StandError};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use tertius_core::alarm::{Detector, State, Warning};
use tertius_core::monitor::{Monitor, MonitorDesign};
use tertius_core::time::Span;
use tertius_core::verdict::Suspect;
use tertius_machine::inject::{Fault, Placed, Shape, Wanted, Window, place};
use tertius_machine::plant::CYLINDERS;
use tertius_machine::simulator::{EPOCH, Options, Simulator};

/// Time before the earliest drift, s: minutes at work, and within which they all begin.
const LEAD: f64 = 300.0;
const SPREAD: f64 = 10.0;

/// What was said of one drift.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SideOutcome {
    /// How far it had drifted when it was first found, and when the right transducer was first named, m.
    pub found: Option<f64>,
    pub named: Option<f64>,
    /// Whether the innocent one was ever named by the sequential detector, and by any.
    pub wrong: [bool; 2],
    /// Whether the process detector warned.
    pub process: bool,
    /// Whether the cylinder had a warning when it began.
    pub spoilt: bool,
}

/// What was said of a healthy machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SideQuiet {
    /// Warnings of the sequential and of the process detectors.
    pub raises: u64,
    /// Warnings of the sequential detectors that named a transducer.
    pub named: u64,
}

impl Stand<'_> {
    /// Plays a machine on which one transducer of every cylinder drifts in the loop.
    pub(super) fn drifting(
        &self,
        machine: ProcessMachine,
        design: &MonitorDesign,
        sea: [f64; 2],
        case: &SideCase,
        rng: &mut ChaCha8Rng,
    ) -> Result<Vec<SideOutcome>, StandError> {
        let seed: u64 = rng.random();
        let drawn: [(f64, f64); CYLINDERS] = std::array::from_fn(|_| {
            let at = LEAD + SPREAD * rng.random::<f64>();
            (at, if rng.random::<bool>() { case.rate } else { -case.rate })
        });
        let placed = |(cylinder, (at, rate)): (u8, &(f64, f64))| {
            let window = Window { from: Span::from_seconds(*at), until: None };
            let wanted = Wanted::Shape(Shape::Drift { rate: *rate });
            let fault = Fault { cylinder, sensor: case.transducer.name(), wanted, window };
            Ok(place(&fault, self.settings, self.database)?)
        };
        let drawn = || (1..=self.settings.machine.cylinders).zip(&drawn);
        let faults: Result<Vec<Placed>, StandError> = drawn().map(placed).collect();
        let sea = Some(sea);
        let options = Options { seed, sea, faults: faults?, in_loop: true, ..Options::default() };
        let mut simulator =
            self.lagging((machine.grade, false), Some(machine.lag), None, &options)?;
        let end = LEAD + SPREAD + IN_TIME / case.rate;
        let warnings = self.heard(&mut simulator, design, end);
        let outcomes = drawn().map(|(n, drawn)| outcome(case, &warnings, n, drawn.0));
        Ok(outcomes.collect())
    }

    /// Plays a healthy machine with another load and friction.
    pub(super) fn still(
        &self,
        machine: ProcessMachine,
        design: &MonitorDesign,
        sea: [f64; 2],
        rng: &mut ChaCha8Rng,
    ) -> Result<SideQuiet, StandError> {
        let options = Options { seed: rng.random(), sea: Some(sea), ..Options::default() };
        let changed = Some(varied(rng));
        let mut simulator =
            self.lagging((machine.grade, false), Some(machine.lag), changed, &options)?;
        let warnings = self.heard(&mut simulator, design, STRETCH);
        let own =
            |it: &&Warning| it.detector == Detector::Process || it.detector == Detector::Sequential;
        let raised = warnings.iter().filter(own).filter(|it| it.state == State::Raised).count();
        let named = |it: &&Warning| {
            it.detector == Detector::Sequential
                && it.state != State::Cleared
                && matches!(it.finding.suspect, Suspect::C1 | Suspect::C2)
        };
        let named = warnings.iter().filter(named).count() as u64;
        Ok(SideQuiet { raises: raised as u64, named })
    }

    fn heard(
        &self,
        simulator: &mut Simulator,
        design: &MonitorDesign,
        seconds: f64,
    ) -> Vec<Warning> {
        let mut monitor = Monitor::new(design.clone());
        let mut warnings: Vec<Warning> = Vec::new();
        for _ in 0..self.cycles(seconds) {
            simulator.step(&mut |frame| monitor.take(frame, &mut warnings));
        }
        monitor.finish(&mut warnings);
        warnings
    }
}

/// What `warnings` say of the drift of `cylinder` that began `at` seconds after the first frame.
fn outcome(case: &SideCase, warnings: &[Warning], cylinder: u8, at: f64) -> SideOutcome {
    let onset = EPOCH.after(Span::from_seconds(at));
    let end = onset.after(Span::from_seconds(IN_TIME / case.rate));
    let drifted = |it: &Warning| case.rate * it.timestamp.since(onset).as_seconds();
    let innocent = if case.transducer == Suspect::C1 { Suspect::C2 } else { Suspect::C1 };
    let own = || warnings.iter().filter(|it| it.cylinder == cylinder && it.timestamp <= end);
    let said = || own().filter(|it| it.timestamp >= onset && it.state != State::Cleared);
    let blames = |suspect| move |it: &&Warning| it.finding.suspect == suspect;
    let before = own().filter(|it| it.timestamp < onset);
    let standing = before.fold(0_i32, |standing, it| match it.state {
        State::Raised => standing + 1,
        State::Changed => standing,
        State::Cleared => standing - 1,
    });
    let of_sequential = |it: &&Warning| it.detector == Detector::Sequential;
    SideOutcome {
        found: said().next().map(drifted),
        named: said().find(blames(case.transducer)).map(drifted),
        wrong: [
            said().filter(of_sequential).any(|it| blames(innocent)(&it)),
            said().any(|it| blames(innocent)(&it)),
        ],
        process: said().any(|it| it.detector == Detector::Process),
        spoilt: standing > 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tertius_core::alarm::{Finding, Level};
    use tertius_core::blame::Rule;
    use tertius_core::verdict::Fault as Kind;

    fn warning(seconds: f64, state: State, suspect: Suspect) -> Warning {
        Warning {
            timestamp: EPOCH.after(Span::from_seconds(seconds)),
            cylinder: 3,
            detector: Detector::Sequential,
            place: 6,
            state,
            finding: Finding {
                fault: Kind::Incipient,
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

    #[test]
    fn a_drift_is_named_where_it_was_then_and_nothing_counts_after_it_is_too_late() {
        let case = SideCase { transducer: Suspect::C2, rate: 1e-3 };
        let of = |warnings: &[Warning]| outcome(&case, warnings, 3, 100.0);
        let said = of(&[
            warning(101.0, State::Raised, Suspect::Undecided),
            warning(107.0, State::Changed, Suspect::C2),
            warning(125.0, State::Changed, Suspect::C1),
        ]);
        assert_eq!(said.wrong, [false; 2]);
        assert!((said.found.unwrap() - 1e-3).abs() < 1e-12, "{said:?}");
        assert!((said.named.unwrap() - 7e-3).abs() < 1e-12, "{said:?}");
        let wrong = of(&[
            warning(101.0, State::Raised, Suspect::C1),
            warning(107.0, State::Changed, Suspect::C2),
        ]);
        assert_eq!((wrong.wrong, wrong.spoilt), ([true; 2], false));
        let thesis =
            Warning { detector: Detector::Fde1, ..warning(101.0, State::Raised, Suspect::C1) };
        assert_eq!(of(&[thesis]).wrong, [false, true]);
        assert!(of(&[warning(90.0, State::Raised, Suspect::Undecided)]).spoilt);
        assert_eq!(
            outcome(&case, &[warning(101.0, State::Raised, Suspect::C2)], 2, 100.0).named,
            None
        );
    }
}
