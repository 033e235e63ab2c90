//! Figures of the weights.

use super::cases::{FAULTS, TransducerKind};
use super::trial::{Faulty, QuietMachine, STRETCH};
use crate::evaluate::fault::shape_label;
use crate::evaluate::proportion::Proportion;
use crate::evaluate::rate::Rate;
use serde::Serialize;
use std::collections::BTreeMap;
use tertius_learn::extremes::{HOURS_PER_YEAR, Maxima, Tail, common_level, per_second};
use tertius_learn::tune::{LEAST_HIGH, Weights};

/// Rates of false alarms for which thresholds are computed: one an hour, one a day, one a year.
const RATES: [f64; 3] = [HOURS_PER_YEAR, HOURS_PER_YEAR / 24.0, 1.0];

/// Result of one set of weights on one kind of transducers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SetResult {
    /// Kind of the transducers.
    pub kind: &'static str,
    /// Diagonal of Q.
    pub q: [f64; 3],
    /// Diagonal of R.
    pub r: [f64; 2],
    /// Hours of a healthy machine.
    pub hours: f64,
    /// Warnings of FDE1 and FDE2 in these hours with the thesis's δ_h, 1 mm.
    pub crossings: Rate,
    /// δ_h for one false alarm an hour, a day and a year, m, from the tails of the block maxima;
    /// `None` where there are too few blocks.
    pub levels: Option<[f64; 3]>,
    /// What is seen with the thesis's δ_h, and with that of one false alarm a day.
    pub seen: Vec<Seen>,
}

/// What the observer on the faulty transducer sees with a threshold, fault by fault.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Seen {
    /// δ_h, m.
    pub high: f64,
    pub faults: Vec<SeenFault>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SeenFault {
    pub label: String,
    /// How long the fault is watched, s; 0 is the faulty reading alone.
    pub within: f64,
    pub found: Proportion,
}

/// What became of a trial, for each set.
#[derive(Clone, Debug, PartialEq)]
pub enum WeightsProduct {
    Faulty { kind: TransducerKind, fault: usize, number: u32, sets: Vec<Faulty> },
    Quiet { kind: TransducerKind, number: u32, sets: Vec<QuietMachine> },
}

/// Products so far.
#[derive(Clone, Debug, Default)]
pub struct WeightsGathered {
    quiet: BTreeMap<(TransducerKind, u32), Vec<QuietMachine>>,
    faulty: BTreeMap<(TransducerKind, usize, u32), Vec<Faulty>>,
}

impl WeightsGathered {
    pub(super) fn add(&mut self, product: WeightsProduct) {
        match product {
            WeightsProduct::Quiet { kind, number, sets } => {
                self.quiet.insert((kind, number), sets);
            }
            WeightsProduct::Faulty { kind, fault, number, sets } => {
                self.faulty.insert((kind, fault, number), sets);
            }
        }
    }
}

/// Products, and what their figures depend on.
pub(super) struct Results<'a> {
    pub gathered: &'a WeightsGathered,
    pub sets: &'a [Weights],
    /// Number of cylinders that are monitored.
    pub cylinders: usize,
    /// Length of a block of judged time, s.
    pub block: f64,
}

impl Results<'_> {
    /// The result for every set on transducers of `kind`.
    pub fn of_kind(&self, kind: TransducerKind) -> Vec<SetResult> {
        (0..self.sets.len()).map(|set| self.result(kind, set)).collect()
    }

    fn result(&self, kind: TransducerKind, set: usize) -> SetResult {
        let quiet: Vec<&QuietMachine> = self
            .gathered
            .quiet
            .iter()
            .filter(|((of, _), _)| *of == kind)
            .map(|(_, sets)| &sets[set])
            .collect();
        let residuals = 2 * self.cylinders;
        let levels = tails(&quiet, residuals, self.block)
            .map(|tails| RATES.map(|per_year| common_level(&tails, per_second(per_year))));
        let hours = quiet.len() as f64 * STRETCH / 3600.0;
        let weights = self.sets[set];
        let thresholds = [Some(LEAST_HIGH), levels.map(|[_, daily, _]| daily)];
        SetResult {
            kind: kind.name(),
            q: weights.q,
            r: weights.r,
            hours,
            crossings: Rate::new(quiet.iter().map(|quiet| quiet.raises).sum(), hours),
            levels,
            seen: thresholds.into_iter().flatten().map(|high| self.seen(kind, set, high)).collect(),
        }
    }

    fn seen(&self, kind: TransducerKind, set: usize, high: f64) -> Seen {
        let fault = |(index, (shape, within)): (usize, &_)| {
            let own = self
                .gathered
                .faulty
                .iter()
                .filter(|((of, fault, _), _)| (*of, *fault) == (kind, index));
            let peaks: Vec<f64> =
                own.flat_map(|(_, sets)| sets[set].0.into_iter().take(self.cylinders)).collect();
            let found = peaks.iter().filter(|peak| **peak > high).count();
            let found = Proportion::new(found as u64, peaks.len() as u64);
            SeenFault { label: shape_label(*shape), within: *within, found }
        };
        Seen { high, faults: FAULTS.iter().enumerate().map(fault).collect() }
    }
}

/// Tails of the first `residuals` over all machines; `None` where one has too few blocks.
fn tails(quiet: &[&QuietMachine], residuals: usize, block: f64) -> Option<Vec<Tail>> {
    let tail = |index: usize| {
        // What comes in is the largest of a block already.
        let mut maxima = Maxima::new(1);
        quiet.iter().flat_map(|quiet| &quiet.blocks[index]).for_each(|peak| maxima.add(*peak));
        Tail::fit(&maxima, block)
    };
    (0..residuals).map(tail).collect()
}
