//! Figures of the hand-over.

use super::cases::{HandoverCase, Policy};
use super::trial::{HandoverOutcome, SENSORS, Way};
use crate::evaluate::figures::quantiles;
use crate::evaluate::grade::Grade;
use crate::evaluate::proportion::Proportion;
use serde::Serialize;
use std::collections::BTreeMap;
use tertius_core::alarm::Detector;

/// Time in which people leave the gangway, s: that of a code orange (Table 2-1).
pub const IN_TIME: f64 = 60.0;

/// The result of the study.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct HandoverResult {
    pub faults: Vec<HandoverFigures>,
    pub wrong: Vec<WrongFigures>,
}

/// One fault on transducers of one grade.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HandoverFigures {
    pub grade: &'static str,
    pub sensor: &'static str,
    pub label: &'static str,
    pub faults: u64,
    /// Faults before which a transducer of the machine was blamed; no other figure counts them.
    pub spoilt: u64,
    /// Faults of which the right transducer was blamed.
    pub blamed: Proportion,
    /// Median and 95th percentile of the delays until then, s.
    pub delay: Option<[f64; 2]>,
    /// Where the machine that stays goes black: median and 5th percentile of the time from the first warning that blames
    /// the right one until then, s, of those that have one.
    pub lead: Option<[f64; 2]>,
    /// Part of these code blacks that such a warning precedes by [`IN_TIME`].
    pub in_time: Proportion,
    /// In the order of [`Policy::ALL`].
    pub policies: Vec<PolicyFigures>,
}

/// What one policy makes of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PolicyFigures {
    pub policy: Policy,
    pub black: Proportion,
    /// Part of the code blacks of the machine that stays that do not come, because no sound transducer was blamed and the
    /// rule of 5 cm given up for nothing.
    pub avoided: Proportion,
    /// Median and 95th percentile of the largest differences of the rod from where it would be without the fault, before
    /// a code black, m.
    pub rod: [f64; 2],
    /// The same of the gangway's tip, a code black's way included, m.
    pub tip: [f64; 2],
}

/// Runs in which a healthy transducer was blamed, so that it would be left out, or C1 left for it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WrongFigures {
    pub grade: &'static str,
    /// What was wrong: nothing, C1 or C2.
    pub runs: &'static str,
    pub wrong: Proportion,
    /// By the detector that was wrong first.
    pub by: BTreeMap<&'static str, u64>,
}

impl HandoverResult {
    /// Adds the figures of every fault on transducers of `grade`.
    pub(super) fn add(
        &mut self,
        grade: Grade,
        cases: &[HandoverCase],
        outcomes: &[HandoverOutcome],
    ) {
        let tried =
            (0..SENSORS.len()).flat_map(|which| (0..cases.len()).map(move |case| (which, case)));
        self.faults.extend(tried.filter_map(|(which, case)| {
            let is_it = |it: &&HandoverOutcome| (it.which, it.case) == (which, case);
            let own: Vec<_> = outcomes.iter().filter(is_it).copied().collect();
            (!own.is_empty()).then(|| HandoverFigures::of(grade, which, &cases[case], &own))
        }));
        self.wrong.extend(WrongFigures::of(grade, cases, outcomes));
    }
}

impl HandoverFigures {
    fn of(grade: Grade, which: usize, case: &HandoverCase, outcomes: &[HandoverOutcome]) -> Self {
        let fair: Vec<_> = outcomes.iter().filter(|it| !it.spoilt).copied().collect();
        let stays = |it: &HandoverOutcome| it.ways[Policy::Stay as usize];
        let black: Vec<Way> = fair.iter().map(stays).filter(|way| way.black.is_some()).collect();
        let lead = |way: &Way| Some(way.black? - way.blamed?).filter(|lead| *lead > 0.0);
        let leads: Vec<f64> = black.iter().filter_map(lead).collect();
        let delays: Vec<f64> = fair.iter().filter_map(|it| stays(it).blamed).collect();
        let is_blamed = |it: &HandoverOutcome| stays(it).blamed.is_some();
        Self {
            grade: grade.name(),
            sensor: SENSORS[which],
            label: case.label,
            faults: outcomes.len() as u64,
            spoilt: (outcomes.len() - fair.len()) as u64,
            blamed: Proportion::counting(&fair, is_blamed),
            delay: quantiles(delays, [0.5, 0.95]),
            lead: quantiles(leads, [0.5, 0.05]),
            in_time: Proportion::counting(&black, |way| {
                lead(way).is_some_and(|lead| lead >= IN_TIME)
            }),
            policies: Policy::ALL.map(|policy| PolicyFigures::of(policy, &fair)).into(),
        }
    }
}

impl PolicyFigures {
    fn of(policy: Policy, fair: &[HandoverOutcome]) -> Self {
        let own = |it: &HandoverOutcome| it.ways[policy as usize];
        let is_black = |way: Way| way.black.is_some();
        let would: Vec<HandoverOutcome> =
            fair.iter().filter(|it| is_black(it.ways[Policy::Stay as usize])).copied().collect();
        let largest = |of: fn(Way) -> f64| {
            let all = fair.iter().map(|it| of(own(it))).collect();
            quantiles(all, [0.5, 0.95]).unwrap_or_default()
        };
        Self {
            policy,
            black: Proportion::counting(fair, |it| is_black(own(it))),
            avoided: Proportion::counting(&would, |it| {
                !is_black(own(it)) && own(it).wrong.is_none()
            }),
            rod: largest(|way| way.rod),
            tip: largest(|way| way.tip),
        }
    }
}

impl WrongFigures {
    fn of(grade: Grade, cases: &[HandoverCase], outcomes: &[HandoverOutcome]) -> Vec<Self> {
        let is_healthy = |it: &HandoverOutcome| cases[it.case].shape.is_none();
        let runs =
            |it: &HandoverOutcome| if is_healthy(it) { "healthy" } else { SENSORS[it.which] };
        let of = |kind: &'static str| {
            let own: Vec<_> =
                outcomes.iter().filter(|it| runs(it) == kind && !it.spoilt).copied().collect();
            // Those that stay hear all the same.
            let wrong = |it: &HandoverOutcome| it.ways.iter().find_map(|way| way.wrong);
            let mut by = BTreeMap::new();
            for number in own.iter().filter_map(wrong) {
                let detector = Detector::ALL.into_iter().find(|it| *it as u8 == number);
                *by.entry(detector.map_or("unknown", Detector::name)).or_default() += 1;
            }
            let wrong = Proportion::counting(&own, |it| wrong(it).is_some());
            Self { grade: grade.name(), runs: kind, wrong, by }
        };
        ["healthy", SENSORS[0], SENSORS[1]].map(of).into()
    }
}
