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
}
