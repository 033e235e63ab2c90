//! Points of civil time in UTC, as the heads of logs tell them.

const NANOS_PER_SECOND: i64 = 1_000_000_000;
const NANOS_PER_MILLISECOND: i64 = 1_000_000;
const MILLIS_PER_SECOND: i64 = 1000;
const SECONDS_PER_DAY: i64 = 86_400;

/// The start of a recording whose first frame is at this many nanoseconds: the second before it, so that frames
/// which are a little earlier can be counted from it, too.
pub const fn start_of(nanos: i64) -> i64 {
    nanos.saturating_sub(nanos.rem_euclid(NANOS_PER_SECOND))
}

/// A point of civil time in UTC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CivilTime {
    pub year: i64,
    /// Counted from 1.
    pub month: i64,
    pub day: i64,
    /// Counted from Sunday, 0.
    pub weekday: i64,
    pub hour: i64,
    pub minute: i64,
    pub second: i64,
    pub milli: i64,
}

impl CivilTime {
    /// The point that is this many nanoseconds after 1970 began, to the millisecond before it.
    pub fn of(nanos: i64) -> Self {
        let millis = nanos.div_euclid(NANOS_PER_MILLISECOND);
        let (seconds, milli) =
            (millis.div_euclid(MILLIS_PER_SECOND), millis.rem_euclid(MILLIS_PER_SECOND));
        let (days, second) =
            (seconds.div_euclid(SECONDS_PER_DAY), seconds.rem_euclid(SECONDS_PER_DAY));
        // By eras of 400 years that begin on 1 March, so that the leap day is the last of its year.
        let day = days + 719_468;
        let (era, day) = (day.div_euclid(146_097), day.rem_euclid(146_097));
        let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
        let day = day - (365 * year + year / 4 - year / 100);
        let month = (5 * day + 2) / 153;
        Self {
            year: 400 * era + year + i64::from(month > 9),
            month: if month > 9 { month - 9 } else { month + 3 },
            day: day - (153 * month + 2) / 5 + 1,
            weekday: (days + 4).rem_euclid(7),
            hour: second / 3600,
            minute: second / 60 % 60,
            second: second % 60,
            milli,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::candump::stamp::Stamp;
    use super::*;

    #[test]
    fn every_day_is_the_one_that_is_read_back() {
        for day in -100_000..100_000_i64 {
            let nanos = (day * 86_400 + day.rem_euclid(86_400)) * 1_000_000_000 + 7_000_000;
            let CivilTime { year, month, day: date, weekday, hour, minute, second, milli } =
                CivilTime::of(nanos);
            assert_eq!(weekday, (day + 4).rem_euclid(7));
            let text = format!(
                "{year:04}-{month:02}-{date:02} {hour:02}:{minute:02}:{second:02}.{milli:03}"
            );
            assert_eq!(Stamp::parse(text.as_bytes()).map(|it| it.nanos), Ok(nanos), "{text}");
        }
    }
}
