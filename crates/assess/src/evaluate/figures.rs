//! What the outcomes of a row come to.

use super::outcome::{Blame, Outcome};
use super::proportion::Proportion;
use super::row::Row;
use serde::Serialize;
use std::collections::BTreeMap;
use tertius_core::alarm::Detector;

/// Probabilities of detection are told for these times, s.
pub const WITHIN: [f64; 3] = [0.2, 1.0, 10.0];

/// The figures of a row. Faults that began while a warning of their cylinder stood are spoilt, and
/// in none of the others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figures {
    pub faults: u64,
    pub spoilt: u64,
    /// Warnings before the faults.
    pub early: u64,
    /// By any detector, within each of [`WITHIN`].
    pub found: [Found; WITHIN.len()],
    /// By any detector, as long as they were watched.
    pub found_watched: Proportion,
    pub delay: Delay,
    /// Whom the first warning blamed, of those found.
    pub suspect_first: SuspectFigures,
    /// Whom all of them blamed in the end.
    pub suspect: SuspectFigures,
    /// Called by its name, of those found; `None` where it has none.
    pub kind: Option<KindFigures>,
    /// The observer on the faulty transducer.
    pub own: DetectorFigures,
    pub detectors: BTreeMap<&'static str, DetectorFigures>,
    /// Warnings of cylinders without a fault; `None` where every cylinder has one.
    pub beside: Option<u64>,
    /// Medians of the largest |R1|, |R2| and |R3| of each fault, m.
    pub worst: [f64; 3],
    pub moved: Option<Moved>,
}

/// What was found within a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Found {
    /// s.
    pub within: f64,
    #[serde(flatten)]
    pub found: Proportion,
}

/// Quantiles of the delay of whichever detector was first, s. A fault that was not found has a
/// delay beyond all others, so a quantile is `None` where too few were found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Delay {
    pub p05: Option<f64>,
    pub p25: Option<f64>,
    pub median: Option<f64>,
    pub p75: Option<f64>,
    pub p95: Option<f64>,
    pub p99: Option<f64>,
}

/// How often who was blamed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SuspectFigures {
    pub right: u64,
    pub undecided: u64,
    pub process: u64,
    /// The other transducer.
    pub wrong: u64,
}

/// How often a fault was called by its name.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct KindFigures {
    pub expected: &'static str,
    #[serde(flatten)]
    pub named: Proportion,
}

/// What one detector found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DetectorFigures {
    /// As long as they were watched.
    pub found: Proportion,
    pub delay: Delay,
}

/// How far the machine went, in the loop or beside it, m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Moved {
    /// The rod, from where it would be without the fault: median and largest of the farthest.
    pub rod_median: f64,
    pub rod_largest: f64,
    /// C1's reading, from what it would be without the fault, in the last second: median of the RMS.
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
        let kind = row.kind().map(|expected| KindFigures {
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
            kind,
            own: DetectorFigures::of(fair.iter().map(|outcome| outcome.own()).collect()),
            detectors: (0..).zip(Detector::ALL).map(|(i, it)| (it.name(), of(i))).collect(),
            beside: row.is_alone().then_some(beside),
            worst: std::array::from_fn(|i| median(fair.iter().map(|one| one.worst[i]).collect())),
            moved: Moved::of(&fair),
        }
    }
}

impl DetectorFigures {
    /// Of the delays, `None` where it was not found, s.
    pub(super) fn of(delays: Vec<Option<f64>>) -> Self {
        Self { found: Proportion::counting(&delays, Option::is_some), delay: Delay::of(delays) }
    }
}

impl Delay {
    /// Of the delays, `None` where it was not found, s.
    pub(super) fn of(delays: Vec<Option<f64>>) -> Self {
        let all: Vec<f64> = delays.iter().map(|delay| delay.unwrap_or(f64::INFINITY)).collect();
        let sorted = sorted(all);
        let at = |share| quantile(&sorted, share).filter(|delay| delay.is_finite());
        Self {
            p05: at(0.05),
            p25: at(0.25),
            median: at(0.5),
            p75: at(0.75),
            p95: at(0.95),
            p99: at(0.99),
        }
    }
}

impl SuspectFigures {
    pub(super) fn of(blames: impl Iterator<Item = Option<Blame>>) -> Self {
        let mut figures = Self::default();
        for blame in blames.flatten() {
            *match blame {
                Blame::Right => &mut figures.right,
                Blame::Undecided => &mut figures.undecided,
                Blame::Process => &mut figures.process,
                Blame::Wrong => &mut figures.wrong,
            } += 1;
        }
        figures
    }

    /// How many were blamed at all.
    pub const fn all(&self) -> u64 {
        self.right + self.undecided + self.process + self.wrong
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

fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_unstable_by(f64::total_cmp);
    values
}

fn median(values: Vec<f64>) -> f64 {
    quantile(&sorted(values), 0.5).unwrap_or(0.0)
}

/// The least value that at least `share` of the values do not exceed.
fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let rank = (share * sorted.len() as f64 - 1e-9).ceil().max(1.0) as usize;
    sorted.get(rank - 1).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantile_is_a_value_that_was_seen() {
        let values: Vec<f64> = (1..=100).map(f64::from).collect();
        for (share, value) in [(0.5, 50.0), (0.99, 99.0), (0.05, 5.0), (1.0, 100.0)] {
            assert_eq!(quantile(&values, share), Some(value), "{share}");
        }
        assert_eq!(quantile(&values[..1], 0.01), Some(1.0));
        assert_eq!(quantile(&[], 0.5), None);
    }

    #[test]
    fn what_was_not_found_is_later_than_all_that_was() {
        let delay = Delay::of(vec![None, Some(0.02), Some(0.01), Some(0.03)]);
        assert_eq!((delay.median, delay.p75, delay.p99), (Some(0.02), Some(0.03), None));
    }
}
