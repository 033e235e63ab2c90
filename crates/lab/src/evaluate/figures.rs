//! Figures that studies have in common: delays, suspects, quantiles.

use super::outcome::Blame;
use super::proportion::Proportion;
use serde::Serialize;

/// Times for which probabilities of detection are given, s.
pub const WITHIN: [f64; 3] = [0.2, 1.0, 10.0];

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

/// What one detector found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DetectorFigures {
    /// Part of the faults found while they were watched.
    pub found: Proportion,
    pub delay: Delay,
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

fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_unstable_by(f64::total_cmp);
    values
}

pub(super) fn median(values: Vec<f64>) -> f64 {
    quantile(&sorted(values), 0.5).unwrap_or(0.0)
}

/// Those parts of `values`; `None` where there are none.
pub(super) fn quantiles(mut values: Vec<f64>, parts: [f64; 2]) -> Option<[f64; 2]> {
    values.sort_unstable_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    Some(parts.map(|part| values[((part * values.len() as f64) as usize).min(last)]))
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
