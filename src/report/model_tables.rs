//! Identified models as tables that the configuration reads.

use crate::identify::outcome::{Choice, Identified, Outcome};
use crate::time::Timestamp;
use std::fmt::Write as _;

/// Keys of a cylinder that belong to its model.
pub const OF_A_MODEL: [&str; 4] = ["theta", "gamma", "sample_time", "command_offset"];

/// The tables of `outcome`, with what they were made from; `per_cylinder`: each cylinder its own
/// model instead of the chosen one for all. `None` where there is no model.
pub fn tables(outcome: &Outcome, version: &str, per_cylinder: bool) -> Option<String> {
    let choice = outcome.choice?;
    let chosen = outcome.identified(choice.of)?;
    let mut text = provenance(outcome, version);
    let taken = if choice.asked { "asked for" } else { "its worst is the best of all" };
    let Choice { of, worst, .. } = choice;
    _ = writeln!(
        text,
        "\n# (4-1), identified on cylinder {of}: {taken}; simulated on every cylinder its position \
         VAF is at least {worst:.2} %.\n[model]\n{}",
        parameters(chosen, outcome.shaping.sample_time)
    );
    for cylinder in &outcome.cylinders {
        let Ok(own) = &cylinder.result else { continue };
        let offset = own.estimate.command_offset;
        if !per_cylinder && offset.is_none() {
            continue;
        }
        _ = writeln!(text, "\n[[cylinder]]\nn = {}", cylinder.number);
        if per_cylinder {
            _ = writeln!(text, "{}", parameters(own, outcome.shaping.sample_time));
        }
        if let Some(offset) = offset {
            _ = writeln!(text, "command_offset = {offset:?}  # m/s; the command at which it rests");
        }
    }
    Some(text)
}

/// Where, when and from what, as comments.
fn provenance(outcome: &Outcome, version: &str) -> String {
    let at = |seconds: f64| date(outcome.timeline.at(seconds));
    let window = |name: &str, window: &crate::survey::Window| {
        let (from, to) = (window.from, window.to);
        format!("# {name} {from:.2} s to {to:.2} s, {} to {}\n", at(from), at(to))
    };
    let mut text = format!(
        "# By tertius {version} identify, for {}.\n# From {}\n",
        one_line(&outcome.machine),
        one_line(&outcome.inputs)
    );
    text += &window("fitted   ", &outcome.fitted);
    text += &window("validated", &outcome.validated);
    let shaping = &outcome.shaping;
    _ = writeln!(
        text,
        "# moving average over {} cycles of {} s; area ratio {} of (3-5)",
        shaping.window, shaping.sample_time, shaping.area_ratio
    );
    for cylinder in &outcome.cylinders {
        if let Err(refusal) = &cylinder.result {
            let refusal = one_line(&refusal.to_string());
            _ = writeln!(text, "# cylinder {} was refused: {refusal}", cylinder.number);
        }
    }
    text += "# Keys of [[cylinder]] belong into that cylinder's table, where the file has one.\n";
    text
}

fn parameters(identified: &Identified, sample_time: f64) -> String {
    let estimate = &identified.estimate;
    let (theta, gamma) = (estimate.theta, estimate.gamma);
    format!("theta = {theta:?}\ngamma = {gamma:?}\nsample_time = {sample_time:?}")
}

/// A name cannot end the comment that it stands in.
fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
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
