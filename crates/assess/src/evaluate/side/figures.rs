//! Figures of the drifts in the loop.

use super::trial::SideOutcome;
use super::{CASES, STRETCH, SideCase, SideJob, SideProduct, SideStudy};
use crate::evaluate::process::{ProcessMachine, percentiles};
use crate::evaluate::proportion::Proportion;
use crate::evaluate::rate::Rate;
use serde::Serialize;
use std::collections::BTreeMap;

/// The result of the study.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SideResult {
    pub drifts: Vec<SideFigures>,
    pub healthy: Vec<SideHealthy>,
}

/// One drift on one machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SideFigures {
    pub grade: &'static str,
    /// Time constant of the spool, s.
    pub lag: f64,
    pub transducer: &'static str,
    /// m/s.
    pub rate: f64,
    /// Drifts of which the right transducer was named before [`super::IN_TIME`].
    pub named: Proportion,
    /// Median and 95th percentile of how far they had drifted then, m.
    pub at: Option<[f64; 2]>,
    /// The same when they were found.
    pub found_at: Option<[f64; 2]>,
    /// Drifts of which the innocent one was ever named by the sequential detector, and by any.
    pub wrong: [Proportion; 2],
    /// Drifts that were taken for a fault of the process.
    pub process: Proportion,
}

/// Healthy hours on one machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SideHealthy {
    pub grade: &'static str,
    pub lag: f64,
    pub hours: f64,
    /// Warnings of the sequential and process detectors, and those of the former that named a transducer.
    pub false_alarms: Rate,
    pub named: Rate,
}

/// Collects the results of the jobs, in any order.
#[derive(Clone, Debug)]
pub struct SideGathering<'a> {
    study: &'a SideStudy,
    drifts: BTreeMap<(usize, usize, u32), Vec<SideOutcome>>,
    /// Stretches, false alarms in them, and those that named a transducer.
    quiet: BTreeMap<usize, [u64; 3]>,
}

impl<'a> SideGathering<'a> {
    pub const fn new(study: &'a SideStudy) -> Self {
        Self { study, drifts: BTreeMap::new(), quiet: BTreeMap::new() }
    }

    /// Takes the result of a job; each job once.
    pub fn take(&mut self, job: SideJob, product: SideProduct) {
        match (job, product) {
            (SideJob::Drift { machine, case, number }, SideProduct::Drift(outcomes)) => {
                self.drifts.insert((machine, case, number), outcomes);
            }
            (SideJob::Quiet { machine, .. }, SideProduct::Quiet(quiet)) => {
                let [stretches, raises, named] = self.quiet.entry(machine).or_default();
                *stretches += 1;
                *raises += quiet.raises;
                *named += quiet.named;
            }
            // A job brings what it is.
            (SideJob::Drift { .. } | SideJob::Quiet { .. }, _) => {}
        }
    }

    /// The figures of every drift on every machine.
    pub fn finish(&self) -> SideResult {
        let machines = || self.study.machines.iter().enumerate();
        let drifts = machines().flat_map(|(index, machine)| {
            CASES.iter().enumerate().filter_map(move |(number, case)| {
                let own =
                    self.drifts.iter().filter(|((of, at, _), _)| (*of, *at) == (index, number));
                let outcomes = own.flat_map(|(_, outcomes)| outcomes).filter(|it| !it.spoilt);
                let outcomes: Vec<SideOutcome> = outcomes.copied().collect();
                (!outcomes.is_empty()).then(|| SideFigures::of(machine, case, &outcomes))
            })
        });
        let healthy = machines().filter_map(|(index, machine)| {
            let [stretches, raises, named] = self.quiet.get(&index)?;
            let hours = *stretches as f64 * STRETCH / 3600.0;
            Some(SideHealthy {
                grade: machine.grade.name(),
                lag: machine.lag,
                hours,
                false_alarms: Rate::new(*raises, hours),
                named: Rate::new(*named, hours),
            })
        });
        SideResult { drifts: drifts.collect(), healthy: healthy.collect() }
    }
}

impl SideFigures {
    fn of(machine: &ProcessMachine, case: &SideCase, outcomes: &[SideOutcome]) -> Self {
        let of = |value: fn(&SideOutcome) -> Option<f64>| {
            percentiles(outcomes.iter().filter_map(value).collect(), 0.5)
        };
        Self {
            grade: machine.grade.name(),
            lag: machine.lag,
            transducer: case.transducer.name(),
            rate: case.rate,
            named: Proportion::counting(outcomes, |it| it.named.is_some()),
            at: of(|it| it.named),
            found_at: of(|it| it.found),
            wrong: [0, 1].map(|at| Proportion::counting(outcomes, |it| it.wrong[at])),
            process: Proportion::counting(outcomes, |it| it.process),
        }
    }
}
