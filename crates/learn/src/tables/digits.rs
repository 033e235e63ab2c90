//! Numbers as tables have them.

/// A list of numbers with six decimals.
pub(super) fn six(values: &[f64]) -> String {
    let texts: Vec<String> = values.iter().map(|value| format!("{value:.6e}")).collect();
    format!("[{}]", texts.join(", "))
}
