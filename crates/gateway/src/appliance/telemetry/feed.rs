//! What is new in the trends, for whoever follows them.

use super::Telemetry;
use super::trend::{Bin, STEP};
use std::time::Duration;
use tertius_core::time::Timestamp;

/// Time between two looks.
pub const PERIOD: Duration = Duration::from_nanos(STEP.as_nanos() as u64);

/// Most bins of a cylinder in one look: those of 4 s, should the reader have waited for so long.
const MOST_BINS: usize = 8;

/// A bin as it is told: the cylinder, the begin of the bin, s, and the least and the largest value of each quantity, m;
/// `None` for none.
pub type TrendRow = (usize, f64, Vec<Option<f64>>);

/// A reader of all trends, which knows how far it has read.
#[derive(Debug, Default)]
pub struct TrendFeed {
    since: Vec<Timestamp>,
}

impl TrendFeed {
    /// The bins of each cylinder since the last look; of too many the newest.
    pub fn newest(&mut self, telemetry: &Telemetry) -> Vec<TrendRow> {
        let cylinders = telemetry.facts().limits_m.len();
        self.since.resize(cylinders, Timestamp::from_nanos(i64::MIN));
        let mut new = Vec::new();
        for (number, since) in (1..).zip(&mut self.since) {
            let Some(trend) = telemetry.trend(number) else { continue };
            let Some(newest) = trend.newest() else { continue };
            // Before that the clock was set back.
            *since = (*since).min(newest.begin);
            let bins = trend.after(*since);
            let skipped = bins.len().saturating_sub(MOST_BINS);
            new.extend(bins.iter().skip(skipped).map(|bin| row(number, bin)));
            *since = newest.begin;
        }
        new
    }
}

fn row(cylinder: usize, bin: &Bin) -> TrendRow {
    let values = bin.ranges.iter().flatten().map(|value| number(*value));
    (cylinder, bin.begin.as_seconds(), values.collect())
}

/// `value` to the micrometre, which is finer than any transducer; `None` for not-a-number.
pub fn number(value: f32) -> Option<f64> {
    value.is_finite().then(|| (f64::from(value) * 1e6).round() / 1e6)
}
