//! Figures of the outcomes of a row.

use super::claim::Judged;
use super::row::Row;
use crate::evaluate::fault::{fault_kind, fault_label, fault_name, fault_parameter, fault_size};
use crate::evaluate::figures::{Delay, DetectorFigures, Found, SuspectFigures, WITHIN, median};
use crate::evaluate::outcome::Outcome;
use crate::evaluate::proportion::Proportion;
use serde::Serialize;
use std::collections::BTreeMap;
use tertius_core::alarm::Detector;
use tertius_core::verdict::Fault;

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

impl RowResult {
    /// The figures of `outcomes` of `row`; `sample_time` is the machine's, s.
    pub fn new(row: &Row, outcomes: &[Outcome], sample_time: f64) -> Self {
        let fair: Vec<Outcome> = outcomes.iter().filter(|one| !one.spoilt).cloned().collect();
        Self {
            row: *row,
            study: row.group.name(),
            grade: row.cell.grade.name(),
            sea: row.cell.sea,
            in_loop: row.in_loop,
            label: fault_label(row.wanted),
            fault: fault_name(row.wanted),
            size: fault_size(row.wanted),
            parameter: fault_parameter(row.wanted),
            watched: row.watch,
            thesis: row.claim.map(|claim| claim.judge(&fair, sample_time)),
            figures: Figures::of(row, outcomes),
        }
    }
}

/// The figures of a row. Faults that began while a warning of their cylinder stood count as spoilt
/// and are excluded from all other figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figures {
    pub faults: u64,
    pub spoilt: u64,
    /// Warnings before the faults.
    pub early: u64,
    /// Faults found by any detector within each of [`WITHIN`].
    pub found: [Found; WITHIN.len()],
    /// Part of the faults that any detector found while they were watched.
    pub found_watched: Proportion,
    pub delay: Delay,
    /// Suspect of the first warning, for the faults that were found.
    pub suspect_first: SuspectFigures,
    /// Suspect of all warnings in the end.
    pub suspect: SuspectFigures,
    /// Incidents reported of the faults that were found.
    pub incidents: IncidentFigures,
    /// How often the fault was named correctly, for those found; `None` where it has no name.
    pub kind: Option<KindFigures>,
    /// Faults found by the observer of the faulty transducer.
    pub own: DetectorFigures,
    pub detectors: BTreeMap<&'static str, DetectorFigures>,
    /// Warnings of cylinders without a fault; `None` where every cylinder has one.
    pub beside: Option<u64>,
    /// Medians of the largest |R1|, |R2| and |R3| of each fault, m.
    pub worst: [f64; 3],
    pub moved: Option<Moved>,
}

/// What the incidents report of the faults that were found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct IncidentFigures {
    /// Part of the faults of which exactly one incident was reported.
    pub one: Proportion,
    /// Faults of which several were reported.
    pub split: u64,
    /// Suspect of the first incident in the end.
    pub suspect: SuspectFigures,
    /// How often it names the fault correctly; `None` where the fault has no name.
    pub named: Option<Proportion>,
}

impl IncidentFigures {
    fn of(seen: &[&Outcome], kind: Option<Fault>) -> Self {
        let reported = |one: &&Outcome| one.incidents;
        Self {
            one: Proportion::counting(seen, |one| reported(one).count == 1),
            split: seen.iter().filter(|one| reported(one).count > 1).count() as u64,
            suspect: SuspectFigures::of(seen.iter().map(|one| reported(one).blame)),
            named: kind
                .map(|kind| Proportion::counting(seen, |one| reported(one).kind == Some(kind))),
        }
    }
}

/// How often a fault was named correctly.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct KindFigures {
    pub expected: &'static str,
    #[serde(flatten)]
    pub named: Proportion,
}

/// Displacement of the machine by the fault, in the loop or beside it, m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Moved {
    /// Largest distance of the rod from where it would be without the fault: median over the
    /// faults.
    pub rod_median: f64,
    /// Largest distance of the rod over all faults, m.
    pub rod_largest: f64,
    /// Difference of C1's reading from what it would be without the fault, RMS over the last
    /// second: median over the faults.
    pub reading_median: f64,
}

impl Figures {
    /// The figures of `outcomes` of `row`.
    pub fn of(row: &Row, outcomes: &[Outcome]) -> Self {
        let fair: Vec<&Outcome> = outcomes.iter().filter(|outcome| !outcome.spoilt).collect();
        let delays: Vec<Option<f64>> = fair.iter().map(|outcome| outcome.delay()).collect();
        let seen: Vec<&Outcome> =
            fair.iter().filter(|one| one.delay().is_some()).copied().collect();
        let within = |within: f64| Found {
            within,
            found: Proportion::counting(&delays, |delay| delay.is_some_and(|it| it <= within)),
        };
        let of = |index: usize| {
            DetectorFigures::of(fair.iter().map(|outcome| outcome.delays[index]).collect())
        };
        let kind = fault_kind(row.wanted).map(|expected| KindFigures {
            expected: expected.name(),
            named: Proportion::counting(&seen, |one| one.kind == Some(expected)),
        });
        let beside = fair.iter().map(|outcome| u64::from(outcome.beside)).sum();
        Self {
            faults: fair.len() as u64,
            spoilt: (outcomes.len() - fair.len()) as u64,
            early: outcomes.iter().map(|outcome| u64::from(outcome.early)).sum(),
            found: WITHIN.map(within),
            found_watched: Proportion::counting(&delays, Option::is_some),
            delay: Delay::of(delays),
            suspect_first: SuspectFigures::of(seen.iter().map(|one| one.first_blame())),
            suspect: SuspectFigures::of(seen.iter().map(|one| one.blame)),
            incidents: IncidentFigures::of(&seen, fault_kind(row.wanted)),
            kind,
            own: DetectorFigures::of(fair.iter().map(|outcome| outcome.own()).collect()),
            detectors: (0..).zip(Detector::ALL).map(|(i, it)| (it.name(), of(i))).collect(),
            beside: row.is_alone().then_some(beside),
            worst: std::array::from_fn(|i| median(fair.iter().map(|one| one.worst[i]).collect())),
            moved: Moved::of(&fair),
        }
    }
}

impl Moved {
    fn of(outcomes: &[&Outcome]) -> Option<Self> {
        let rods: Vec<f64> = outcomes.iter().filter_map(|one| one.rod).collect();
        let largest = rods.iter().copied().reduce(f64::max)?;
        Some(Self {
            rod_median: median(rods),
            rod_largest: largest,
            reading_median: median(outcomes.iter().filter_map(|one| one.reading).collect()),
        })
    }
}
