//! Figures of the drifts that the deck's attitude names.

use super::cases::{CASES, DeckWitness, STRETCH};
use super::trial::{HexapodOutcome, HexapodQuiet};
use crate::evaluate::figures::quantiles;
use crate::evaluate::grade::Grade;
use crate::evaluate::proportion::Proportion;
use crate::evaluate::rate::Rate;
use crate::evaluate::side::cases::SideCase;
use serde::Serialize;
use std::collections::BTreeMap;

/// The result of the study.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct HexapodResult {
    pub drifts: Vec<HexapodFigures>,
    pub healthy: Vec<HexapodHealthy>,
}

/// One drift, by one witness.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HexapodFigures {
    pub grade: &'static str,
    pub witness: String,
    pub transducer: &'static str,
    /// m/s.
    pub rate: f64,
    /// Drifts of which the deck's attitude named the right transducer before [`crate::evaluate::side::IN_TIME`].
    pub named: Proportion,
    /// Drifts of which it ever named another one.
    pub wrong: Proportion,
    /// Median and 95th percentile of how far they had drifted when they were named, m.
    pub at: Option<[f64; 2]>,
    /// The same when they were found.
    pub found_at: Option<[f64; 2]>,
    /// Drifts of which another detector of the difference named the right transducer before, and of which one ever named
    /// the wrong one.
    pub others: [Proportion; 2],
}

/// Healthy hours with a sensor on the deck.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HexapodHealthy {
    pub grade: &'static str,
    pub witness: String,
    pub hours: f64,
    /// Warnings of the sequential detectors, and of the deck's attitude.
    pub sequential: Rate,
    pub hexapod: Rate,
}

/// What became of a trial.
#[derive(Clone, Debug, PartialEq)]
pub enum HexapodProduct {
    /// Of a grade, a witness and a case.
    Drift { place: [usize; 3], number: u32, outcome: HexapodOutcome },
    /// Of a grade and a witness.
    Quiet { place: [usize; 2], quiet: HexapodQuiet },
}

/// Products so far.
#[derive(Clone, Debug, Default)]
pub struct HexapodGathered {
    drifts: BTreeMap<[usize; 3], BTreeMap<u32, HexapodOutcome>>,
    /// Stretches and warnings in them.
    quiet: BTreeMap<[usize; 2], (u64, [u64; 2])>,
}

impl HexapodGathered {
    pub(super) fn add(&mut self, product: HexapodProduct) {
        match product {
            HexapodProduct::Drift { place, number, outcome } => {
                self.drifts.entry(place).or_default().insert(number, outcome);
            }
            HexapodProduct::Quiet { place, quiet } => {
                let (stretches, raises) = self.quiet.entry(place).or_default();
                *stretches += 1;
                for (sum, raises) in raises.iter_mut().zip(quiet.raises) {
                    *sum += raises;
                }
            }
        }
    }

    /// The figures of every drift by every one of `witnesses`.
    pub(super) fn result(&self, grades: &[Grade], witnesses: &[DeckWitness]) -> HexapodResult {
        let drifts = self.drifts.iter().filter_map(|([grade, witness, case], outcomes)| {
            let outcomes: Vec<HexapodOutcome> =
                outcomes.values().filter(|it| !it.spoilt).copied().collect();
            let of = (grades[*grade].name(), witnesses[*witness].label());
            (!outcomes.is_empty()).then(|| HexapodFigures::of(of, &CASES[*case], &outcomes))
        });
        let healthy = self.quiet.iter().map(|([grade, witness], (stretches, raises))| {
            let hours = *stretches as f64 * STRETCH / 3600.0;
            HexapodHealthy {
                grade: grades[*grade].name(),
                witness: witnesses[*witness].label(),
                hours,
                sequential: Rate::new(raises[0], hours),
                hexapod: Rate::new(raises[1], hours),
            }
        });
        HexapodResult { drifts: drifts.collect(), healthy: healthy.collect() }
    }
}

impl HexapodFigures {
    fn of(
        (grade, witness): (&'static str, String),
        case: &SideCase,
        outcomes: &[HexapodOutcome],
    ) -> Self {
        let of = |value: fn(&HexapodOutcome) -> Option<f64>| {
            quantiles(outcomes.iter().filter_map(value).collect(), [0.5, 0.95])
        };
        Self {
            grade,
            witness,
            transducer: case.transducer.name(),
            rate: case.rate,
            named: Proportion::counting(outcomes, |it| it.named.is_some() && !it.wrong),
            wrong: Proportion::counting(outcomes, |it| it.wrong),
            at: of(|it| it.named),
            found_at: of(|it| it.found),
            others: [0, 1].map(|at| Proportion::counting(outcomes, |it| it.others[at])),
        }
    }
}
