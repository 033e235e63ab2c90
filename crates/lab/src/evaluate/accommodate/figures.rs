//! Figures of accommodation.

use super::cases::AccommodateCase;
use super::trial::{AccommodateOutcome, AccommodateOutcomes};
use crate::evaluate::grade::Grade;
use crate::evaluate::proportion::Proportion;
use serde::Serialize;

/// The result of the study.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct AccommodateResult {
    pub cases: Vec<AccommodateFigures>,
}

/// One case, with accommodation or without.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AccommodateFigures {
    pub grade: &'static str,
    pub label: String,
    pub accommodates: bool,
    /// Number of cylinders that were watched.
    pub cylinders: u64,
    /// Part of all cycles with a valid estimate.
    pub valid: f64,
    /// Median and largest error of the valid estimates, m.
    pub errors: Option<[f64; 2]>,
    /// Cylinders whose estimate was ever valid and off by more than three of its standard deviations.
    pub wrong: Proportion,
    /// How long it was, all times of a cylinder together: median of all cylinders and maximum, s.
    pub wrong_for: [f64; 2],
}

impl AccommodateResult {
    /// The figures of every one of `cases`, by what became of the machines of each of `grades`; `sample_time` is the
    /// machine's, s.
    pub(super) fn new(
        cases: &[AccommodateCase],
        grades: &[(Grade, Vec<AccommodateOutcomes>)],
        sample_time: f64,
    ) -> Self {
        let mut figures = Vec::new();
        for (grade, machines) in grades {
            for (place, case) in cases.iter().enumerate() {
                for with in [0, 1] {
                    let outcomes = machines.iter().flat_map(|cases| &cases[place]);
                    let outcomes: Vec<_> = outcomes.map(|both| &both[with]).collect();
                    let of = (*grade, case, with == 1);
                    figures.push(AccommodateFigures::of(of, &outcomes, sample_time));
                }
            }
        }
        Self { cases: figures }
    }
}

impl AccommodateFigures {
    fn of(
        (grade, case, accommodates): (Grade, &AccommodateCase, bool),
        outcomes: &[&AccommodateOutcome],
        sample_time: f64,
    ) -> Self {
        let cycles: u64 = outcomes.iter().map(|it| it.cycles).sum();
        let mut errors: Vec<f32> = outcomes.iter().flat_map(|it| &it.errors).copied().collect();
        errors.sort_unstable_by(f32::total_cmp);
        let mut wrong: Vec<u64> = outcomes.iter().map(|it| it.wrong).collect();
        wrong.sort_unstable();
        let at = |index: usize| wrong.get(index).map_or(0.0, |cycles| *cycles as f64 * sample_time);
        let largest = errors.last().copied();
        Self {
            grade: grade.name(),
            label: case.label(),
            accommodates,
            cylinders: outcomes.len() as u64,
            valid: errors.len() as f64 / cycles.max(1) as f64,
            errors: largest.map(|largest| [errors[errors.len() / 2], largest].map(f64::from)),
            wrong: Proportion::counting(outcomes, |it| it.wrong > 0),
            wrong_for: [at(wrong.len() / 2), at(wrong.len().saturating_sub(1))],
        }
    }
}
