//! Statistics of the residuals, hour by hour.

use tertius_core::alarm::status::MAX_CYLINDERS;
use tertius_core::monitor::Record;
use tertius_core::time::{Span, Timestamp};

/// Time after which what was counted is handed over: as much may be lost when the power fails. It divides an hour.
const PART_S: i64 = 600;
const HOUR_S: i64 = 3600;
const SECOND: i64 = 1_000_000_000;

/// Names of the residuals.
pub const RESIDUALS: [&str; 3] = ["r1", "r2", "r3"];

/// Statistics of one residual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Moments {
    pub count: u32,
    /// m
    pub mean: f64,
    /// Sum of the squared deviations from the mean, m².
    pub squares: f64,
    /// m
    pub least: f64,
    /// m
    pub most: f64,
}

/// Statistics of one cylinder in a part of an hour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Part {
    /// Begin of the hour, s since 1970.
    pub hour: i64,
    /// Cylinder number, counted from 1.
    pub cylinder: u8,
    /// R1, R2, R3.
    pub moments: [Moments; 3],
    /// Sample time, s.
    pub sample_time: f64,
}

impl Moments {
    const NONE: Self =
        Self { count: 0, mean: 0.0, squares: 0.0, least: f64::INFINITY, most: f64::NEG_INFINITY };

    /// Takes a residual, m (Welford's update).
    fn take(&mut self, residual: f64) {
        self.count = self.count.saturating_add(1);
        let before = residual - self.mean;
        self.mean += before / f64::from(self.count);
        self.squares += before * (residual - self.mean);
        self.least = self.least.min(residual);
        self.most = self.most.max(residual);
    }
}

/// What is counted of the parts that go on, without allocation.
#[derive(Debug)]
pub(super) struct Hours {
    /// Begin and end of the part.
    part: [Timestamp; 2],
    moments: [[Moments; 3]; MAX_CYLINDERS],
    sample_time: f64,
}

impl Hours {
    pub fn new() -> Self {
        Self {
            part: [Timestamp::default(); 2],
            moments: [[Moments::NONE; 3]; MAX_CYLINDERS],
            sample_time: 0.0,
        }
    }

    /// Restarts with this sample time, s.
    pub fn begin(&mut self, sample_time: f64) {
        *self = Self { sample_time, ..Self::new() };
    }

    /// Takes a cycle of one cylinder: the residuals that were judged. Passes to `say` the part that it ends.
    pub fn take(&mut self, record: &Record, say: impl FnMut(Part)) {
        let at = record.timestamp;
        if at < self.part[0] || at >= self.part[1] {
            self.finish(say);
            let begin = at.as_nanos().div_euclid(PART_S * SECOND) * (PART_S * SECOND);
            let begin = Timestamp::from_nanos(begin);
            self.part = [begin, begin.after(Span::from_nanos(PART_S * SECOND))];
        }
        let index = usize::from(record.cylinder).wrapping_sub(1);
        let Some(cylinder) = self.moments.get_mut(index) else { return };
        // R3 is judged wherever it is.
        let judged = [record.judged[0], record.judged[1], true];
        for ((moments, residual), judged) in cylinder.iter_mut().zip(record.residuals).zip(judged) {
            if let Some(residual) = residual.filter(|it| judged && it.is_finite()) {
                moments.take(residual);
            }
        }
    }

    /// Ends the part, also before it is over: the parts of an hour are added up.
    pub fn finish(&mut self, mut say: impl FnMut(Part)) {
        let seconds = self.part[0].as_nanos().div_euclid(SECOND);
        let hour = seconds.div_euclid(HOUR_S) * HOUR_S;
        for (cylinder, moments) in (1..).zip(&mut self.moments) {
            if moments.iter().any(|it| it.count > 0) {
                say(Part { hour, cylinder, moments: *moments, sample_time: self.sample_time });
            }
            *moments = [Moments::NONE; 3];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tertius_core::sample::Quality;

    fn record(seconds: i64, residual: Option<f64>) -> Record {
        Record {
            timestamp: Timestamp::from_nanos(seconds * SECOND),
            cylinder: 2,
            qualities: [Quality::Good; 2],
            residuals: [residual, None, None],
            judged: [true; 2],
            monitored: true,
            ..Record::default()
        }
    }

    #[test]
    fn a_part_has_the_moments_of_its_readings() {
        let (mut hours, mut parts) = (Hours::new(), Vec::new());
        hours.begin(0.02);
        for (seconds, residual) in [(7200, 1.0), (7201, 2.0), (7799, 6.0), (7800, 9.0)] {
            hours.take(&record(seconds, Some(residual)), |part| parts.push(part));
        }
        hours.take(&record(7801, None), |part| parts.push(part));
        let [part] = parts[..] else { panic!("{parts:?}") };
        assert_eq!((part.hour, part.cylinder), (7200, 2));
        let [r1, r2, _] = part.moments;
        assert_eq!((r1.count, r1.mean, r1.squares, r1.least, r1.most), (3, 3.0, 14.0, 1.0, 6.0));
        assert_eq!(r2.count, 0);
        hours.finish(|part| parts.push(part));
        assert_eq!((parts[1].hour, parts[1].moments[0].count), (7200, 1));
        hours.finish(|part| panic!("nothing is left: {part:?}"));
    }

    #[test]
    fn a_clock_that_is_set_back_ends_a_part() {
        let (mut hours, mut parts) = (Hours::new(), Vec::new());
        for seconds in [7200, 3600, 7200] {
            hours.take(&record(seconds, Some(1.0)), |part| parts.push(part.hour));
        }
        assert_eq!(parts, [7200, 3600]);
    }
}
