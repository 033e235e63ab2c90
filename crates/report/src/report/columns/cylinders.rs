//! Each cylinder's part of a summary as a row, and the trends of its transducers on the stops.

use super::column::{Cells, TableColumn, TableRow, count};
use super::events::columns;
use crate::report::Summary;
use crate::report::jsonl::in_seconds;
use crate::report::stops::TrendLine;
use tertius_core::monitor::cylinder::Tally;
use tertius_core::process::ProcessCoverage;
use tertius_core::sample::Transducer;
use tertius_core::sequential::{Coverage, Unknown};
use tertius_core::time::Timestamp;

/// What a recording says of a cylinder.
#[derive(Clone, Debug)]
pub struct CylinderRow {
    /// Time stamp of the recording's first frame.
    begin: Timestamp,
    /// Cylinder number, counted from 1.
    cylinder: usize,
    name: Option<String>,
    /// Names of C1 and C2.
    transducers: [Option<String>; 2],
    sample_time: f64,
    tally: Tally,
    jumps: [u64; 2],
    warnings: u64,
    unjudged: [Option<u64>; 2],
}

impl CylinderRow {
    /// The rows of a recording whose first frame is stamped `begin`.
    pub fn all(summary: &Summary<'_>, begin: Timestamp) -> Vec<Self> {
        let cylinders = summary.tallies.iter().zip(summary.counter_jumps).enumerate();
        let row = |(index, (tally, jumps)): (usize, (&Tally, &[u64; 2]))| Self {
            begin,
            cylinder: index + 1,
            name: summary.names.of_cylinder(index + 1).map(str::to_owned),
            transducers: Transducer::ALL
                .map(|it| summary.names.of_transducer(index + 1, it).map(str::to_owned)),
            sample_time: summary.sample_time,
            tally: *tally,
            jumps: *jumps,
            warnings: summary.episodes.of_cylinder(index + 1),
            unjudged: summary.blanks.unjudged.get(index).copied().unwrap_or_default(),
        };
        cylinders.map(row).collect()
    }

    fn sequential(&self, of: impl Fn(&Coverage) -> u64) -> Option<f64> {
        self.tally.sequential.map(|coverage| in_seconds(of(&coverage), self.sample_time))
    }

    fn unknown(&self, why: Unknown) -> Option<f64> {
        self.sequential(|coverage| coverage.unknown[why as usize])
    }

    fn process(&self, of: impl Fn(&ProcessCoverage) -> Option<u64>) -> Option<f64> {
        Some(in_seconds(of(&self.tally.process?)?, self.sample_time))
    }
}

impl TableRow for CylinderRow {
    const TABLE: &'static str = "cylinders";

    const COLUMNS: &'static [TableColumn<Self>] = columns! {
        "begin", "ns since 1970, UTC", Time, "first frame of the recording", |it| Some(it.begin);
        "cylinder", "", Count, "from 1", |it| i64::try_from(it.cylinder).ok();
        "name", "", Text, "name of the cylinder, if it has one", |it| it.name.clone().map(Into::into);
        "c1_name", "", Text, "name of its C1, if it has one", |it| it.transducers[0].clone().map(Into::into);
        "c2_name", "", Text, "name of its C2, if it has one", |it| it.transducers[1].clone().map(Into::into);
        "samples", "", Count, "cycles evaluated", |it| count(it.tally.cycles);
        "gated", "", Count, "cycles that neither FDE1 nor FDE2 judged", |it| count(it.tally.gated);
        "incomplete", "", Count, "cycles without something that is configured", |it| count(it.tally.incomplete);
        "unjudged_r1", "", Count, "cycles in which R1 was not judged", |it| count(it.unjudged[0]?);
        "unjudged_r2", "", Count, "cycles in which R2 was not judged", |it| count(it.unjudged[1]?);
        "implausible_c1", "", Count, "implausible readings of C1", |it| count(it.tally.implausible[0]);
        "implausible_c2", "", Count, "implausible readings of C2", |it| count(it.tally.implausible[1]);
        "counter_jumps_c1", "", Count, "jumps of C1's alive counter", |it| count(it.jumps[0]);
        "counter_jumps_c2", "", Count, "jumps of C2's alive counter", |it| count(it.jumps[1]);
        "worst_r1", "m", Number, "largest size of R1 that was judged", |it| it.tally.worst[0];
        "worst_r2", "m", Number, "largest size of R2 that was judged", |it| it.tally.worst[1];
        "worst_r3", "m", Number, "largest size of R3", |it| it.tally.worst[2];
        "warnings", "", Count, "warnings raised", |it| count(it.warnings);
        "judged_seconds", "s", Number, "the sequential detector judged", |it| it.sequential(|it| it.judged);
        "not_monitored_seconds", "s", Number, "it did not: no monitored state", |it| it.unknown(Unknown::NotMonitored);
        "no_reading_seconds", "s", Number, "it did not: a reading was missing or implausible", |it| it.unknown(Unknown::NoReading);
        "not_calibrated_seconds", "s", Number, "it did not: the rod was where there is no calibration", |it| it.unknown(Unknown::NotCalibrated);
        "no_baseline_seconds", "s", Number, "it did not: this stretch of motion was still learnt", |it| it.unknown(Unknown::NoBaseline);
        "process_monitored_seconds", "s", Number, "the process detector could judge", |it| it.process(|it| Some(it.monitored));
        "process_spool_seconds", "s", Number, "it judged by the spool", |it| it.process(|it| it.judged()[0]);
        "process_chambers_seconds", "s", Number, "it judged by the chambers' pressures", |it| it.process(|it| it.judged()[1]);
        "process_flow_seconds", "s", Number, "it judged by the flow", |it| it.process(|it| it.judged()[2]);
        "process_friction_seconds", "s", Number, "it judged by the friction", |it| it.process(|it| it.judged()[3]);
        "process_supply_seconds", "s", Number, "it judged by the supply", |it| it.process(|it| it.judged()[4]);
    };

    fn at(&self) -> Timestamp {
        self.begin
    }
}

/// The trend of a transducer on its stop at the end of a recording.
#[derive(Clone, Debug)]
pub struct StopTrendRow {
    /// Time stamp of the recording's first frame.
    pub begin: Timestamp,
    pub line: TrendLine,
}

impl TableRow for StopTrendRow {
    const TABLE: &'static str = "trends";

    const COLUMNS: &'static [TableColumn<Self>] = columns! {
        "begin", "ns since 1970, UTC", Time, "first frame of the recording at whose end it is known", |it| Some(it.begin);
        "cylinder", "", Count, "from 1", |it| Some(it.line.cylinder.into());
        "name", "", Text, "name of the cylinder, if it has one", |it| it.line.name.clone().map(Into::into);
        "transducer", "", Text, "c1, c2", |it| Some(it.line.transducer.into());
        "transducer_name", "", Text, "name of the transducer, if it has one", |it| it.line.transducer_name.clone().map(Into::into);
        "dwells", "", Count, "dwells that are kept", |it| i64::try_from(it.line.dwells).ok();
        "months", "months", Number, "the time between the first and the last", |it| Some(it.line.months);
        "moved_mm", "mm", Number, "how far the reading has moved", |it| Some(it.line.moved_mm);
        "mm_per_month", "mm a month", Number, "how fast", |it| Some(it.line.mm_per_month);
        "error_mm_per_month", "mm a month", Number, "standard error of that", |it| Some(it.line.error_mm_per_month);
        "maintenance_months", "months", Number, "until maintenance is due; null where the stops show no drift", |it| it.line.months_until_maintenance.as_ref().map(|it| it.expected);
        "maintenance_months_earliest", "months", Number, "the earliest", |it| it.line.months_until_maintenance.as_ref().map(|it| it.earliest);
        "maintenance_months_latest", "months", Number, "the latest", |it| it.line.months_until_maintenance.as_ref().map(|it| it.latest);
        "critical_months", "months", Number, "until the machine itself trips", |it| it.line.months_until_critical.as_ref().map(|it| it.expected);
        "critical_months_earliest", "months", Number, "the earliest", |it| it.line.months_until_critical.as_ref().map(|it| it.earliest);
        "critical_months_latest", "months", Number, "the latest", |it| it.line.months_until_critical.as_ref().map(|it| it.latest);
    };

    fn at(&self) -> Timestamp {
        self.begin
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::columns::column;
    use serde_json::json;

    #[test]
    fn every_column_has_its_own_part_of_the_summary() {
        let mut sequential = Coverage { judged: 100, ..Coverage::default() };
        for (many, why) in (1..).zip(Unknown::ALL) {
            sequential.unknown[why as usize] = 100 * many + 100;
        }
        let mut process = ProcessCoverage::new([true, false, true, true, true]);
        // Chambers, which it does not know, are no part of it.
        let judged = |k: u8| [k < 12, k < 13, k < 14, k < 16, k < 17];
        let bits = |k| judged(k).into_iter().rev().fold(0, |bits, it| bits << 1 | u8::from(it));
        (0..20).for_each(|k| process.count(bits(k)));
        let row = CylinderRow {
            begin: Timestamp::from_nanos(1_700_000_000_000_000_001),
            cylinder: 3,
            name: Some("FwdPort".to_owned()),
            transducers: [Some("LT-103A".to_owned()), None],
            sample_time: 0.5,
            tally: Tally {
                cycles: 1,
                gated: 2,
                incomplete: 3,
                implausible: [4, 5],
                worst: [Some(0.25), Some(0.5), Some(0.75)],
                sequential: Some(sequential),
                process: Some(process),
            },
            jumps: [6, 7],
            warnings: 8,
            unjudged: [Some(9), Some(10)],
        };
        let mut expected = json!({
            "begin": 1_700_000_000_000_000_001_i64, "cylinder": 3, "name": "FwdPort", "c1_name": "LT-103A",
            "samples": 1, "gated": 2, "incomplete": 3, "implausible_c1": 4, "implausible_c2": 5,
            "counter_jumps_c1": 6, "counter_jumps_c2": 7, "warnings": 8,
            "unjudged_r1": 9, "unjudged_r2": 10,
            "worst_r1": 0.25, "worst_r2": 0.5, "worst_r3": 0.75,
            "judged_seconds": 50.0, "process_monitored_seconds": 10.0,
            "process_spool_seconds": 6.0, "process_flow_seconds": 7.0,
            "process_friction_seconds": 8.0, "process_supply_seconds": 8.5,
        });
        for (why, name) in [
            (Unknown::NotMonitored, "not_monitored_seconds"),
            (Unknown::NoReading, "no_reading_seconds"),
            (Unknown::NotCalibrated, "not_calibrated_seconds"),
            (Unknown::NoBaseline, "no_baseline_seconds"),
        ] {
            expected[name] = json!(50.0 * (why as usize as f64 + 2.0));
        }
        assert_eq!(json!(column::cells(&row)), expected);
    }
}
