//! Origin of a table, as TOML comments.

use crate::survey::{Timeline, Window};
use tertius_core::time::Timestamp;

/// Seconds of a year.
const YEAR: i64 = 365 * 86_400;

/// First lines of a file of tables by `command`; `parts` of the recording and their names.
pub fn heading(
    version: &str,
    command: &str,
    machine: &str,
    inputs: &str,
    timeline: &Timeline,
    parts: &[(&str, Window)],
) -> String {
    let mut text = format!(
        "# By tertius {version} {command}, for {}.\n# From {}\n",
        one_line(machine),
        one_line(inputs)
    );
    for (name, window) in parts {
        let at = |seconds: f64| date(timeline.at(seconds));
        let Window { from, to } = *window;
        text += &format!("# {name} {from:.2} s to {to:.2} s, {} to {}\n", at(from), at(to));
    }
    text
}

/// A number of times in words: once, or a number.
pub fn times(count: f64) -> String {
    if count == 1.0 { "once".to_owned() } else { format!("{count} times") }
}

/// Name of a tail.
pub const fn tail(heavy: bool) -> &'static str {
    if heavy { "a generalised Pareto, beyond the evidence exponential," } else { "an exponential" }
}

/// `text` on one line, so that a name cannot end the comment that it stands in.
pub fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// The day of `at`, UTC, as YYYY-MM-DD; `None` for a recording that counts from zero, whose day nobody
/// knows, and beyond the years of four digits.
pub fn day(at: Timestamp) -> Option<String> {
    let known = (YEAR..8000 * YEAR).contains(&at.as_nanos().div_euclid(1_000_000_000));
    known.then(|| date(at).chars().take(10).collect())
}

/// Date and time of day, UTC. A recording that counts from zero begins in 1970.
pub fn date(at: Timestamp) -> String {
    let seconds = at.as_nanos().div_euclid(1_000_000_000);
    let (days, time) = (seconds.div_euclid(86_400), seconds.rem_euclid(86_400));
    // The civil calendar by eras of 400 years that begin on 1 March (Hinnant).
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted.div_euclid(146_097), shifted.rem_euclid(146_097));
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = era * 400 + year_of_era + i64::from(month <= 2);
    let (hours, minutes, seconds) = (time / 3600, time / 60 % 60, time % 60);
    format!("{year:04}-{month:02}-{day:02} {hours:02}:{minutes:02}:{seconds:02} UTC")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_stays_in_its_comment() {
        let named = heading("1", "tune", "a\n[fde]\nhigh = 1", "log\r", &Timeline::default(), &[]);
        assert!(named.lines().all(|line| line.starts_with('#')), "{named}");
    }

    #[test]
    fn a_recording_that_counts_from_zero_has_no_day() {
        let of = |seconds: i64| day(Timestamp::from_nanos(seconds * 1_000_000_000));
        assert_eq!(of(86_400), None);
        assert_eq!(of(-1), None);
        assert_eq!(of(1_700_000_000).as_deref(), Some("2023-11-14"));
    }

    #[test]
    fn dates_are_those_of_the_calendar() {
        let of = |seconds: i64| date(Timestamp::from_nanos(seconds * 1_000_000_000));
        assert_eq!(of(0), "1970-01-01 00:00:00 UTC");
        assert_eq!(of(-1), "1969-12-31 23:59:59 UTC");
        assert_eq!(of(951_827_696), "2000-02-29 12:34:56 UTC");
        assert_eq!(of(1_700_000_000), "2023-11-14 22:13:20 UTC");
        assert_eq!(of(4_107_542_399), "2100-02-28 23:59:59 UTC");
        assert_eq!(of(4_107_542_400), "2100-03-01 00:00:00 UTC");
    }
}
