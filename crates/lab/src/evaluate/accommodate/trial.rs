//! One machine, watched with accommodation and without.

use super::cases::AccommodateCase;
use crate::evaluate::grade::Grade;
use crate::evaluate::stand::{Stand, StandError};
use crate::evaluate::tried::signed;
use crate::evaluate::truth::{Truth, WRONG};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use tertius_config::design;
use tertius_core::estimate::Estimate;
use tertius_core::monitor::{Estimates, Monitor, MonitorDesign, Sink};
use tertius_core::time::{Span, Timestamp};
use tertius_machine::inject::{Fault, Placed, Shape, Wanted, Window, place};
use tertius_machine::simulator::{Options, Simulator};

/// Time before anything happens, s: the accuracy of the model has to be measured first.
const LEAD: f64 = 60.0;

/// Time within which the first faults begin after that, s.
const SPREAD: f64 = 5.0;

/// Time from the first fault to the loss of the other transducer, s: longer than a step has to stand still.
const APART: f64 = 90.0;

/// Time from the loss to the second fault, s.
const ALONE: f64 = 20.0;

/// Span within which the losses and the second faults begin, s: a cylinder is not lost with all others.
const JITTER: f64 = 1.0;

/// How long the estimate is watched from the loss on, s.
const WATCH: f64 = 60.0;

/// `estimate.accommodate_after` where the configuration has none, s.
const AFTER: f64 = 60.0;

/// What is drawn of a cylinder. Times count from the end of [`LEAD`], s.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Leg {
    cylinder: u8,
    /// The transducer that is left, and the one that is lost.
    sensors: [&'static str; 2],
    /// Of the first fault, the loss and the second fault.
    times: [f64; 3],
    /// Signs of the two faults.
    signs: [f64; 2],
}

/// What is drawn of a machine.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Drawn {
    seed: u64,
    sea: [f64; 2],
    legs: Vec<Leg>,
}

impl Drawn {
    /// Draws machine `number`, of so many `cylinders`, in this `sea`.
    pub fn new(number: u32, cylinders: u8, sea: [f64; 2], rng: &mut ChaCha8Rng) -> Self {
        let seed = rng.random();
        let legs = (1..=cylinders).map(|cylinder| {
            let sensors = if rng.random::<bool>() { ["c1", "c2"] } else { ["c2", "c1"] };
            let first = SPREAD * rng.random::<f64>();
            let lost = first + APART + JITTER * rng.random::<f64>();
            let second = lost + ALONE + JITTER * rng.random::<f64>();
            let signs = [(); 2].map(|()| if rng.random::<bool>() { 1.0 } else { -1.0 });
            Leg { cylinder, sensors, times: [first, lost, second], signs }
        });
        let mut legs: Vec<Leg> = legs.collect();
        // What most cylinders show at once is put down to something that they share.
        legs.retain(|leg| cylinders == 1 || (u32::from(leg.cylinder) + number).is_multiple_of(2));
        Self { seed, sea, legs }
    }
}

/// The estimates of one cylinder from the loss of its other transducer on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AccommodateOutcome {
    pub cycles: u64,
    /// Sizes of the errors of valid estimates, m.
    pub errors: Vec<f32>,
    /// Cycles in which the estimate was valid and off by more than three of its standard deviations.
    pub wrong: u64,
}

/// What became of a machine: by case, of each cylinder with a fault, without accommodation and with it.
pub type AccommodateOutcomes = Vec<Vec<[AccommodateOutcome; 2]>>;

/// Compares the estimates with the truth.
#[derive(Clone)]
struct Watcher {
    truth: Truth,
    /// Of each cylinder with faults: when it is watched.
    windows: Vec<(u8, [Timestamp; 2])>,
    outcomes: Vec<AccommodateOutcome>,
}

impl Sink for Watcher {
    fn wants_records(&self) -> bool {
        false
    }

    fn estimate(&mut self, at: Timestamp, cylinder: u8, estimate: Option<&Estimate>) {
        let Some(index) = self.windows.iter().position(|it| it.0 == cylinder) else { return };
        let Some((opening, truth)) = self.truth.of(at, cylinder) else { return };
        let [from, until] = self.windows[index].1;
        if opening < from || opening >= until {
            return;
        }
        let outcome = &mut self.outcomes[index];
        outcome.cycles += 1;
        if let Some(estimate) = estimate.filter(|estimate| estimate.valid) {
            let error = (estimate.position - truth).abs();
            outcome.errors.push(error as f32);
            outcome.wrong += u64::from(error > WRONG * estimate.sigma);
        }
    }
}

/// A machine at work, and its monitors.
#[derive(Clone)]
struct Running {
    simulator: Simulator,
    monitors: [(Monitor, Watcher); 2],
}

impl Running {
    fn step(&mut self) {
        let Self { simulator, monitors } = self;
        for (_, watcher) in &mut *monitors {
            watcher.truth.note(simulator);
        }
        simulator.step(&mut |frame| {
            for (monitor, watcher) in &mut *monitors {
                monitor.take(frame, watcher);
            }
        });
    }
}

impl Stand<'_> {
    /// The monitor without accommodation, and with it.
    fn accommodating(&self) -> [MonitorDesign; 2] {
        let after = self.settings.estimate.accommodate_after.unwrap_or(AFTER);
        [None, Some(design::accommodation(self.settings, after))].map(|accommodation| {
            let mut design =
                MonitorDesign { estimates: Estimates::Computed, ..self.design.clone() };
            for cylinder in &mut design.cylinders {
                cylinder.estimate.accommodation = accommodation;
            }
            design
        })
    }

    /// Plays the machine of `drawn` with each of `cases`: of each cylinder with faults, what became of its estimate
    /// without accommodation and with it.
    pub(super) fn accommodated(
        &self,
        grade: Grade,
        cases: &[AccommodateCase],
        drawn: &Drawn,
    ) -> Result<AccommodateOutcomes, StandError> {
        let options = Options { seed: drawn.seed, sea: Some(drawn.sea), ..Options::default() };
        let simulator = self.graded(grade, &options)?;
        let monitors = self.accommodating().map(|design| {
            let truth = Truth::new(&simulator, self.settings.machine.sample_time);
            let outcomes = vec![AccommodateOutcome::default(); drawn.legs.len()];
            let watcher = Watcher { truth, windows: Vec::new(), outcomes };
            (Monitor::new(design), watcher)
        });
        let mut ready = Running { simulator, monitors };
        for _ in 0..self.cycles(LEAD) {
            ready.step();
        }
        let begun = ready.simulator.opening();
        let window = |leg: &Leg| {
            let [_, lost, _] = leg.times;
            let ends = [lost, lost + WATCH].map(|at| begun.after(Span::from_seconds(at)));
            (leg.cylinder, ends)
        };
        for (_, watcher) in &mut ready.monitors {
            watcher.windows = drawn.legs.iter().map(window).collect();
        }
        cases.iter().map(|case| self.left_alone_after(case, ready.clone(), drawn)).collect()
    }

    fn left_alone_after(
        &self,
        case: &AccommodateCase,
        mut running: Running,
        drawn: &Drawn,
    ) -> Result<Vec<[AccommodateOutcome; 2]>, StandError> {
        let mut faults = Vec::new();
        for leg in &drawn.legs {
            let [own, other] = leg.sensors;
            let [first, lost, second] = leg.times;
            faults.push(self.placed_on(leg, own, (case.first, leg.signs[0]), first)?);
            faults.push(self.placed_on(
                leg,
                other,
                (Shape::Loss { probability: 1.0 }, 1.0),
                lost,
            )?);
            if let Some(shape) = case.second {
                faults.push(self.placed_on(leg, own, (shape, leg.signs[1]), second)?);
            }
        }
        running.simulator.afflict(&faults, drawn.seed);
        for _ in 0..self.cycles(SPREAD + APART + JITTER + WATCH + 1.0) {
            running.step();
        }
        let [without, with] = running.monitors.map(|(_, watcher)| watcher.outcomes);
        Ok(without.into_iter().zip(with).map(<[_; 2]>::from).collect())
    }

    fn placed_on(
        &self,
        leg: &Leg,
        sensor: &'static str,
        (shape, sign): (Shape, f64),
        at: f64,
    ) -> Result<Placed, StandError> {
        let window = Window { from: Span::from_seconds(at), until: None };
        let wanted = signed(Wanted::Shape(shape), sign);
        let fault = Fault { cylinder: leg.cylinder, sensor, wanted, window };
        Ok(place(&fault, self.settings, self.database)?)
    }
}
