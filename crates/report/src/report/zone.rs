//! Dates and times of a recording for people.

use jiff::tz::TimeZone;
use jiff::{Zoned, fmt::strtime};
use tertius_core::time::Timestamp;

/// Earliest time stamp that is taken for a date, s since 1970: the beginning of 2000. Recordings whose clock counts
/// from their first frame, or from the computer's start, have smaller ones.
const DATES_FROM: i64 = 946_684_800;

/// The time zone of a report.
#[derive(Clone, Debug)]
pub struct Zone {
    zone: TimeZone,
    first: Timestamp,
    /// Whether a time of day says which day it is.
    is_of_one_day: bool,
}

/// Longest recording of which a time of day says enough, s.
const ONE_DAY: f64 = 86_000.0;

impl Zone {
    /// The zone of that name in the IANA database, `UTC` for example; `None` if there is none.
    pub fn named(name: &str) -> Option<TimeZone> {
        TimeZone::get(name).ok()
    }

    /// Times of a recording of `duration` s whose first frame is stamped `first`.
    pub const fn new(zone: TimeZone, first: Timestamp, duration: f64) -> Self {
        Self { zone, first, is_of_one_day: duration < ONE_DAY }
    }

    pub const fn first(&self) -> Timestamp {
        self.first
    }

    fn date(&self, at: Timestamp) -> Option<Zoned> {
        if at.as_nanos() < DATES_FROM * 1_000_000_000 {
            return None;
        }
        // Rounded to what is shown, so that 59.9996 s are no 59.999 s beside a table that rounds.
        let rounded = at.as_nanos().saturating_add(500_000) / 1_000_000;
        Some(jiff::Timestamp::from_millisecond(rounded).ok()?.to_zoned(self.zone.clone()))
    }

    fn formatted(&self, format: &str, at: Timestamp) -> Option<String> {
        strtime::format(format, &self.date(at)?).ok()
    }

    /// Time of day with milliseconds, with the date in a longer recording; or the time since the first frame where
    /// the time stamps are no dates.
    pub fn time(&self, at: Timestamp) -> String {
        let format = if self.is_of_one_day { "%H:%M:%S%.3f" } else { "%m-%d %H:%M:%S%.3f" };
        self.formatted(format, at)
            .unwrap_or_else(|| super::wording::clock(at.since(self.first).as_seconds()))
    }

    /// Date, time and zone: `2023-11-14 22:17:00.042 UTC`; or the time since the first frame.
    pub fn moment(&self, at: Timestamp) -> String {
        self.formatted("%Y-%m-%d %H:%M:%S%.3f %Z", at).unwrap_or_else(|| {
            let clock = super::wording::clock(at.since(self.first).as_seconds());
            format!("{clock} after the first frame")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn zone(name: &str, first: i64) -> Zone {
        Zone::new(Zone::named(name).expect("a zone"), Timestamp::from_nanos(first), 60.0)
    }

    #[test]
    fn dates_are_of_the_zone_and_say_which_it_is() {
        let at = Timestamp::from_nanos(1_700_000_220_041_999_999);
        assert_eq!(zone("UTC", 0).moment(at), "2023-11-14 22:17:00.042 UTC");
        assert_eq!(zone("Europe/Amsterdam", 0).moment(at), "2023-11-14 23:17:00.042 CET");
        let summer = Timestamp::from_nanos(1_690_000_000_000_000_000);
        assert_eq!(zone("Europe/Amsterdam", 0).time(summer), "06:26:40.000");
        assert!(Zone::named("Mars/Olympus").is_none());
    }

    #[test]
    fn what_is_no_date_counts_from_the_first_frame() {
        let zone = zone("UTC", 5_000_000_000);
        let at = Timestamp::from_nanos(65_042_000_000);
        assert_eq!(zone.time(at), "1:00.042");
        assert_eq!(zone.moment(at), "1:00.042 after the first frame");
    }
}
