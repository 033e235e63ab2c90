//! Trends of a transducer's readings on the stop.

use super::dwell::{Dwell, LEAST_DWELLS};
use super::stops::StopParameters;
use super::student;
use alloc::vec::Vec;

/// Seconds of a mean month.
const MONTH: f64 = 30.4375 * 86_400.0;

const P: &StopParameters = &StopParameters::DEFAULT;

/// A straight line through the readings of one transducer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trend {
    /// Slope, m a month.
    pub per_month: f64,
    /// Standard error of the slope, m a month.
    pub error: f64,
    /// Move of the newest dwell from the first ones, m.
    pub moved: f64,
    /// Length of the history, months.
    pub months: f64,
    pub dwells: usize,
}

/// Forecast of when a reading will have moved by a limit, months from its newest dwell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forecast {
    pub expected: f64,
    /// Earliest time, by the steepest line that the dwells allow.
    pub earliest: f64,
    /// Latest time, by the flattest line that the dwells allow.
    pub latest: f64,
}

/// Limits of the move of a reading, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriftLimits {
    /// Move at which the transducer is due for maintenance.
    pub maintenance: f64,
    /// Move at which the machine itself trips, if the other transducer has not moved.
    pub critical: f64,
}

impl Trend {
    /// The least-squares line through the readings `which` of `dwells`, in the order of time.
    /// `None` with fewer than three, and of a transducer that the cylinder does not have.
    pub(super) fn through(dwells: &[Dwell], which: usize) -> Option<Self> {
        let newest = dwells.last().filter(|_| dwells.len() >= LEAST_DWELLS)?;
        let readings: Option<Vec<f64>> =
            dwells.iter().map(|it| it.readings.each()[which]).collect();
        let readings = readings?;
        let first = dwells[0].at;
        let months = |dwell: &Dwell| dwell.at.since(first).as_seconds() / MONTH;
        let n = dwells.len() as f64;
        let t0 = dwells.iter().map(months).sum::<f64>() / n;
        let y0 = readings.iter().sum::<f64>() / n;
        let (mut tt, mut ty) = (0.0, 0.0);
        for (dwell, reading) in dwells.iter().zip(&readings) {
            let t = months(dwell) - t0;
            tt += t * t;
            ty += t * (reading - y0);
        }
        let per_month = ty / tt;
        let squares: f64 = dwells
            .iter()
            .zip(&readings)
            .map(|(dwell, reading)| reading - y0 - per_month * (months(dwell) - t0))
            .map(|residual| residual * residual)
            .sum();
        let deviation = libm::sqrt(squares / (n - 2.0)).max(P.repeatability);
        Some(Self {
            per_month,
            error: deviation / libm::sqrt(tt),
            moved: readings[readings.len() - 1] - begin(&readings),
            months: months(newest),
            dwells: dwells.len(),
        })
    }

    /// Margin of the slope, m a month: Student's, since three dwells say little about their
    /// scatter.
    fn margin(&self) -> f64 {
        let freedom = self.dwells.saturating_sub(2).max(1);
        student::two_sided(1.0 / P.in_so_many, freedom) * self.error
    }

    /// Whether the slope is beyond what the scatter of this number of dwells explains.
    pub fn is_drift(&self) -> bool {
        self.per_month.abs() > self.margin()
    }

    /// When the reading will have moved by `limit`, m, in either direction; `None` if it does not
    /// drift.
    pub fn until(&self, limit: f64) -> Option<Forecast> {
        let (speed, margin) = (self.per_month.abs(), self.margin());
        let left = (limit - self.moved * self.per_month.signum()).max(0.0);
        (speed > margin).then(|| Forecast {
            expected: left / speed,
            earliest: left / (speed + margin),
            latest: left / (speed - margin),
        })
    }
}

/// Reading of the first dwells, m: their median, so that one of them may be wrong.
fn begin(readings: &[f64]) -> f64 {
    let mut first = [0.0; LEAST_DWELLS];
    for (place, reading) in first.iter_mut().zip(readings) {
        *place = *reading;
    }
    first.sort_unstable_by(f64::total_cmp);
    first[LEAST_DWELLS / 2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequential::dwell::StopReadings;
    use crate::time::Timestamp;

    /// One dwell a day, `scatter` m on either side of a line.
    fn dwells(count: i32, per_day: f64, scatter: f64) -> Vec<Dwell> {
        let dwell = |k: i32| {
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            let reading = per_day * f64::from(k) + sign * scatter;
            let at = Timestamp::from_nanos(i64::from(k) * 86_400_000_000_000);
            Dwell { at, readings: StopReadings::both([reading, -reading]) }
        };
        (0..count).map(dwell).collect()
    }

    #[test]
    fn the_time_left_is_told_with_its_bounds() {
        let dwells = dwells(30, 1e-4, 2e-5);
        let [one, two] = [0, 1].map(|i| Trend::through(&dwells, i).expect("there are enough"));
        assert!((one.per_month - 1e-4 * 30.4375).abs() < 0.02 * one.per_month, "{one:?}");
        assert_eq!(one.per_month, -two.per_month);
        for trend in [one, two] {
            let left = trend.until(0.005).expect("it drifts");
            let expected = (0.005 - 28e-4) / (1e-4 * 30.4375);
            assert!((left.expected - expected).abs() < 0.03, "{left:?}");
            assert!(left.earliest < left.expected && left.expected < left.latest, "{left:?}");
            // With the scatter's floor of 50 um the error is 3.2 um a day over 1000^1/2 days.
            assert!((left.latest / left.expected - 1.0).abs() < 0.1, "{left:?}");
        }
        let reached = one.until(1e-3).expect("it drifts");
        assert_eq!(reached, Forecast { expected: 0.0, earliest: 0.0, latest: 0.0 });
    }

    #[test]
    fn scatter_is_no_drift_and_few_dwells_claim_little() {
        let still = Trend::through(&dwells(30, 0.0, 1e-4), 0).expect("there are enough");
        assert!(!still.is_drift() && still.until(0.005).is_none(), "{still:?}");
        assert_eq!(Trend::through(&dwells(2, 1e-3, 0.0), 0), None);
        // Twenty errors steep: of three dwells that is nothing, of ten it is a lot.
        let steep = |count: i32, margins: f64| {
            let still = Trend::through(&dwells(count, 0.0, 0.0), 0).expect("enough");
            let per_day = margins * still.error / 30.4375;
            Trend::through(&dwells(count, per_day, 0.0), 0).expect("enough").is_drift()
        };
        assert_eq!([steep(3, 20.0), steep(10, 20.0)], [false, true]);
        // Student's quantile of eight degrees of freedom.
        assert_eq!([steep(10, 5.0), steep(10, 5.1)], [false, true]);
    }
}
