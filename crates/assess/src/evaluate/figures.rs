//! Figures of the outcomes of a row.

use super::outcome::{Blame, Outcome};
use super::proportion::Proportion;
use super::row::Row;
use serde::Serialize;
use std::collections::BTreeMap;
use tertius_core::alarm::Detector;
use tertius_core::verdict::Fault;

/// Times for which probabilities of detection are given, s.
pub const WITHIN: [f64; 3] = [0.2, 1.0, 10.0];

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
    /// Incidents told of the faults that were found.
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

/// Faults found within a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Found {
    /// Time after the onset, s.
    pub within: f64,
    #[serde(flatten)]
    pub found: Proportion,
}

/// Quantiles of the delay of the first detector, s. A fault that was not found counts as the
/// longest delay, so a quantile is `None` where too few were found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Delay {
    pub p05: Option<f64>,
    pub p25: Option<f64>,
    pub median: Option<f64>,
    pub p75: Option<f64>,
    pub p95: Option<f64>,
    pub p99: Option<f64>,
}

/// How often each suspect was blamed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SuspectFigures {
    pub right: u64,
    pub undecided: u64,
    pub process: u64,
    /// The other transducer was blamed.
    pub wrong: u64,
}

/// What the incidents say of the faults that were found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct IncidentFigures {
    /// Part of the faults of which exactly one incident was told.
    pub one: Proportion,
    /// Faults of which several were told.
    pub split: u64,
    /// Suspect of the first incident in the end.
    pub suspect: SuspectFigures,
    /// How often it names the fault correctly; `None` where the fault has no name.
    pub named: Option<Proportion>,
}

impl IncidentFigures {
    fn of(seen: &[&Outcome], kind: Option<Fault>) -> Self {
        let told = |one: &&Outcome| one.incidents;
        Self {
            one: Proportion::counting(seen, |one| told(one).count == 1),
            split: seen.iter().filter(|one| told(one).count > 1).count() as u64,
            suspect: SuspectFigures::of(seen.iter().map(|one| told(one).blame)),
            named: kind.map(|kind| Proportion::counting(seen, |one| told(one).kind == Some(kind))),
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

/// What one detector found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DetectorFigures {
    /// Part of the faults found while they were watched.
    pub found: Proportion,
    pub delay: Delay,
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
            incidents: IncidentFigures::of(&seen, row.kind()),
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
    /// Figures of the delays, s; a delay is `None` where the fault was not found.
    pub(super) fn of(delays: Vec<Option<f64>>) -> Self {
        Self { found: Proportion::counting(&delays, Option::is_some), delay: Delay::of(delays) }
    }
}

impl Delay {
    /// Quantiles of the delays, s; a delay is `None` where the fault was not found.
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

    /// Number of faults for which a transducer was blamed.
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
