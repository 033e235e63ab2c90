//! The date of a log, and what its times count from.

use crate::formats::candump::stamp::Stamp;
use crate::reason::{Found, Reason};

const NANOS_PER_MINUTE: i128 = 60_000_000_000;
const NANOS_PER_DAY: i128 = 24 * 60 * NANOS_PER_MINUTE;
/// Dates are cut to a whole second, and the clock may be set: by so much the first frame may be before the date, ns.
const BEFORE: i128 = 2_000_000_000;
/// By so much the first frame may be behind the date, ns.
const BEHIND: i128 = NANOS_PER_MINUTE;
/// Least time of day that can be told from a time since the start, ns.
const LEAST_OF_DAY: i128 = 10 * NANOS_PER_MINUTE;

/// The first letters of the months, in English and, where they differ, German.
const MONTHS: [&[&str]; 12] = [
    &["jan"],
    &["feb"],
    &["mar", "mär", "mrz"],
    &["apr"],
    &["may", "mai"],
    &["jun"],
    &["jul"],
    &["aug"],
    &["sep"],
    &["oct", "okt"],
    &["nov"],
    &["dec", "dez"],
];

/// The date of the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Date {
    /// Time since 1970, ns.
    nanos: i64,
    /// Whether the hour is one of twelve, with *am* or *pm*.
    is_halved: bool,
}

impl Date {
    /// Reads a date such as `Sat Sep 30 15:06:13.191 2017` or `Sat Sep 30 3:6:13 pm 2017`.
    pub fn parse(text: &[u8]) -> Result<Self, Reason> {
        let expected = "a date such as Sat Sep 30 15:06:13.191 2017";
        let none = || Reason::Expected { found: Found::first(text.trim_ascii()), expected };
        let text = String::from_utf8_lossy(text).to_lowercase();
        let words: Vec<&str> = text.split_whitespace().collect();
        let (month, day, time, half, year) = match words[..] {
            [_, month, day, time, year] => (month, day, time, None, year),
            [_, month, day, time, half, year] => (month, day, time, Some(half), year),
            _ => return Err(none()),
        };
        let is_month = |names: &&[&str]| names.iter().any(|name| month.starts_with(name));
        let month = 1 + MONTHS.iter().position(is_month).ok_or_else(none)?;
        let [hour, minute, second] =
            time.split(':').collect::<Vec<_>>().try_into().map_err(|_| none())?;
        let hour: u32 = hour.parse().map_err(|_| none())?;
        // Some tools have an hour 0 in place of 12.
        let hour = match half {
            None => hour,
            Some("am") if hour <= 12 => hour % 12,
            Some("pm") if hour <= 12 => hour % 12 + 12,
            Some(_) => return Err(none()),
        };
        let day: u32 = day.parse().map_err(|_| none())?;
        // Some tools write numbers of one digit.
        let second = if second.find('.').unwrap_or(second.len()) == 1 { "0" } else { "" }
            .to_owned()
            + second;
        let stamp = format!("{year}-{month:02}-{day:02} {hour:02}:{minute:0>2}:{second}");
        match Stamp::parse(stamp.as_bytes()) {
            Ok(stamp) => Ok(Self { nanos: stamp.nanos, is_halved: half.is_some() }),
            Err(Reason::StampRange) => Err(Reason::StampRange),
            Err(_) => Err(none()),
        }
    }
}

/// What the times of a log count from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Origin {
    /// Since 1970, ns.
    nanos: i128,
    /// Newest time of day, ns, if times are of the day.
    of_day: Option<i128>,
}

impl Origin {
    /// The start itself.
    pub fn start(start: Date) -> Self {
        Self { nanos: start.nanos.into(), of_day: None }
    }

    /// The start, or the midnight before it if the time of the first frame, ns, shows times of day: no log begins with
    /// hours without a frame that are just the time of day of its date.
    pub fn of(start: Date, first: i128) -> Self {
        let (nanos, half) = (i128::from(start.nanos), NANOS_PER_DAY / 2);
        let of_day = nanos.rem_euclid(NANOS_PER_DAY);
        // Not every tool knows which half of the day begins at noon: the frame decides.
        let other = (of_day + half) % NANOS_PER_DAY;
        let is_near =
            |of_day: i128| of_day >= LEAST_OF_DAY && (-BEFORE..=BEHIND).contains(&(first - of_day));
        if is_near(of_day) || (start.is_halved && is_near(other)) {
            return Self { nanos: nanos - of_day, of_day: Some(first) };
        }
        Self::start(start)
    }

    /// The time `now` of an event since 1970, ns. Times of day begin again at midnight.
    pub fn since_1970(&mut self, now: i128) -> i128 {
        if let Some(newest) = &mut self.of_day {
            if now - *newest < -NANOS_PER_DAY / 2 {
                self.nanos += NANOS_PER_DAY;
            }
            *newest = now;
        }
        self.nanos + now
    }
}
