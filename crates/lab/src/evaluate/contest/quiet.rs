//! Fault-free hours: how large the values of every rival get.

use super::ladder::{LEVELS, Rival};
use super::trial::values;
use crate::evaluate::learning::Learnt;
use crate::evaluate::outcome::DETECTORS;
use crate::evaluate::stand::{Stand, StandError};
use tertius_core::alarm::{State, Warning};
use tertius_core::monitor::{Monitor, Record, Sink};
use tertius_core::sequential::Sequential;
use tertius_core::verdict::Verdict;
use tertius_machine::plant::CYLINDERS;
use tertius_machine::simulator::Options;

/// How long one machine is watched, s.
pub const STRETCH: f64 = 3600.0;

/// Judged time of which only the largest value counts, s, so that a longer excursion is one event.
pub const BLOCK: f64 = 10.0;

const RIVALS: usize = Rival::ALL.len();

/// What the detectors saw of one healthy machine.
#[derive(Clone, Debug, PartialEq)]
pub struct QuietHours {
    /// Warnings of each detector.
    pub raises: [u64; DETECTORS],
    /// Cycles of cylinders that the sequential detectors judged.
    pub samples: u64,
    /// Σ r² of their residuals, in 1e-15 m²: an integer, so that sums do not depend on their order.
    pub squares: u128,
    /// The largest value of each block, by rival and cylinder.
    pub blocks: Vec<[Vec<f64>; RIVALS]>,
    /// Blocks beyond each level.
    pub beyond: [[u64; LEVELS]; RIVALS],
}

/// Largest value of a block that is not yet full.
#[derive(Clone, Copy, Default)]
struct Open {
    largest: f64,
    cycles: u64,
}

struct Watching {
    quiet: QuietHours,
    open: [[Open; RIVALS]; CYLINDERS],
    block: u64,
    records: Vec<Record>,
}

impl Sink for Watching {
    fn warning(&mut self, warning: &Warning) {
        let raised = warning.state == State::Raised;
        self.quiet.raises[warning.detector as usize - 1] += u64::from(raised);
    }

    fn record(&mut self, record: &Record) {
        self.records.push(*record);
    }
}

impl Watching {
    /// Takes the records of a cycle, with the detectors that made them.
    fn judge(&mut self, monitor: &Monitor) {
        let mut records = std::mem::take(&mut self.records);
        for record in records.drain(..) {
            let found = monitor.sequential().find(|(number, _)| *number == record.cylinder);
            let Some((_, detector)) = found else { continue };
            self.take(&record, detector);
        }
        self.records = records;
    }

    fn take(&mut self, record: &Record, detector: &Sequential) {
        let cylinder = usize::from(record.cylinder) - 1;
        for (rival, value) in values(record, detector).into_iter().enumerate() {
            let Some(value) = value else { continue };
            let open = &mut self.open[cylinder][rival];
            open.largest = open.largest.max(value);
            open.cycles += 1;
            if open.cycles == self.block {
                let Open { largest, .. } = std::mem::take(open);
                self.quiet.close(cylinder, rival, largest);
            }
        }
        if detector.verdict() == Verdict::Healthy
            && let Some(residual) = detector.residual()
        {
            self.quiet.squares += (residual * residual * 1e15).round() as u128;
            self.quiet.samples += 1;
        }
    }
}

impl QuietHours {
    fn new() -> Self {
        Self {
            raises: [0; DETECTORS],
            squares: 0,
            samples: 0,
            blocks: vec![Default::default(); CYLINDERS],
            beyond: [[0; LEVELS]; RIVALS],
        }
    }

    fn close(&mut self, cylinder: usize, rival: usize, largest: f64) {
        self.blocks[cylinder][rival].push(largest);
        for (index, beyond) in self.beyond[rival].iter_mut().enumerate() {
            *beyond += u64::from(largest > Rival::ALL[rival].level(index));
        }
    }
}

impl Stand<'_> {
    /// Watches the healthy machine of `seed` in `sea` for a stretch of its time.
    ///
    /// # Errors
    /// If there is no such machine.
    pub fn quiet(
        &self,
        learnt: &Learnt,
        sea: [f64; 2],
        seed: u64,
    ) -> Result<QuietHours, StandError> {
        let options = Options { seed, sea: Some(sea), ..Options::default() };
        let mut simulator = self.steady(learnt.grade, &options)?;
        let mut monitor = Monitor::new(learnt.design.clone());
        let mut watching = Watching {
            quiet: QuietHours::new(),
            open: Default::default(),
            block: self.cycles(BLOCK),
            records: Vec::new(),
        };
        for _ in 0..self.cycles(STRETCH) {
            simulator.step(&mut |frame| monitor.take(frame, &mut watching));
            watching.judge(&monitor);
        }
        monitor.finish(&mut watching);
        Ok(watching.quiet)
    }
}
