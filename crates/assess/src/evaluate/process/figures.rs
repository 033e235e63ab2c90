//! Figures of the process detectors.

use super::cases::{CASES, ProcessCase};
use super::trial::ProcessOutcome;
use super::{ProcessJob, ProcessMachine, ProcessProduct, ProcessStudy, STRETCH};
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

/// Collects the results of the jobs, in any order.
#[derive(Clone, Debug)]
pub struct ProcessGathering<'a> {
    study: &'a ProcessStudy,
    faulty: BTreeMap<(usize, usize, u32), Vec<ProcessOutcome>>,
    /// Stretches, and false alarms in them.
    quiet: BTreeMap<usize, [u64; 2]>,
}

impl<'a> ProcessGathering<'a> {
    pub const fn new(study: &'a ProcessStudy) -> Self {
        Self { study, faulty: BTreeMap::new(), quiet: BTreeMap::new() }
    }

    /// Takes the result of a job; each job once.
    pub fn take(&mut self, job: ProcessJob, product: ProcessProduct) {
        match (job, product) {
            (ProcessJob::Faulty { machine, case, number }, ProcessProduct::Faulty(outcomes)) => {
                self.faulty.insert((machine, case, number), outcomes);
            }
            (ProcessJob::Quiet { machine, .. }, ProcessProduct::Quiet(quiet)) => {
                let [stretches, raises] = self.quiet.entry(machine).or_default();
                *stretches += 1;
                *raises += quiet.raises;
            }
            // A job brings what it is.
            (ProcessJob::Faulty { .. } | ProcessJob::Quiet { .. }, _) => {}
        }
    }

    /// The figures of every fault on every machine.
    pub fn finish(&self) -> ProcessResult {
        let machines = || self.study.machines.iter().enumerate();
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
            delay: percentiles(delays, 0.5),
            kind: case
                .expected
                .map(|expected| Proportion::counting(&found, |it| it.kind == Some(expected))),
            size: percentiles(ratios, 0.5)
                .zip(percentiles(off, 0.5))
                .map(|(of, off)| [of[0], off[1]]),
            blamed: [0, 1].map(|at| Proportion::counting(outcomes, |it| it.blamed[at])),
        }
    }
}

/// That part of `values`, and the 95th percentile.
pub fn percentiles(mut values: Vec<f64>, part: f64) -> Option<[f64; 2]> {
    values.sort_unstable_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    let at = |part: f64| values[((part * values.len() as f64) as usize).min(last)];
    Some([at(part), at(0.95)])
}
