//! Numbers of a table as text.

use std::io::Write;

/// Appends the shortest decimal number that reads back as `value`, never with an exponent: as its `Display` does, for a
/// part of the instructions, but for the last digit where two numbers are as short and as near.
pub fn append(row: &mut Vec<u8>, value: f64) {
    // Beyond this zmij writes an exponent.
    if value == 0.0 || (1e-5..1e16).contains(&value.abs()) {
        let mut digits = zmij::Buffer::new();
        let text = digits.format_finite(value);
        row.extend_from_slice(text.strip_suffix(".0").unwrap_or(text).as_bytes());
    } else {
        // A vector takes whatever is written to it.
        let _ = write!(row, "{value}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_as_short_as_display_s_and_reads_back_the_same() {
        let mut bits = 0x9E37_79B9_7F4A_7C15_u64;
        let wild = (0..100_000).map(|_| {
            bits = bits.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
            f64::from_bits(bits)
        });
        let usual = (0..100_000).map(|k| f64::from(k - 50_000) * 1.234_567e-7);
        let large = (0..100_000_u64).map(|k| (k * 0xF_FFFF_FFFB) as f64 / 1024.0);
        let limits = [0.0, -0.0, 1.0, 100.0, 1e-5, 9.999e-6, 1e12, 1e16, 123_456_789.0];
        let special = [f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN_POSITIVE, 5e-324];
        let (mut count, mut differ) = (0, 0);
        for value in wild.chain(usual).chain(large).chain(limits).chain(special) {
            let mut row = Vec::new();
            append(&mut row, value);
            let (text, display) = (String::from_utf8_lossy(&row), value.to_string());
            let back: f64 = text.parse().expect("it is a number");
            assert!(back.to_bits() == value.to_bits() || value.is_nan(), "{text}, {display}");
            assert!(text.len() == display.len() && !text.contains('e'), "{text}, {display}");
            (count, differ) = (count + 1, differ + usize::from(text != display));
        }
        assert!(differ < count / 100, "{differ} of {count}");
    }
}
