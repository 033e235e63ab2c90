//! One machine, with every fault in turn.

use super::cases::{HandoverCase, Policy};
use super::installation::{Installation, Motion};
use super::reader::{Blamed, Reader};
use crate::evaluate::grade::Grade;
use crate::evaluate::stand::{Stand, StandError};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use tertius_core::monitor::{Monitor, MonitorDesign};
use tertius_core::time::Span;
use tertius_machine::controller::Supervision;
use tertius_machine::inject::{Fault, Shape, Wanted, Window, place};
use tertius_machine::plant::CYLINDERS;
use tertius_machine::simulator::Options;

/// Time for which a machine is healthy before its faults, s.
pub const LEAD: f64 = 330.0;

/// Time within which the faults begin, s.
const SPREAD: f64 = 8.0;

/// Strokes of the healthy machine in each cycle from the branch on, m.
type Strokes = Vec<[f64; CYLINDERS]>;

/// How long the machine is watched after a code black, s: it is then in its safe state (Table 2-1).
const AFTER: f64 = 5.0;

/// How long a difference has to last until the machine's own supervision trips, s. Assumed: a controller that tripped
/// at one wild reading would not be of use.
const PATIENCE: f64 = 0.1;

/// Sensors with a fault.
pub const SENSORS: [&str; 2] = ["c1", "c2"];

/// What became of one fault, or of none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandoverOutcome {
    /// Index of the study's case.
    pub case: usize,
    /// 0: C1; 1: C2.
    pub which: usize,
    /// Whether a transducer of the machine was blamed before the fault.
    pub spoilt: bool,
    /// In the order of [`Policy::ALL`].
    pub ways: [Way; Policy::ALL.len()],
}

/// What became of it under one policy. Times are from the fault's begin, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Way {
    /// When the machine's supervision tripped.
    pub black: Option<f64>,
    /// When the controller knew first that the faulty transducer is blamed.
    pub blamed: Option<f64>,
    /// Detector that blamed a healthy transducer first.
    pub wrong: Option<u8>,
    /// Largest difference of the rod from where it would be without the fault, before a code black, m.
    pub rod: f64,
    /// Largest way of the gangway's tip, m, a code black's included.
    pub tip: f64,
}

/// The fault of a trial, drawn once for all cases.
#[derive(Clone, Copy, Debug)]
struct Drawn {
    leg: usize,
    sign: f64,
    /// Time after the branch, s.
    at: f64,
    seed: u64,
}

/// A machine under one policy while it is followed.
#[derive(Clone, Debug)]
struct Followed {
    installation: Installation,
    way: Way,
}

impl Stand<'_> {
    /// Plays a healthy machine with transducers of `grade`, whose gateway has that design, in `sea` for as long as its detectors need, and then every
    /// fault of `cases` on C1 and on C2 of its cylinder `number` (modulo their number) under every policy.
    ///
    /// # Errors
    /// There is no such machine, or no place for such a fault on it.
    pub(super) fn handed_over(
        &self,
        (grade, design): (Grade, &MonitorDesign),
        sea: [f64; 2],
        number: u32,
        cases: &[HandoverCase],
        rng: &mut ChaCha8Rng,
    ) -> Result<Vec<HandoverOutcome>, StandError> {
        let options =
            Options { seed: rng.random(), sea: Some(sea), in_loop: true, ..Options::default() };
        let drawn = Drawn {
            leg: number as usize % usize::from(self.settings.machine.cylinders),
            sign: if rng.random::<bool>() { 1.0 } else { -1.0 },
            at: 1.0 + SPREAD * rng.random::<f64>(),
            seed: rng.random(),
        };
        let mut simulator = self.steady(grade, &options)?;
        let patience = self.cycles(PATIENCE) as u32;
        simulator.supervise(Supervision::new(self.settings.comparator.critical, patience));
        let monitor = Monitor::new(design.clone());
        let reader = Reader::new(self.database)?;
        let gangway = self.tables_of(grade).gangway.length;
        let mut healthy = Installation::new(simulator, monitor, reader, gangway);
        let mut early = None;
        for _ in 0..self.cycles(LEAD) {
            early = early.or(healthy.step().first().map(|it| it.detector));
        }
        let longest = cases.iter().map(|case| case.watch).fold(0.0, f64::max);
        let strokes = self.strokes(&healthy, drawn.at + longest + AFTER);
        let mut outcomes = Vec::new();
        for (index, case) in cases.iter().enumerate() {
            for which in 0..SENSORS.len() {
                let Some(begun) = self.begun(&healthy, case, which, drawn)? else { continue };
                let watch = drawn.at + case.watch;
                let is_faulty = case.shape.is_some();
                let faulty = is_faulty.then_some((drawn.leg, which));
                let mut ways = self.played(begun, faulty, drawn, watch, &strokes);
                if !is_faulty {
                    // The time before is as healthy.
                    ways.iter_mut().for_each(|way| way.wrong = way.wrong.or(early));
                }
                let spoilt = is_faulty && early.is_some();
                outcomes.push(HandoverOutcome { case: index, which, spoilt, ways });
            }
        }
        Ok(outcomes)
    }

    /// The healthy machine with the fault of `case` before it; `None` where no fault would be tried twice.
    fn begun(
        &self,
        healthy: &Installation,
        case: &HandoverCase,
        which: usize,
        drawn: Drawn,
    ) -> Result<Option<Installation>, StandError> {
        let mut begun = healthy.clone();
        let Some(shape) = case.shape else { return Ok((which == 0).then_some(begun)) };
        let fault = Fault {
            cylinder: drawn.leg as u8 + 1,
            sensor: SENSORS[which],
            wanted: Wanted::Shape(signed(shape, drawn.sign)),
            window: Window { from: Span::from_seconds(drawn.at), until: None },
        };
        let placed = place(&fault, self.settings, self.database)?;
        begun.simulator.afflict(&[placed], drawn.seed);
        Ok(Some(begun))
    }

    /// Strokes of the healthy machine in the next `seconds`.
    fn strokes(&self, healthy: &Installation, seconds: f64) -> Strokes {
        let mut simulator = healthy.simulator.clone();
        let cycles = 0..=self.cycles(seconds);
        let stroke = |_| {
            simulator.step(&mut |_| {});
            simulator.machine().states().map(|state| state.length)
        };
        cycles.map(stroke).collect()
    }

    /// Plays the machine for `watch` seconds under every policy; `faulty` has the cylinder's and the transducer's index.
    /// Until the first transducer is blamed all policies are one machine.
    fn played(
        &self,
        begun: Installation,
        faulty: Option<(usize, usize)>,
        drawn: Drawn,
        watch: f64,
        strokes: &Strokes,
    ) -> [Way; Policy::ALL.len()] {
        let mut all = vec![Followed { installation: begun, way: Way::default() }];
        for (cycle, strokes) in (0..self.cycles(watch + AFTER)).zip(strokes) {
            // At the end of the cycle, in which the first faulty reading may already have been.
            let age = (cycle + 1) as f64 * self.settings.machine.sample_time - drawn.at;
            let is_one = all.len() == 1;
            let mut parted = Vec::new();
            for it in &mut all {
                let end = it.way.black.map_or(watch - drawn.at, |black| black + AFTER);
                if age > end {
                    continue;
                }
                let blamed = it.step(faulty, age, strokes);
                if is_one && !blamed.is_empty() {
                    parted.extend(Policy::ALL[1..].iter().map(|policy| it.with(*policy)));
                    parted.iter_mut().for_each(|it| it.installation.act(&blamed));
                }
                it.installation.act(&blamed);
            }
            all.append(&mut parted);
        }
        std::array::from_fn(|policy| all.get(policy).unwrap_or(&all[0]).result(drawn.leg))
    }
}

impl Followed {
    /// Plays a cycle that ends `age` seconds after the fault of `faulty` began, with the healthy machine's `strokes`, m: who is
    /// blamed in it.
    fn step(
        &mut self,
        faulty: Option<(usize, usize)>,
        age: f64,
        strokes: &[f64; CYLINDERS],
    ) -> Vec<Blamed> {
        let blamed = self.installation.step();
        for it in &blamed {
            if faulty == Some((it.leg, it.which)) && age >= 0.0 {
                self.way.blamed.get_or_insert(age);
            } else {
                self.way.wrong.get_or_insert(it.detector);
            }
        }
        if age >= 0.0 {
            self.installation.follow(strokes);
        }
        if self.installation.simulator.is_black() {
            self.way.black.get_or_insert(age);
        }
        blamed
    }

    /// The same under another policy.
    fn with(&self, policy: Policy) -> Self {
        Self { installation: self.installation.with(policy), way: self.way }
    }

    fn result(&self, leg: usize) -> Way {
        let Motion { rods, tip } = self.installation.motion;
        Way { rod: rods[leg], tip, ..self.way }
    }
}

/// `shape`, towards the other side where `sign` is −1.
fn signed(shape: Shape, sign: f64) -> Shape {
    match shape {
        Shape::Step { size } => Shape::Step { size: sign * size },
        Shape::Drift { rate } => Shape::Drift { rate: sign * rate },
        Shape::Scale { gain } => Shape::Scale { gain: sign * gain },
        Shape::Incipient { size, b } => Shape::Incipient { size: sign * size, b },
        other => other,
    }
}
