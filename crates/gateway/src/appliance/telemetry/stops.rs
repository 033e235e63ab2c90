//! Readings on the stops and their trends, written by the thread that keeps the history.

use super::Telemetry;
use super::cell::Gauge;
use serde::Serialize;
use tertius_core::sample::Transducer;
use tertius_core::sequential::{Archive, DriftLimits, DwellHistory, Judgement, stops};

/// Telemetry of one cylinder on its stop.
#[derive(Debug, Default)]
pub(super) struct Stop {
    /// Number of dwells that are kept.
    pub dwells: Gauge,
    /// Readings of C1 and C2.
    pub readings: [Reading; 2],
}

/// Trend of one transducer; absent where there are too few dwells.
#[derive(Debug, Default)]
pub(super) struct Reading {
    /// Move of the newest dwell from the first ones, m.
    pub moved: Gauge,
    /// Drift, m a month.
    pub drift: Gauge,
    /// Standard error of the drift, m a month.
    pub error: Gauge,
    /// Months until maintenance is due, expected, earliest and latest; absent where the stops do
    /// not name the transducer.
    pub left: [Gauge; 3],
}

/// A drifting transducer, for the health endpoint.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Drifting {
    pub cylinder: usize,
    pub transducer: &'static str,
    pub moved_mm: f64,
    pub mm_per_month: f64,
    pub error_mm_per_month: f64,
    /// Months from the newest dwell until it has moved by `sequential.maintenance`.
    pub months_until_maintenance: Option<f64>,
    /// Earliest such time, months.
    pub earliest_months: Option<f64>,
    /// Latest such time, months.
    pub latest_months: Option<f64>,
}

impl Stop {
    fn set(&self, history: Option<&DwellHistory>, judged: Option<Judgement>, limits: DriftLimits) {
        self.dwells.set(history.map(|history| history.dwells().len() as f64));
        for (which, reading) in self.readings.iter().enumerate() {
            let trend = history.and_then(|history| history.trend(which));
            reading.moved.set(trend.map(|trend| trend.moved));
            reading.drift.set(trend.map(|trend| trend.per_month));
            reading.error.set(trend.map(|trend| trend.error));
            let named = judged.is_some_and(|judgement| judgement.names(which));
            let left = trend.filter(|_| named).and_then(|it| it.until(limits.maintenance));
            let left = left.map(|left| [left.expected, left.earliest, left.latest]);
            for (i, gauge) in reading.left.iter().enumerate() {
                gauge.set(left.map(|left| left[i]));
            }
        }
    }
}

impl Telemetry {
    /// Takes the readings on the stops.
    pub fn stops(&self, archive: &Archive, limits: DriftLimits) {
        let judged = stops::judge(&archive.cylinders);
        for (i, cylinder) in self.cylinders.iter().enumerate() {
            cylinder.stop.set(archive.cylinders.get(i), judged.get(i).copied().flatten(), limits);
        }
    }

    /// Notes whether the history was written.
    pub fn history_written(&self, written: bool) {
        self.totals.history_writes.add(u64::from(written));
        self.totals.history_failures.add(u64::from(!written));
    }

    /// Notes that the history was not handed over, because too many orders wait. The next order
    /// includes it.
    pub fn history_crowded(&self) {
        self.totals.history_crowded.add(1);
    }

    /// Transducers that drift.
    pub(super) fn drifting(&self) -> Vec<Drifting> {
        let cylinders = (1..).zip(&self.cylinders);
        let readings = cylinders.flat_map(|(cylinder, it)| {
            let readings = Transducer::NAMES.into_iter().zip(&it.stop.readings);
            readings.map(move |(transducer, reading)| (cylinder, transducer, reading))
        });
        let drifting = readings.filter_map(|(cylinder, transducer, reading)| {
            let [expected, earliest, latest] = reading.left.each_ref().map(Gauge::get);
            Some(Drifting {
                cylinder,
                transducer,
                moved_mm: reading.moved.get()? * 1e3,
                mm_per_month: reading.drift.get()? * 1e3,
                error_mm_per_month: reading.error.get()? * 1e3,
                months_until_maintenance: Some(expected?),
                earliest_months: earliest,
                latest_months: latest,
            })
        });
        drifting.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::clock::SystemClock;
    use super::super::exposition::exposition;
    use super::*;
    use std::sync::Arc;
    use std::time::Duration;
    use tertius_core::sequential::{Dwell, StopReadings};
    use tertius_core::time::Timestamp;

    /// An archive of two cylinders with one dwell a day; C2 of the second drifts by 0.1 mm a day.
    fn archive(days: i64) -> Archive {
        let mut archive = Archive::new("a machine", 2);
        for day in 0..days {
            let at = Timestamp::from_nanos(day * 86_400_000_000_000);
            for (history, drift) in archive.cylinders.iter_mut().zip([0.0, 1e-4]) {
                history.add(Dwell {
                    at,
                    readings: StopReadings::both([-1.4, -1.39 + drift * day as f64]),
                });
            }
        }
        archive
    }

    fn told(telemetry: &Arc<Telemetry>, name: &str) -> Vec<String> {
        let text = exposition(telemetry, &SystemClock::new()).expect("text takes it");
        let name = format!("tertius_stop_{name}{{");
        text.lines().filter(|line| line.starts_with(&name)).map(str::to_owned).collect()
    }

    #[test]
    fn a_drift_is_told_and_with_few_dwells_nothing_is() {
        let limits = DriftLimits { maintenance: 5e-3, critical: 0.05 };
        let telemetry = Arc::new(Telemetry::new(&SystemClock::new()));
        telemetry.used.store(2, std::sync::atomic::Ordering::Relaxed);
        telemetry.stops(&archive(2), limits);
        assert_eq!(
            told(&telemetry, "dwells"),
            ["1", "2"].map(|n| { format!("tertius_stop_dwells{{cylinder=\"{n}\"}} 2.0") })
        );
        assert_eq!(told(&telemetry, "moved_meters"), [] as [String; 0]);
        assert_eq!(telemetry.health(Duration::ZERO).drifting, []);

        telemetry.stops(&archive(21), limits);
        assert_eq!(told(&telemetry, "drift_meters_per_month").len(), 4);
        let left = told(&telemetry, "months_until_maintenance");
        assert_eq!(left.len(), 1, "{left:?}");
        assert!(left[0].contains("cylinder=\"2\",transducer=\"c2\""), "{left:?}");
        let drifting = telemetry.health(Duration::ZERO).drifting;
        let [drifting] = &drifting[..] else { panic!("{drifting:?}") };
        assert_eq!((drifting.cylinder, drifting.transducer), (2, "c2"));
        assert!((drifting.mm_per_month - 3.04375).abs() < 1e-6, "{drifting:?}");
        let left = drifting.months_until_maintenance;
        assert!(drifting.earliest_months < left && left < drifting.latest_months);
        assert!(left.is_some_and(|left| (left - 1.02).abs() < 0.05), "{drifting:?}");

        // A machine of which nothing was read yet.
        telemetry.stops(&Archive::new("another", 1), limits);
        assert_eq!(telemetry.health(Duration::ZERO).drifting, []);
        assert_eq!(told(&telemetry, "dwells"), ["tertius_stop_dwells{cylinder=\"1\"} 0.0"]);
    }
}
