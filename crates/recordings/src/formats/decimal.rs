//! Decimal numbers with a point.

/// Most digits on either side of a point, so that no product is out of range. Further decimals, which are
/// below anything that matters, are left out.
const DIGITS: usize = 12;

/// A number with decimals, in units of which it has `unit` to one, rounded.
pub fn number(text: &[u8], unit: i128) -> Option<i128> {
    let (sign, text) = text.strip_prefix(b"-").map_or((1, text), |text| (-1, text));
    let point = memchr::memchr(b'.', text);
    let (whole, decimals) = point.map_or((text, &b""[..]), |at| (&text[..at], &text[at + 1..]));
    if whole.is_empty() || whole.len() > DIGITS || !decimals.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let decimals = &decimals[..decimals.len().min(DIGITS)];
    let add = |value: i128, digit: &u8| {
        digit.is_ascii_digit().then(|| 10 * value + i128::from(digit - b'0'))
    };
    let digits = whole.iter().chain(decimals).try_fold(0, add)?;
    let parts = 10_i128.pow(decimals.len() as u32);
    Some(sign * ((digits * unit + parts / 2) / parts))
}
