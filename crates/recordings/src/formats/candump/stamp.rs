//! The text between a line's parentheses.

use crate::reason::Reason;

const NANOS_PER_SECOND: i128 = 1_000_000_000;

/// Least number of digits of seconds since 1970: candump pads absolute time stamps to ten digits.
const ABSOLUTE_DIGITS: usize = 9;

/// Origin of a time stamp, as far as its form shows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// Counted from 1970: many digits, or a date.
    Absolute,
    /// Counted from the recording's start or from the previous line.
    Short,
}

/// A time stamp as it stands in a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    pub nanos: i64,
    pub extent: Extent,
    /// Its seven decimals, where it has so many. candump writes six or nine.
    pub seven: Option<Seven>,
}

/// Seven decimals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seven {
    /// `1000000`: tenths of a microsecond, or a million microseconds.
    Million,
    Other,
}

impl Stamp {
    /// Reads the text between the parentheses.
    pub fn parse(text: &[u8]) -> Result<Self, Reason> {
        if text.get(4) == Some(&b'-') {
            let nanos = date(text)?;
            return Ok(Self { nanos, extent: Extent::Absolute, seven: None });
        }
        let (negative, text) = match text.strip_prefix(b"-") {
            Some(rest) => (true, rest),
            None => (false, text),
        };
        let (whole, fraction) = split_fraction(text)?;
        let long = whole.len() >= ABSOLUTE_DIGITS;
        let extent = if long { Extent::Absolute } else { Extent::Short };
        let nanos = i128::from(seconds(whole)?) * NANOS_PER_SECOND + i128::from(fraction);
        let nanos = in_range(if negative { -nanos } else { nanos })?;
        let seven = match text.get(whole.len() + 1..) {
            Some(b"1000000") => Some(Seven::Million),
            Some([_, _, _, _, _, _, _]) => Some(Seven::Other),
            _ => None,
        };
        Ok(Self { nanos, extent, seven })
    }
}

fn in_range(nanos: i128) -> Result<i64, Reason> {
    i64::try_from(nanos).map_err(|_| Reason::StampRange)
}

/// The text before the point, and the decimals in nanoseconds.
fn split_fraction(text: &[u8]) -> Result<(&[u8], u32), Reason> {
    let (whole, decimals) = match memchr::memchr(b'.', text) {
        Some(point) => (&text[..point], &text[point + 1..]),
        None => (text, &b""[..]),
    };
    if decimals.len() > 9 || !decimals.iter().all(u8::is_ascii_digit) {
        return Err(Reason::Stamp);
    }
    let padded = decimals.iter().copied().chain(std::iter::repeat(b'0')).take(9);
    Ok((whole, padded.fold(0, |nanos, digit| nanos * 10 + u32::from(digit - b'0'))))
}

fn seconds(text: &[u8]) -> Result<u64, Reason> {
    if text.is_empty() || !text.iter().all(u8::is_ascii_digit) {
        return Err(Reason::Stamp);
    }
    let add = |value: u64, &digit: &u8| value.checked_mul(10)?.checked_add((digit - b'0').into());
    text.iter().try_fold(0u64, add).ok_or(Reason::StampRange)
}

/// Reads `YYYY-MM-DD HH:MM:SS` with or without decimals, taken as UTC.
fn date(text: &[u8]) -> Result<i64, Reason> {
    let (whole, fraction) = split_fraction(text)?;
    let shape = b"0000-00-00 00:00:00";
    let fits = |(&byte, &model): (&u8, &u8)| match model {
        b'0' => byte.is_ascii_digit(),
        _ => byte == model,
    };
    if whole.len() != shape.len() || !whole.iter().zip(shape).all(fits) {
        return Err(Reason::Stamp);
    }
    let field = |from: usize, to: usize| {
        whole[from..to].iter().fold(0i64, |value, digit| value * 10 + i64::from(digit - b'0'))
    };
    let (year, month, day) = (field(0, 4), field(5, 7), field(8, 10));
    let (hour, minute, second) = (field(11, 13), field(14, 16), field(17, 19));
    // 60 is a leap second, which strftime may write.
    if !(1..=12).contains(&month) || !(1..=days_in(year, month)).contains(&day) {
        return Err(Reason::Stamp);
    }
    if hour > 23 || minute > 59 || second > 60 {
        return Err(Reason::Stamp);
    }
    let seconds = ((days_since_1970(year, month, day) * 24 + hour) * 60 + minute) * 60 + second;
    in_range(i128::from(seconds) * NANOS_PER_SECOND + i128::from(fraction))
}

fn days_in(year: i64, month: i64) -> i64 {
    let leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
    match month {
        2 => 28 + i64::from(leap),
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

/// Days in the Gregorian calendar, counted in years that begin in March so that the leap day is
/// the last; `year` is not negative.
fn days_since_1970(year: i64, month: i64, day: i64) -> i64 {
    let year = if month <= 2 { year - 1 } else { year };
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    year * 365 + year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400) + day_of_year
        - 719_468
}
