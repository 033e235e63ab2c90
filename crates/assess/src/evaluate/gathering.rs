//! Collects the results of the jobs, in any order.

use super::accommodate::{AccommodateGathering, AccommodateResult};
use super::claim::Judged;
use super::contest;
use super::estimate::{CASES, Errors, EstimateResult};
use super::figures::Figures;
use super::handover::{HandoverGathering, HandoverResult};
use super::healthy::Healthy;
use super::hexapod::{HexapodGathering, HexapodResult};
use super::last::{LastGathering, LastResult};
use super::learning::Learnt;
use super::outcome::Outcome;
use super::plan::{Cell, Job, Plan, Product};
use super::process::{ProcessGathering, ProcessResult};
use super::proportion::Proportion;
use super::rate::Rate;
use super::row::Row;
use super::side::{SideGathering, SideResult};
use super::weights;
use serde::Serialize;
use std::collections::BTreeMap;
use tertius_core::alarm::Detector;

/// The whole result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Evaluation {
    /// Name of the machine, which stands before what it was judged by in a report.
    #[serde(skip)]
    pub machine: String,
    pub seed: u64,
    pub rows: Vec<RowResult>,
    pub healthy: Vec<HealthyCell>,
    /// Comparison of the detectors, by grade.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub contest: Vec<contest::GradeResult>,
    pub estimates: Vec<EstimateResult>,
    /// Comparison of sets of weights for the observers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub weights: Vec<weights::SetResult>,
    /// Faults of the cylinders themselves.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub process: Option<ProcessResult>,
    /// Machines whose controller hears who is blamed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub handover: Option<HandoverResult>,
    /// Drifts of C1 and of C2 in the loop.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub side: Option<SideResult>,
    /// Drifts that the deck's attitude names.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hexapod: Option<HexapodResult>,
    /// Faults of the last transducer of a cylinder.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub last: Option<LastResult>,
    /// Estimates by a transducer less its step.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accommodate: Option<AccommodateResult>,
}

/// A row with its figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RowResult {
    #[serde(skip)]
    pub row: Row,
    pub study: &'static str,
    pub grade: &'static str,
    /// Significant wave height, m, and peak period, s.
    pub sea: [f64; 2],
    pub in_loop: bool,
    pub label: String,
    pub fault: &'static str,
    /// Size of the fault: m, m/s for a drift, or a part of the reading for a scale.
    pub size: Option<f64>,
    /// b of an incipient fault, or a probability.
    pub parameter: Option<f64>,
    /// How long the fault was watched, s.
    pub watched: f64,
    pub thesis: Option<Judged>,
    #[serde(flatten)]
    pub figures: Figures,
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

/// Outcomes that are being collected; a row becomes figures as soon as it is complete.
#[derive(Clone, Debug)]
pub struct Gathering<'a> {
    plan: &'a Plan,
    sample_time: f64,
    rows: Vec<Part>,
    healthy: Vec<Healthy>,
    contest: Option<contest::ContestGathering<'a>>,
    weights: Option<weights::WeightsGathering<'a>>,
    process: Option<ProcessGathering<'a>>,
    handover: Option<HandoverGathering<'a>>,
    side: Option<SideGathering<'a>>,
    hexapod: Option<HexapodGathering<'a>>,
    last: Option<LastGathering<'a>>,
    accommodate: Option<AccommodateGathering<'a>>,
    /// Errors of the estimates by cell, case and number of the machine.
    estimates: BTreeMap<(usize, usize), BTreeMap<u32, Errors>>,
}

#[derive(Clone, Debug, Default)]
struct Part {
    by_number: BTreeMap<u32, Vec<Outcome>>,
    result: Option<RowResult>,
}

impl<'a> Gathering<'a> {
    /// A collection for `plan`; `sample_time` is the machine's, s.
    pub fn new(plan: &'a Plan, sample_time: f64) -> Self {
        Self {
            plan,
            sample_time,
            rows: vec![Part::default(); plan.rows.len()],
            healthy: vec![Healthy::default(); plan.cells.len()],
            contest: plan.contest.as_ref().map(contest::ContestGathering::new),
            weights: plan.weighing.as_ref().map(weights::WeightsGathering::new),
            process: plan.process.as_ref().map(ProcessGathering::new),
            handover: plan.handover.as_ref().map(HandoverGathering::new),
            side: plan.side.as_ref().map(SideGathering::new),
            hexapod: plan.hexapod.as_ref().map(HexapodGathering::new),
            last: plan.last.as_ref().map(|last| LastGathering::new(last, sample_time)),
            accommodate: plan
                .accommodate
                .as_ref()
                .map(|study| AccommodateGathering::new(study, sample_time)),
            estimates: BTreeMap::new(),
        }
    }

    /// Takes the result of a job; each job once.
    pub fn take(&mut self, job: Job, product: Product) {
        match (job, product) {
            (Job::Trial { row: index, number }, Product::Trial(outcomes)) => {
                let (part, row) = (&mut self.rows[index], &self.plan.rows[index]);
                part.by_number.insert(number, outcomes);
                if part.by_number.len() == self.plan.machines(row) as usize {
                    let all = std::mem::take(&mut part.by_number);
                    let outcomes: Vec<Outcome> = all.into_values().flatten().collect();
                    part.result = Some(RowResult::new(row, &outcomes, self.sample_time));
                }
            }
            (Job::Healthy { cell, .. }, Product::Healthy(more)) => self.healthy[cell].add(&more),
            (Job::Contest(job), Product::Contest(product)) => {
                if let Some(contest) = &mut self.contest {
                    contest.take(job, product);
                }
            }
            (Job::Weights(job), Product::Weights(product)) => {
                if let Some(weights) = &mut self.weights {
                    weights.take(job, product);
                }
            }
            (Job::Process(job), Product::Process(product)) => {
                if let Some(process) = &mut self.process {
                    process.take(job, product);
                }
            }
            (Job::Handover(job), Product::Handover(outcomes)) => {
                if let Some(handover) = &mut self.handover {
                    handover.take(job, outcomes);
                }
            }
            (Job::Side(job), Product::Side(product)) => {
                if let Some(side) = &mut self.side {
                    side.take(job, product);
                }
            }
            (Job::Hexapod(job), Product::Hexapod(product)) => {
                if let Some(hexapod) = &mut self.hexapod {
                    hexapod.take(job, product);
                }
            }
            (Job::Last(job), Product::Last(product)) => {
                if let Some(last) = &mut self.last {
                    last.take(job, product);
                }
            }
            (Job::Accommodate(job), Product::Accommodate(product)) => {
                if let Some(accommodate) = &mut self.accommodate {
                    accommodate.take(job, product);
                }
            }
            (Job::Estimate { cell, case, number }, Product::Estimate(errors)) => {
                self.estimates.entry((cell, case)).or_default().insert(number, errors);
            }
            // A job brings what it is.
            (
                Job::Trial { .. }
                | Job::Healthy { .. }
                | Job::Contest(_)
                | Job::Weights(_)
                | Job::Process(_)
                | Job::Handover(_)
                | Job::Side(_)
                | Job::Hexapod(_)
                | Job::Last(_)
                | Job::Accommodate(_)
                | Job::Estimate { .. },
                _,
            ) => {}
        }
    }

    /// The result of all rows that are complete; `learnt` is what the detectors of the contest
    /// knew, `block` the time that counts as one warning, s.
    pub fn finish(self, machine: &str, learnt: &[Learnt], block: f64) -> Evaluation {
        let cells = self.plan.cells.iter().zip(&self.healthy);
        let healthy = cells.filter(|(_, healthy)| healthy.judged[0] > 0);
        let cylinders = self.plan.extent.cylinders;
        let contest = self.contest.map(|contest| contest.finish(learnt, self.sample_time));
        Evaluation {
            contest: contest.unwrap_or_default(),
            weights: self.weights.map(|weights| weights.finish(block)).unwrap_or_default(),
            process: self.process.as_ref().map(ProcessGathering::finish),
            handover: self.handover.as_ref().map(HandoverGathering::finish),
            side: self.side.as_ref().map(SideGathering::finish),
            hexapod: self.hexapod.as_ref().map(HexapodGathering::finish),
            last: self.last.as_ref().map(LastGathering::finish),
            accommodate: self.accommodate.as_ref().map(AccommodateGathering::finish),
            machine: machine.to_owned(),
            seed: self.plan.seed,
            healthy: healthy
                .map(|(cell, healthy)| {
                    HealthyCell::new(*cell, healthy, (cylinders, self.sample_time))
                })
                .collect(),
            estimates: self
                .estimates
                .into_iter()
                .map(|((cell, case), machines)| {
                    let machines: Vec<Errors> = machines.into_values().collect();
                    EstimateResult::new(self.plan.cells[cell], &CASES[case], &machines, cylinders)
                })
                .collect(),
            rows: self.rows.into_iter().filter_map(|part| part.result).collect(),
        }
    }
}

impl RowResult {
    fn new(row: &Row, outcomes: &[Outcome], sample_time: f64) -> Self {
        let fair: Vec<Outcome> = outcomes.iter().filter(|one| !one.spoilt).cloned().collect();
        Self {
            row: *row,
            study: row.study.name(),
            grade: row.cell.grade.name(),
            sea: row.cell.sea,
            in_loop: row.in_loop,
            label: row.label(),
            fault: row.fault(),
            size: row.size(),
            parameter: row.parameter(),
            watched: row.watch,
            thesis: row.claim.map(|claim| claim.judge(&fair, sample_time)),
            figures: Figures::of(row, outcomes),
        }
    }
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
