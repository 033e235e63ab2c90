//! A machine with nothing wrong: every warning is false.

use super::extent::{Extent, StudyName};
use super::grade::Cell;
use super::outcome::DETECTORS;
use super::proportion::Proportion;
use super::random::random;
use super::rate::Rate;
use super::stand::{Stand, StandError};
use super::study::Study;
use rand::RngExt;
use serde::Serialize;
use std::collections::BTreeMap;
use tertius_core::alarm::{Detector, State, Warning};
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

/// Figures of healthy machines of one cell.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HealthyCell {
    pub grade: &'static str,
    pub sea: [f64; 2],
    /// Hours of a machine that were judged.
    pub hours: f64,
    /// Warnings on cylinders on which none stood: what a person counts as one false alarm.
    pub false_alarms: Rate,
    pub detectors: BTreeMap<&'static str, Rate>,
    /// Number of warnings by the name of the fault.
    pub faults: BTreeMap<&'static str, u64>,
    /// R1, R2 and R3 within δ_h, or within R3's bound.
    pub within: [Proportion; 3],
    /// Largest residuals, m.
    pub largest: [f64; 3],
}

impl HealthyCell {
    fn new(cell: Cell, healthy: &Healthy, (cylinders, sample_time): (u8, f64)) -> Self {
        let hours = healthy.hours(cylinders, sample_time);
        let within = |i: usize| {
            let (judged, beyond) = (healthy.judged[i], healthy.beyond[i]);
            Proportion::new(judged - beyond, judged)
        };
        let by_detector = Detector::ALL.into_iter().zip(healthy.raises);
        Self {
            grade: cell.grade.name(),
            sea: cell.sea,
            hours,
            false_alarms: Rate::new(healthy.events, hours),
            detectors: by_detector
                .map(|(it, raises)| (it.name(), Rate::new(raises, hours)))
                .collect(),
            faults: healthy.faults.clone(),
            within: std::array::from_fn(within),
            largest: healthy.largest,
        }
    }
}

/// First stream of healthy machines, above every stream of a row.
const STREAMS: u64 = 1 << 62;
const NUMBERS: u64 = 1 << 21;

/// The study of what is found by chance, in many hours.
const HEALTHY: StudyName = StudyName::quick("healthy", "False alarms");

/// Hours of healthy machines.
#[derive(Clone, Debug, PartialEq)]
pub struct HealthyStudy {
    pub cells: Vec<Cell>,
    /// Hours in each cell, rounded up to whole stretches.
    pub hours: f64,
    pub seed: u64,
    /// Number of cylinders that are monitored.
    pub cylinders: u8,
}

/// A stretch of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HealthyJob {
    pub cell: usize,
    pub number: u32,
}

impl Study for HealthyStudy {
    const NAMES: &'static [StudyName] = &[HEALTHY];
    type Job = HealthyJob;
    type Taught = ();
    /// The index of the cell, and what was seen of the machine.
    type Product = (usize, Box<Healthy>);
    type Gathered = BTreeMap<usize, Healthy>;
    type Figures = Vec<HealthyCell>;

    /// An empty list of hours stands in the result, too.
    fn planned(seed: u64, extent: &Extent) -> Option<Self> {
        let hours = if extent.asks(HEALTHY) { extent.hours } else { 0.0 };
        Some(Self { cells: extent.cells(), hours, seed, cylinders: extent.cylinders })
    }

    fn teach(&self, _: &Stand, _: usize) -> Result<(), StandError> {
        Ok(())
    }

    fn jobs(&self) -> Vec<HealthyJob> {
        let stretches = (self.hours * 3600.0 / STRETCH).ceil() as u32;
        let of_cell = |cell| (0..stretches).map(move |number| HealthyJob { cell, number });
        (0..self.cells.len()).flat_map(of_cell).collect()
    }

    fn run(&self, stand: &Stand, _: &[()], job: HealthyJob) -> Result<Self::Product, StandError> {
        let HealthyJob { cell, number } = job;
        let stream = STREAMS + cell as u64 * NUMBERS + u64::from(number);
        let seed = random(self.seed, stream).random();
        Ok((cell, Box::new(stand.healthy(self.cells[cell], seed)?)))
    }

    fn gather(&self, _: &Stand, gathered: &mut Self::Gathered, (cell, more): Self::Product) {
        gathered.entry(cell).or_default().add(&more);
    }

    fn figures(&self, stand: &Stand, _: &[()], gathered: Self::Gathered) -> Vec<HealthyCell> {
        let scale = (self.cylinders, stand.settings.machine.sample_time);
        let judged = gathered.iter().filter(|(_, healthy)| healthy.judged[0] > 0);
        judged.map(|(cell, healthy)| HealthyCell::new(self.cells[*cell], healthy, scale)).collect()
    }
}
