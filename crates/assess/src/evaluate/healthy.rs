//! A machine with nothing wrong: every warning is false.

use super::outcome::DETECTORS;
use super::plan::Cell;
use super::stand::{Stand, StandError};
use std::collections::BTreeMap;
use tertius_core::alarm::{State, Warning};
use tertius_core::monitor::{Monitor, Record, Sink};
use tertius_machine::simulator::Options;

/// How long one healthy machine is watched, s.
pub const STRETCH: f64 = 600.0;

/// Warnings on healthy machines, all cylinders together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Healthy {
    /// Warnings on cylinders on which none stood.
    pub events: u64,
    /// Warnings of each detector, in the order of [`tertius_core::alarm::Detector::ALL`].
    pub raises: [u64; DETECTORS],
    /// Warnings by the name of the fault.
    pub faults: BTreeMap<&'static str, u64>,
    /// Number of R1, R2 and R3 that were judged.
    pub judged: [u64; 3],
    /// Number of R1, R2 and R3 beyond δ_h, or beyond the bound of R3.
    pub beyond: [u64; 3],
    /// Largest |R1|, |R2| and |R3|, m.
    pub largest: [f64; 3],
    standing: [u32; CYLINDERS],
    limits: [f64; 3],
}

const CYLINDERS: usize = tertius_machine::plant::CYLINDERS;

impl Stand<'_> {
    /// Watches the healthy machine of `seed` for a stretch of its time.
    ///
    /// # Errors
    /// If there is no such machine.
    pub fn healthy(&self, cell: Cell, seed: u64) -> Result<Healthy, StandError> {
        let options = Options { seed, sea: Some(cell.sea), ..Options::default() };
        let mut simulator = self.simulator(cell, &options)?;
        let mut monitor = Monitor::new(self.design.clone());
        let settings = self.settings;
        let limits = [settings.fde.high, settings.fde.high, settings.comparator.bound];
        let mut healthy = Healthy { limits, ..Healthy::default() };
        for _ in 0..self.cycles(STRETCH) {
            simulator.step(&mut |frame| monitor.take(frame, &mut healthy));
        }
        monitor.finish(&mut healthy);
        Ok(healthy)
    }
}

impl Healthy {
    /// Adds the figures of another machine.
    pub fn add(&mut self, other: &Self) {
        self.events += other.events;
        for (mine, more) in self.raises.iter_mut().zip(other.raises) {
            *mine += more;
        }
        for (name, more) in &other.faults {
            *self.faults.entry(name).or_default() += more;
        }
        for i in 0..3 {
            self.judged[i] += other.judged[i];
            self.beyond[i] += other.beyond[i];
            self.largest[i] = self.largest[i].max(other.largest[i]);
        }
    }

    /// Hours of one machine of so many `cylinders`, by what its observers judged.
    pub fn hours(&self, cylinders: u8, sample_time: f64) -> f64 {
        self.judged[0] as f64 / f64::from(cylinders) * sample_time / 3600.0
    }
}

impl Sink for Healthy {
    fn warning(&mut self, warning: &Warning) {
        let standing = &mut self.standing[usize::from(warning.cylinder) - 1];
        match warning.state {
            State::Raised => {
                self.events += u64::from(*standing == 0);
                *standing += 1;
                self.raises[warning.detector as usize - 1] += 1;
                *self.faults.entry(warning.finding.fault.name()).or_default() += 1;
            }
            State::Changed => {}
            State::Cleared => *standing = standing.saturating_sub(1),
        }
    }

    fn record(&mut self, record: &Record) {
        if record.gated {
            return;
        }
        for (i, residual) in record.residuals.into_iter().enumerate() {
            let Some(magnitude) = residual.map(f64::abs) else { continue };
            self.judged[i] += 1;
            self.beyond[i] += u64::from(magnitude > self.limits[i]);
            self.largest[i] = self.largest[i].max(magnitude);
        }
    }
}
