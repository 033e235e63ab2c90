//! Statistics of the samples of each cylinder, minute by minute.

use super::column::{Cells, TableColumn, TableRow};
use super::events::columns;
use crate::monitor::Record;
use crate::time::Timestamp;

const MINUTE: i64 = 60_000_000_000;

/// Values of a quantity in a minute, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Moments {
    count: u64,
    least: f64,
    most: f64,
    sum: f64,
    squares: f64,
}

impl Moments {
    fn add(&mut self, value: f64) {
        if self.count == 0 {
            (self.least, self.most) = (value, value);
        }
        self.count += 1;
        self.least = self.least.min(value);
        self.most = self.most.max(value);
        self.sum += value;
        self.squares += value * value;
    }

    fn of(&self, value: f64) -> Option<f64> {
        (self.count > 0).then_some(value)
    }

    fn mean(&self) -> Option<f64> {
        self.of(self.sum / self.count as f64)
    }

    /// Root of the mean square.
    fn rms(&self) -> Option<f64> {
        self.of((self.squares / self.count as f64).sqrt())
    }
}

/// Statistics of one cylinder in one minute.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MinuteRow {
    begin: Timestamp,
    cylinder: u8,
    cycles: u64,
    monitored: u64,
    judged: [u64; 2],
    gated: u64,
    good: [u64; 2],
    lengths: Moments,
    residuals: [Moments; 3],
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
        for (moments, value) in self.residuals.iter_mut().zip(judged) {
            if let Some(value) = value {
                moments.add(value);
            }
        }
    }
}

impl TableRow for MinuteRow {
    const TABLE: &'static str = "minutes";

    const COLUMNS: &'static [TableColumn<Self>] = columns! {
        "minute", "ns since 1970, UTC", Time, "its begin", |it| Some(it.begin);
        "cylinder", "", Count, "from 1", |it| Some(it.cylinder.into());
        "cycles", "", Count, "cycles evaluated", |it| super::count(it.cycles);
        "monitored", "", Count, "cycles in which the platform was in a monitored state", |it| super::count(it.monitored);
        "judged_r1", "", Count, "cycles in which R1 was judged", |it| super::count(it.judged[0]);
        "judged_r2", "", Count, "cycles in which R2 was judged", |it| super::count(it.judged[1]);
        "gated", "", Count, "cycles in which neither was", |it| super::count(it.gated);
        "good_c1", "", Count, "cycles in which nothing spoke against the reading of C1", |it| super::count(it.good[0]);
        "good_c2", "", Count, "the same of C2", |it| super::count(it.good[1]);
        "length_min", "m", Number, "least good reading of C1", |it| it.lengths.of(it.lengths.least);
        "length_max", "m", Number, "largest good reading of C1", |it| it.lengths.of(it.lengths.most);
        "r1_count", "", Count, "values of R1 that were judged", |it| super::count(it.residuals[0].count);
        "r1_min", "m", Number, "the least of them", |it| it.residuals[0].of(it.residuals[0].least);
        "r1_max", "m", Number, "the largest of them", |it| it.residuals[0].of(it.residuals[0].most);
        "r1_mean", "m", Number, "their mean", |it| it.residuals[0].mean();
        "r1_rms", "m", Number, "the root of their mean square", |it| it.residuals[0].rms();
        "r2_count", "", Count, "values of R2 that were judged", |it| super::count(it.residuals[1].count);
        "r2_min", "m", Number, "the least of them", |it| it.residuals[1].of(it.residuals[1].least);
        "r2_max", "m", Number, "the largest of them", |it| it.residuals[1].of(it.residuals[1].most);
        "r2_mean", "m", Number, "their mean", |it| it.residuals[1].mean();
        "r2_rms", "m", Number, "the root of their mean square", |it| it.residuals[1].rms();
        "r3_count", "", Count, "values of R3", |it| super::count(it.residuals[2].count);
        "r3_min", "m", Number, "the least of them", |it| it.residuals[2].of(it.residuals[2].least);
        "r3_max", "m", Number, "the largest of them", |it| it.residuals[2].of(it.residuals[2].most);
        "r3_mean", "m", Number, "their mean", |it| it.residuals[2].mean();
        "r3_rms", "m", Number, "the root of their mean square", |it| it.residuals[2].rms();
    };

    fn at(&self) -> Timestamp {
        self.begin
    }
}
