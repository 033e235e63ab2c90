//! One machine with a fault, or without.

use super::cases::{ProcessCase, STRETCH};
use crate::evaluate::machines::{ProcessMachine, varied};
use crate::evaluate::stand::{Stand, StandError};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use tertius_core::alarm::detector::PLACES;
use tertius_core::alarm::{Detector, State, Warning};
use tertius_core::monitor::{Monitor, MonitorDesign, Sink};
use tertius_core::process::ProcessParameters;
use tertius_core::time::{Span, Timestamp};
use tertius_core::verdict::{Fault as Kind, Suspect};
use tertius_machine::inject::{Fault, Placed, Shape, Wanted, place};
use tertius_machine::plant::{Ailment, CYLINDERS};
use tertius_machine::simulator::{EPOCH, Options, Simulator};

/// Time from when the detectors judge until the earliest fault, and within which the faults begin, s.
const LEAD: f64 = 12.0;
const SPREAD: f64 = 3.0;

/// What was said of one fault.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProcessOutcome {
    /// From the fault to the first warning of the process detector, s.
    pub delay: Option<f64>,
    /// What it was called at last.
    pub kind: Option<Kind>,
    /// Its size as told, over the true one; of the faults that have one.
    pub size: Option<f64>,
    /// Whether any warning named a transducer, and whether one still does when it is said last.
    pub blamed: [bool; 2],
    /// Whether the process detector had warned before.
    pub spoilt: bool,
}

/// What was said of a healthy machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProcessQuiet {
    /// Warnings of process detectors.
    pub raises: u64,
}

/// Keeps the warnings.
#[derive(Default)]
struct Listener(Vec<Warning>);

impl Sink for Listener {
    fn wants_records(&self) -> bool {
        false
    }

    fn warning(&mut self, warning: &Warning) {
        self.0.push(*warning);
    }
}

impl Stand<'_> {
    /// Plays a machine with the fault of `case` on every cylinder, watched by a monitor of that design.
    pub(super) fn ailing(
        &self,
        (machine, design): (ProcessMachine, &MonitorDesign),
        sea: [f64; 2],
        case: &ProcessCase,
        rng: &mut ChaCha8Rng,
    ) -> Result<Vec<ProcessOutcome>, StandError> {
        let tables = self.tables_of(machine.grade);
        let case = &case.on(tables);
        let seed: u64 = rng.random();
        let begin = ProcessParameters::DEFAULT.opening + LEAD;
        let drawn: [(f64, f64); CYLINDERS] = std::array::from_fn(|_| {
            let at = begin + SPREAD * rng.random::<f64>();
            (at, if rng.random::<bool>() { 1.0 } else { -1.0 })
        });
        // Pressures that are off everywhere are the supply's.
        let count = u64::from(self.settings.machine.cylinders);
        let every = |n: &u8| match case.expected {
            Some(Kind::PressureSensor) => seed % 2 == u64::from(*n) % 2,
            _ if case.is_of_all() => seed % count == u64::from(*n) - 1,
            _ => true,
        };
        let cylinders = 1..=self.settings.machine.cylinders;
        let chosen = || cylinders.clone().zip(&drawn).filter(|(n, _)| every(n));
        let faults: Vec<Fault> = chosen().map(|(n, drawn)| fault(case, n, *drawn)).collect();
        let of_machine = matches!(case.wanted, Wanted::Machine(_));
        let placed = |fault: &Fault| Ok(place(fault, self.settings, self.database)?);
        let (ailments, faults) = if of_machine {
            (faults, Vec::new())
        } else {
            let placed: Result<Vec<Placed>, StandError> = faults.iter().map(placed).collect();
            (Vec::new(), placed?)
        };
        let sea = Some(sea);
        let options = Options { seed, sea, ailments, faults, in_loop: true, ..Options::default() };
        let mut simulator =
            self.lagging((machine.grade, true), Some(machine.lag), None, &options)?;
        let warnings = self.watched(&mut simulator, design, begin + SPREAD + case.watch);
        let outcome = |(n, drawn): (u8, &(f64, f64))| outcome(case, &warnings, n, *drawn);
        Ok(chosen().map(outcome).collect())
    }

    /// Plays a healthy machine with another load and friction.
    pub(super) fn hale(
        &self,
        (machine, design): (ProcessMachine, &MonitorDesign),
        sea: [f64; 2],
        rng: &mut ChaCha8Rng,
    ) -> Result<ProcessQuiet, StandError> {
        let options = Options { seed: rng.random(), sea: Some(sea), ..Options::default() };
        let changed = Some(varied(rng));
        let mut simulator =
            self.lagging((machine.grade, true), Some(machine.lag), changed, &options)?;
        let warnings = self.watched(&mut simulator, design, STRETCH);
        let raised = |it: &&Warning| is_process(it) && it.state == State::Raised;
        Ok(ProcessQuiet { raises: warnings.iter().filter(raised).count() as u64 })
    }

    fn watched(
        &self,
        simulator: &mut Simulator,
        design: &MonitorDesign,
        seconds: f64,
    ) -> Vec<Warning> {
        let mut monitor = Monitor::new(design.clone());
        let mut listener = Listener::default();
        for _ in 0..self.cycles(seconds) {
            simulator.step(&mut |frame| monitor.take(frame, &mut listener));
        }
        monitor.finish(&mut listener);
        listener.0
    }
}

fn is_process(warning: &Warning) -> bool {
    warning.detector == Detector::Process
}

fn fault(case: &ProcessCase, cylinder: u8, (at, sign): (f64, f64)) -> Fault {
    let window = tertius_machine::inject::Window { from: Span::from_seconds(at), until: None };
    let wanted = match case.wanted {
        Wanted::Machine(Ailment::SpoolOffset { size }) => {
            Wanted::Machine(Ailment::SpoolOffset { size: sign * size })
        }
        Wanted::Machine(Ailment::NullShift { size }) => {
            Wanted::Machine(Ailment::NullShift { size: sign * size })
        }
        Wanted::Shape(Shape::Step { size }) => Wanted::Shape(Shape::Step { size: sign * size }),
        Wanted::Shape(Shape::Drift { rate }) => Wanted::Shape(Shape::Drift { rate: sign * rate }),
        other => other,
    };
    Fault { cylinder, sensor: case.sensor, wanted, window }
}

fn outcome(
    case: &ProcessCase,
    warnings: &[Warning],
    cylinder: u8,
    (at, sign): (f64, f64),
) -> ProcessOutcome {
    let onset = EPOCH.after(Span::from_seconds(at));
    let own = || warnings.iter().filter(|it| it.cylinder == cylinder || case.is_of_all());
    let after = |it: &&Warning, from: Timestamp| it.timestamp >= from;
    let process = || own().filter(|it| is_process(it) && it.state != State::Cleared);
    let found = process().find(|it| after(it, onset));
    let last = process().rfind(|it| after(it, onset));
    let named = |it: &Warning| matches!(it.finding.suspect, Suspect::C1 | Suspect::C2);
    let said = || own().filter(|it| after(it, onset) && it.state != State::Cleared);
    let at_last = |place: usize| said().rfind(|it| it.place == place).is_some_and(named);
    // Sizes of another kind have another unit.
    let named_right = last.filter(|it| Some(it.finding.fault) == case.expected);
    let told = named_right.and_then(|it| it.finding.evidence?.size);
    let signed = matches!(case.expected, Some(Kind::ValveOffset | Kind::PressureSensor));
    let truth = case.size.map(|size| if signed { sign * size } else { size });
    ProcessOutcome {
        delay: found.map(|it| it.timestamp.since(onset).as_seconds()),
        kind: last.map(|it| it.finding.fault),
        size: told.zip(truth).map(|(told, truth)| told / truth),
        blamed: [said().any(named), (0..PLACES).any(at_last)],
        spoilt: process().any(|it| !after(&it, onset)),
    }
}
