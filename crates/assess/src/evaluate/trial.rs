//! One simulated machine with its faults.

use super::outcome::{IncidentOutcome, Outcome};
use super::row::Row;
use super::stand::{Stand, StandError};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use tertius_core::alarm::Warning;
use tertius_core::incident::Incident;
use tertius_core::monitor::{Monitor, Record, Sink};
use tertius_core::time::{Span, Timestamp};
use tertius_core::verdict::Suspect;
use tertius_machine::inject::{Fault, Placed, Shape, Wanted, Window, place};
use tertius_machine::plant::CYLINDERS;
use tertius_machine::simulator::{Options, Simulator};

/// Time from when the observers have settled until the earliest fault, s.
const LEAD: f64 = 3.0;

/// Span of time within which all faults begin, s.
const SPREAD: f64 = 1.0;

/// Time at the end of a watch in which C1 is compared with its twin's, s.
const AT_LAST: f64 = 1.0;

/// A fault that is tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriedFault {
    /// Cylinder number, counted from 1.
    pub cylinder: u8,
    /// The faulty transducer, C1 or C2.
    pub transducer: Suspect,
    /// The fault with its sign; `None`: nothing happens.
    pub wanted: Option<Wanted>,
    /// Time of the fault after the first frame, s.
    pub at: f64,
}

/// A machine and its faults.
#[derive(Clone, Debug, PartialEq)]
pub struct Try {
    pub seed: u64,
    pub faults: Vec<TriedFault>,
}

impl Try {
    /// Draws a trial of `row` on a machine of so many `cylinders` from `rng`; `settle` is how long the observers
    /// take to settle, s. Rows that differ only in kind and size draw the same trial.
    pub fn draw(row: &Row, number: u32, cylinders: u8, settle: f64, rng: &mut ChaCha8Rng) -> Self {
        let seed = rng.random();
        let alone = row.is_alone();
        let count = u32::from(cylinders);
        let chosen = (0..count).filter(|index| !alone || number % count == *index);
        let faults = chosen
            .map(|index| {
                let at = settle + LEAD + SPREAD * rng.random::<f64>();
                let second = rng.random::<bool>() && !alone;
                let sign = if rng.random::<bool>() { 1.0 } else { -1.0 };
                TriedFault {
                    cylinder: index as u8 + 1,
                    transducer: if second { Suspect::C2 } else { Suspect::C1 },
                    wanted: row.wanted.map(|wanted| signed(wanted, sign)),
                    at,
                }
            })
            .collect();
        Self { seed, faults }
    }
}

/// `wanted`, towards the other side where `sign` is −1.
pub(super) fn signed(wanted: Wanted, sign: f64) -> Wanted {
    let Wanted::Shape(shape) = wanted else { return wanted };
    Wanted::Shape(match shape {
        Shape::Step { size } => Shape::Step { size: sign * size },
        Shape::Incipient { size, b } => Shape::Incipient { size: sign * size, b },
        Shape::Drift { rate } => Shape::Drift { rate: sign * rate },
        Shape::Scale { gain } => Shape::Scale { gain: sign * gain },
        Shape::Spike { size, probability } => Shape::Spike { size: sign * size, probability },
        // Noise has no side, and what is gone neither.
        Shape::Noise { .. }
        | Shape::Freeze
        | Shape::Constant(_)
        | Shape::Stale
        | Shape::Loss { .. } => shape,
    })
}

/// Hears the monitor.
#[derive(Default)]
struct Listener {
    /// Warnings so far: at most a few in each cycle of a trial.
    warnings: Vec<Warning>,
    /// Reports of incidents so far.
    incidents: Vec<Incident>,
    /// Newest R1, R2, R3 of each cylinder, m.
    residuals: [[Option<f64>; 3]; CYLINDERS],
    /// Newest reading of C1 of each cylinder, m.
    c1: [Option<f64>; CYLINDERS],
}

impl Sink for Listener {
    fn warning(&mut self, warning: &Warning) {
        self.warnings.push(*warning);
    }

    fn incident(&mut self, incident: &Incident) {
        self.incidents.push(*incident);
    }

    fn record(&mut self, record: &Record) {
        let index = usize::from(record.cylinder) - 1;
        self.residuals[index] = record.residuals;
        self.c1[index] = record.c1;
    }
}

/// State of one fault beside its warnings.
#[derive(Clone, Copy, Default)]
struct Followed {
    /// The Sync at which the first faulty reading was sampled.
    onset: Option<Timestamp>,
    worst: [f64; 3],
    rod: f64,
    /// Sum of the squared differences of C1 from its twin's in the last second, m².
    squares: f64,
    /// Number of differences in `squares`.
    readings: u32,
}

impl Stand<'_> {
    /// Plays `one`, a trial of `row`, and returns an outcome for each of its faults, in their
    /// order.
    ///
    /// # Errors
    /// If there is no such machine, or no place for such a fault on it.
    pub fn trial(&self, row: &Row, one: &Try) -> Result<Vec<Outcome>, StandError> {
        let faults = self.placed(one)?;
        let (sea, in_loop) = (Some(row.cell.sea), row.in_loop);
        let healthy = Options { seed: one.seed, sea, in_loop, ..Options::default() };
        let mut twin = row.is_alone().then(|| self.simulator(row.cell, &healthy)).transpose()?;
        let mut simulator = self.simulator(row.cell, &Options { faults, ..healthy })?;
        let mut monitor = Monitor::new(self.design.clone());
        let mut listener = Listener::default();
        let mut followed = vec![Followed::default(); one.faults.len()];
        let watch = Span::from_seconds(row.watch);
        let begun = simulator.opening();
        let latest = one.faults.iter().map(|fault| fault.at).fold(0.0, f64::max);
        for _ in 0..self.cycles(latest + row.watch + AT_LAST) {
            let opening = simulator.opening();
            simulator.step(&mut |frame| monitor.take(frame, &mut listener));
            if let Some(twin) = &mut twin {
                twin.step(&mut |_| {});
            }
            for (index, (fault, followed)) in one.faults.iter().zip(&mut followed).enumerate() {
                let altered = match fault.wanted {
                    Some(_) => simulator.tallies()[index].altered > 0,
                    None => opening.since(begun).as_seconds() >= fault.at,
                };
                if altered {
                    followed.onset.get_or_insert(opening);
                }
                if followed.onset.is_some_and(|onset| opening.since(onset) <= watch) {
                    followed.residuals(&listener.residuals[usize::from(fault.cylinder) - 1]);
                    if let Some(twin) = &twin {
                        followed.twin(fault, &simulator, twin, &listener, opening, watch);
                    }
                }
            }
        }
        monitor.finish(&mut listener);
        let outcomes = one.faults.iter().zip(&followed);
        Ok(outcomes
            .map(|(fault, followed)| {
                let asked = begun.after(Span::from_seconds(fault.at));
                let onset = followed.onset.unwrap_or(asked);
                let (cylinder, end) = (fault.cylinder, onset.after(watch));
                let said =
                    Outcome::read(&listener.warnings, cylinder, fault.transducer, onset, end);
                let incidents = IncidentOutcome::read(
                    &listener.incidents,
                    cylinder,
                    fault.transducer,
                    onset,
                    end,
                );
                Outcome {
                    incidents,
                    worst: followed.worst,
                    rod: twin.as_ref().map(|_| followed.rod),
                    reading: twin.as_ref().map(|_| followed.reading()),
                    ..said
                }
            })
            .collect())
    }

    pub(super) fn placed(&self, one: &Try) -> Result<Vec<Placed>, StandError> {
        let wanted = one.faults.iter().filter_map(|tried| Some((tried, tried.wanted?)));
        let placed = wanted.map(|(tried, wanted)| {
            let window = Window { from: Span::from_seconds(tried.at), until: None };
            let (cylinder, sensor) = (tried.cylinder, tried.transducer.name());
            let fault = Fault { cylinder, sensor, wanted, window };
            Ok(place(&fault, self.settings, self.database)?)
        });
        placed.collect()
    }
}

impl Followed {
    fn residuals(&mut self, residuals: &[Option<f64>; 3]) {
        for (worst, residual) in self.worst.iter_mut().zip(residuals) {
            *worst = residual.map_or(*worst, |residual| worst.max(residual.abs()));
        }
    }

    /// Compares the machine with the same one without the fault.
    fn twin(
        &mut self,
        fault: &TriedFault,
        simulator: &Simulator,
        twin: &Simulator,
        listener: &Listener,
        opening: Timestamp,
        watch: Span,
    ) {
        let leg = usize::from(fault.cylinder) - 1;
        let length = |it: &Simulator| it.machine().states()[leg].length;
        self.rod = self.rod.max((length(simulator) - length(twin)).abs());
        let age = self.onset.map_or(0.0, |onset| opening.since(onset).as_seconds());
        if age <= watch.as_seconds() - AT_LAST {
            return;
        }
        if let Some(c1) = listener.c1[leg] {
            self.squares += (c1 - twin.readings().lengths[leg]).powi(2);
            self.readings += 1;
        }
    }

    fn reading(&self) -> f64 {
        (self.squares / f64::from(self.readings.max(1))).sqrt()
    }
}
