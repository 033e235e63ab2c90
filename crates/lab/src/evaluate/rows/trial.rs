//! One simulated machine with its faults.

use super::row::Row;
use crate::evaluate::outcome::{IncidentOutcome, Outcome};
use crate::evaluate::stand::{Stand, StandError};
use crate::evaluate::tried::{TriedFault, Try};
use tertius_core::alarm::Warning;
use tertius_core::incident::Incident;
use tertius_core::monitor::{Monitor, Record, Sink};
use tertius_core::time::{Span, Timestamp};
use tertius_machine::plant::CYLINDERS;
use tertius_machine::simulator::{Options, Simulator};

/// Time at the end of a watch in which C1 is compared with its twin's, s.
const AT_LAST: f64 = 1.0;

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
