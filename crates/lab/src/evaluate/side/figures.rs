//! Figures of the drifts in the loop.

use super::cases::{CASES, STRETCH, SideCase};
use super::trial::{SideOutcome, SideQuiet};
use crate::evaluate::figures::quantiles;
use crate::evaluate::machines::ProcessMachine;
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
    /// Drifts of which the right transducer was named before [`super::cases::IN_TIME`].
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

/// What became of a trial.
#[derive(Clone, Debug, PartialEq)]
pub enum SideProduct {
    /// The drift of that index of [`CASES`] on the machine of that index.
    Drift {
        machine: usize,
        case: usize,
        number: u32,
        outcomes: Vec<SideOutcome>,
    },
    Quiet {
        machine: usize,
        quiet: SideQuiet,
    },
}

/// Products so far.
#[derive(Clone, Debug, Default)]
pub struct SideGathered {
    drifts: BTreeMap<(usize, usize, u32), Vec<SideOutcome>>,
    /// Stretches, false alarms in them, and those that named a transducer.
    quiet: BTreeMap<usize, [u64; 3]>,
}

impl SideGathered {
    pub(super) fn add(&mut self, product: SideProduct) {
        match product {
            SideProduct::Drift { machine, case, number, outcomes } => {
                self.drifts.insert((machine, case, number), outcomes);
            }
            SideProduct::Quiet { machine, quiet } => {
                let [stretches, raises, named] = self.quiet.entry(machine).or_default();
                *stretches += 1;
                *raises += quiet.raises;
                *named += quiet.named;
            }
        }
    }

    /// The figures of every drift on every one of `machines`.
    pub(super) fn result(&self, machines: &[ProcessMachine]) -> SideResult {
        let machines = || machines.iter().enumerate();
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
            quantiles(outcomes.iter().filter_map(value).collect(), [0.5, 0.95])
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
