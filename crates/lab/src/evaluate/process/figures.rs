//! Figures of the process detectors.

use super::cases::{CASES, ProcessCase, STRETCH};
use super::trial::{ProcessOutcome, ProcessQuiet};
use crate::evaluate::figures::quantiles;
use crate::evaluate::machines::ProcessMachine;
use crate::evaluate::proportion::Proportion;
use crate::evaluate::rate::Rate;
use serde::Serialize;
use std::collections::BTreeMap;

/// The result of the study.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ProcessResult {
    pub faults: Vec<ProcessFigures>,
    pub healthy: Vec<ProcessHealthy>,
}

/// One fault on one machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProcessFigures {
    pub grade: &'static str,
    /// Time constant of the spool, s.
    pub lag: f64,
    pub label: &'static str,
    /// Faults of which the process detector warned.
    pub found: Proportion,
    /// Median and 95th percentile of the delays, s.
    pub delay: Option<[f64; 2]>,
    /// Found ones that were called what they are; `None` for those that are none of the process.
    pub kind: Option<Proportion>,
    /// Median of the sizes as told over the true ones, and the 95th percentile of how far they are from 1.
    pub size: Option<[f64; 2]>,
    /// Faults of which a warning named a transducer, and of which one still did when it was said last.
    pub blamed: [Proportion; 2],
}

/// Healthy hours on one machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProcessHealthy {
    pub grade: &'static str,
    pub lag: f64,
    pub hours: f64,
    pub false_alarms: Rate,
}

/// What became of a trial.
#[derive(Clone, Debug, PartialEq)]
pub enum ProcessProduct {
    /// The fault of that index of [`CASES`] on the machine of that index.
    Faulty {
        machine: usize,
        case: usize,
        number: u32,
        outcomes: Vec<ProcessOutcome>,
    },
    Quiet {
        machine: usize,
        quiet: ProcessQuiet,
    },
}

/// Products so far.
#[derive(Clone, Debug, Default)]
pub struct ProcessGathered {
    faulty: BTreeMap<(usize, usize, u32), Vec<ProcessOutcome>>,
    /// Stretches, and false alarms in them.
    quiet: BTreeMap<usize, [u64; 2]>,
}

impl ProcessGathered {
    pub(super) fn add(&mut self, product: ProcessProduct) {
        match product {
            ProcessProduct::Faulty { machine, case, number, outcomes } => {
                self.faulty.insert((machine, case, number), outcomes);
            }
            ProcessProduct::Quiet { machine, quiet } => {
                let [stretches, raises] = self.quiet.entry(machine).or_default();
                *stretches += 1;
                *raises += quiet.raises;
            }
        }
    }

    /// The figures of every fault on every one of `machines`.
    pub(super) fn result(&self, machines: &[ProcessMachine]) -> ProcessResult {
        let machines = || machines.iter().enumerate();
        let faults = machines().flat_map(|(index, machine)| {
            CASES.iter().enumerate().filter_map(move |(number, case)| {
                let own =
                    self.faulty.iter().filter(|((of, at, _), _)| (*of, *at) == (index, number));
                let outcomes = own.flat_map(|(_, outcomes)| outcomes).filter(|it| !it.spoilt);
                let outcomes: Vec<ProcessOutcome> = outcomes.copied().collect();
                (!outcomes.is_empty()).then(|| ProcessFigures::of(machine, case, &outcomes))
            })
        });
        let healthy = machines().filter_map(|(index, machine)| {
            let [stretches, raises] = self.quiet.get(&index)?;
            let hours = *stretches as f64 * STRETCH / 3600.0;
            let false_alarms = Rate::new(*raises, hours);
            let (grade, lag) = (machine.grade.name(), machine.lag);
            Some(ProcessHealthy { grade, lag, hours, false_alarms })
        });
        ProcessResult { faults: faults.collect(), healthy: healthy.collect() }
    }
}

impl ProcessFigures {
    fn of(machine: &ProcessMachine, case: &ProcessCase, outcomes: &[ProcessOutcome]) -> Self {
        let delays = outcomes.iter().filter_map(|it| it.delay).collect();
        let ratios: Vec<f64> = outcomes.iter().filter_map(|it| it.size).collect();
        let off = ratios.iter().map(|ratio| (ratio - 1.0).abs()).collect();
        let found: Vec<ProcessOutcome> =
            outcomes.iter().filter(|it| it.delay.is_some()).copied().collect();
        Self {
            grade: machine.grade.name(),
            lag: machine.lag,
            label: case.label,
            found: Proportion::counting(outcomes, |it| it.delay.is_some()),
            delay: quantiles(delays, [0.5, 0.95]),
            kind: case
                .expected
                .map(|expected| Proportion::counting(&found, |it| it.kind == Some(expected))),
            size: quantiles(ratios, [0.5, 0.95])
                .zip(quantiles(off, [0.5, 0.95]))
                .map(|(of, off)| [of[0], off[1]]),
            blamed: [0, 1].map(|at| Proportion::counting(outcomes, |it| it.blamed[at])),
        }
    }
}
