//! Where, when and from what a table was made, as comments of TOML.

use super::model_tables::date;
use crate::survey::{Timeline, Window};

/// The first lines of a file of tables by `command`; `parts` of the recording and their names.
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

/// What a tail is, in words.
pub const fn tail(heavy: bool) -> &'static str {
    if heavy { "a generalised Pareto, beyond the evidence exponential," } else { "an exponential" }
}

/// A name cannot end the comment that it stands in.
pub fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// The least number of four digits that is not below `value`: a threshold has no more than that to
/// say, and is not rounded to less.
pub fn four_digits(value: f64) -> f64 {
    if !(value > 0.0 && value.is_finite()) {
        return value;
    }
    let unit = 10_f64.powf(value.log10().floor() - 3.0);
    // By way of text, so that no digits of the division are left.
    let text = format!("{:.3e}", (value / unit - 1e-6).ceil() * unit);
    text.parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_have_four_digits_and_are_rounded_up() {
        for (value, rounded) in [
            (0.001_234_1, 0.001_235),
            (0.001_234, 0.001_234),
            (0.064_999_9, 0.065),
            (9.9999, 10.0),
            (1.0, 1.0),
        ] {
            assert_eq!(four_digits(value), rounded, "{value}");
        }
    }

    #[test]
    fn a_name_stays_in_its_comment() {
        let named = heading("1", "tune", "a\n[fde]\nhigh = 1", "log\r", &Timeline::default(), &[]);
        assert!(named.lines().all(|line| line.starts_with('#')), "{named}");
    }
}
