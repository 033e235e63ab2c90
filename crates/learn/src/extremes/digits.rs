//! Digits of a threshold.

/// The least number of four digits that is not below `value`: a threshold has no more significant
/// digits, and must not be rounded down.
pub fn four_digits(value: f64) -> f64 {
    if !(value > 0.0 && value.is_finite()) {
        return value;
    }
    let unit = 10_f64.powf(value.log10().floor() - 3.0);
    // By way of text, so that no digits of the division are left.
    let text = format!("{:.3e}", (value / unit - 1e-6).ceil() * unit);
    text.parse().unwrap_or(value)
}

/// How many times, with three digits and without an exponent: `1.53`, `13400`.
pub fn times(factor: f64) -> String {
    if !(factor > 0.0 && factor.is_finite()) {
        return factor.to_string();
    }
    // Rounded first: 9.996 has as many decimals as 10.0.
    let text = format!("{factor:.2e}");
    let exponent = text.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok());
    let digits = exponent.map_or(0, |exponent| (2 - exponent).max(0)) as usize;
    let rounded = text.parse().unwrap_or(factor);
    format!("{rounded:.digits$}")
}

/// A rate of false alarms in words: `1 false alarm a year`.
pub fn false_alarms(per_year: f64) -> String {
    format!("{per_year} false alarm{} a year", if per_year == 1.0 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_has_three_digits_and_no_exponent() {
        for (factor, told) in [
            (1.5272, "1.53"),
            (13_389.4, "13400"),
            (99.96, "100"),
            (9.996, "10.0"),
            (999.6, "1000"),
            (0.9996, "1.00"),
            (1.0, "1.00"),
            (100.0, "100"),
            (0.0421, "0.0421"),
            (8766.0, "8770"),
        ] {
            assert_eq!(times(factor), told);
        }
        assert_eq!(false_alarms(1.0), "1 false alarm a year");
        assert_eq!(false_alarms(0.5), "0.5 false alarms a year");
    }

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
}
