//! Statistics of the samples of each cylinder, minute by minute.

use super::column::{Cells, TableColumn, TableRow, count};
use super::events::columns;
use tertius_config::MachineNames;
use tertius_core::monitor::Record;
use tertius_core::time::Timestamp;
use tertius_learn::identify::moments::Spread;

const MINUTE: i64 = 60_000_000_000;

/// Statistics of one cylinder in one minute.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MinuteRow {
    begin: Timestamp,
    cylinder: u8,
    name: Option<String>,
    cycles: u64,
    monitored: u64,
    judged: [u64; 2],
    gated: u64,
    good: [u64; 2],
    /// m
    lengths: Spread,
    /// R1, R2, R3, m.
    residuals: [Spread; 3],
}

/// Gathers the rows of all cylinders.
#[derive(Clone, Debug, Default)]
pub struct Minutes {
    /// The minute that is gathered, of each cylinder.
    now: Vec<Option<MinuteRow>>,
}

impl Minutes {
    /// Counts `record`; the row of the minute before, if this is the first record of another one.
    pub fn take(&mut self, record: &Record) -> Option<MinuteRow> {
        let index = usize::from(record.cylinder) - 1;
        if self.now.len() <= index {
            self.now.resize(index + 1, None);
        }
        let nanos = record.timestamp.as_nanos();
        let begin = Timestamp::from_nanos(nanos.div_euclid(MINUTE).saturating_mul(MINUTE));
        let place = &mut self.now[index];
        let over = place.take_if(|row| row.begin != begin);
        let anew = || MinuteRow { begin, cylinder: record.cylinder, ..MinuteRow::default() };
        place.get_or_insert_with(anew).count(record);
        over
    }

    /// The rows of the minutes that are not over.
    pub fn rest(self) -> impl Iterator<Item = MinuteRow> {
        self.now.into_iter().flatten()
    }
}

impl MinuteRow {
    /// The row with the name that its cylinder has among `names`.
    pub fn named(self, names: &MachineNames) -> Self {
        Self { name: names.of_cylinder(self.cylinder).map(str::to_owned), ..self }
    }

    fn count(&mut self, record: &Record) {
        self.cycles += 1;
        self.monitored += u64::from(record.monitored);
        self.gated += u64::from(record.gated);
        for (which, judged) in record.judged.into_iter().enumerate() {
            self.judged[which] += u64::from(judged);
            self.good[which] += u64::from(record.qualities[which].is_good());
        }
        if let Some(length) = record.c1.filter(|_| record.qualities[0].is_good()) {
            self.lengths.add(length);
        }
        // What was not judged is compared with nothing; R3 is, wherever it is known.
        let [r1, r2, r3] = record.residuals;
        let [is_r1, is_r2] = record.judged;
        let judged = [r1.filter(|_| is_r1), r2.filter(|_| is_r2), r3];
        for (spread, value) in self.residuals.iter_mut().zip(judged) {
            if let Some(value) = value {
                spread.add(value);
            }
        }
    }
}

/// What `get` has of values; `None` where there are none.
fn of(spread: &Spread, get: fn(&Spread) -> f64) -> Option<f64> {
    (spread.count > 0).then(|| get(spread))
}

impl TableRow for MinuteRow {
    const TABLE: &'static str = "minutes";

    const COLUMNS: &'static [TableColumn<Self>] = columns! {
        "minute", "ns since 1970, UTC", Time, "its begin", |it| Some(it.begin);
        "cylinder", "", Count, "from 1", |it| Some(it.cylinder.into());
        "name", "", Text, "name of the cylinder, if it has one", |it| it.name.clone().map(Into::into);
        "cycles", "", Count, "cycles evaluated", |it| count(it.cycles);
        "monitored", "", Count, "cycles in which the platform was in a monitored state", |it| count(it.monitored);
        "judged_r1", "", Count, "cycles in which R1 was judged", |it| count(it.judged[0]);
        "judged_r2", "", Count, "cycles in which R2 was judged", |it| count(it.judged[1]);
        "gated", "", Count, "cycles in which neither was", |it| count(it.gated);
        "good_c1", "", Count, "cycles in which nothing spoke against the reading of C1", |it| count(it.good[0]);
        "good_c2", "", Count, "the same of C2", |it| count(it.good[1]);
        "length_min", "m", Number, "least good reading of C1", |it| of(&it.lengths, |it| it.low);
        "length_max", "m", Number, "largest good reading of C1", |it| of(&it.lengths, |it| it.high);
        "r1_count", "", Count, "values of R1 that were judged", |it| count(it.residuals[0].count);
        "r1_min", "m", Number, "the least of them", |it| of(&it.residuals[0], |it| it.low);
        "r1_max", "m", Number, "the largest of them", |it| of(&it.residuals[0], |it| it.high);
        "r1_mean", "m", Number, "their mean", |it| of(&it.residuals[0], |it| it.mean);
        "r1_rms", "m", Number, "the root of their mean square", |it| of(&it.residuals[0], Spread::rms);
        "r2_count", "", Count, "values of R2 that were judged", |it| count(it.residuals[1].count);
        "r2_min", "m", Number, "the least of them", |it| of(&it.residuals[1], |it| it.low);
        "r2_max", "m", Number, "the largest of them", |it| of(&it.residuals[1], |it| it.high);
        "r2_mean", "m", Number, "their mean", |it| of(&it.residuals[1], |it| it.mean);
        "r2_rms", "m", Number, "the root of their mean square", |it| of(&it.residuals[1], Spread::rms);
        "r3_count", "", Count, "values of R3", |it| count(it.residuals[2].count);
        "r3_min", "m", Number, "the least of them", |it| of(&it.residuals[2], |it| it.low);
        "r3_max", "m", Number, "the largest of them", |it| of(&it.residuals[2], |it| it.high);
        "r3_mean", "m", Number, "their mean", |it| of(&it.residuals[2], |it| it.mean);
        "r3_rms", "m", Number, "the root of their mean square", |it| of(&it.residuals[2], Spread::rms);
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
    use tertius_core::sample::Quality;

    /// A cycle in which nothing was read of the second cylinder.
    fn nothing(seconds: i64) -> Record {
        Record {
            timestamp: Timestamp::from_nanos(1_700_000_100_000_000_000 + seconds * 1_000_000_000),
            cylinder: 2,
            gated: true,
            monitored: true,
            ..Record::default()
        }
    }

    #[test]
    fn every_column_has_its_own_statistic() {
        let (good, missing) = (Quality::Good, Quality::Missing);
        let judged = |c1, residuals: [f64; 3]| Record {
            c1: Some(c1),
            qualities: [good, missing],
            residuals: residuals.map(Some),
            judged: [true; 2],
            gated: false,
            ..nothing(1)
        };
        let one = Record {
            qualities: [Quality::Failed, good],
            judged: [true, false],
            ..judged(9.0, [4.0, 7.0, -2.0])
        };
        let still = Record {
            c1: Some(0.75),
            qualities: [good, missing],
            residuals: [Some(3.0), None, Some(1.0)],
            monitored: false,
            ..nothing(2)
        };
        let mut minutes = Minutes::default();
        let two = [judged(1.5, [-0.5, 0.5, 1.0]), judged(1.25, [-0.5, -1.5, 4.0])];
        for record in [one].iter().chain(&two).chain(&[still; 4]).chain(&[nothing(59); 8]) {
            assert_eq!(minutes.take(record), None);
        }
        let row = minutes.take(&nothing(60)).expect("the next minute");
        let expected = json!({
            "minute": 1_700_000_100_000_000_000_i64, "cylinder": 2,
            "cycles": 15, "monitored": 11, "judged_r1": 3, "judged_r2": 2, "gated": 12,
            "good_c1": 6, "good_c2": 1, "length_min": 0.75, "length_max": 1.5,
            "r1_count": 3, "r1_min": -0.5, "r1_max": 4.0, "r1_mean": 1.0, "r1_rms": 5.5_f64.sqrt(),
            "r2_count": 2, "r2_min": -1.5, "r2_max": 0.5, "r2_mean": -0.5, "r2_rms": 1.25_f64.sqrt(),
            "r3_count": 7, "r3_min": -2.0, "r3_max": 4.0, "r3_mean": 1.0,
            "r3_rms": (25.0 / 7.0_f64).sqrt(),
        });
        assert_eq!(json!(column::cells(&row)), expected);

        // Where nothing was judged there is no statistic, and no zero in place of it.
        let rest = minutes.rest().next().expect("the minute that is not over");
        let counts = json!({
            "minute": 1_700_000_160_000_000_000_i64, "cylinder": 2,
            "cycles": 1, "monitored": 1, "judged_r1": 0, "judged_r2": 0, "gated": 1,
            "good_c1": 0, "good_c2": 0, "r1_count": 0, "r2_count": 0, "r3_count": 0,
        });
        assert_eq!(json!(column::cells(&rest)), counts);
    }
}
