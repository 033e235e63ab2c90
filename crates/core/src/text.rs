//! Lengths, lists and counts in words.

use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec;
use alloc::vec::Vec;
use core::fmt;

/// A list in a sentence: `a`, `a and b`, `a, b and c`; empty without any.
pub fn listed(names: &[impl AsRef<str>]) -> String {
    let [first @ .., last] = names else { return String::new() };
    let first: Vec<&str> = first.iter().map(AsRef::as_ref).collect();
    let and = if first.is_empty() { "" } else { " and " };
    format!("{}{and}{}", first.join(", "), last.as_ref())
}

/// Numbers in ascending order, three or more in a row as a range `to` its end: `1 to 3`, `5`, `6`.
pub fn ranges(numbers: &[u8], to: &str) -> Vec<String> {
    let rows = numbers.chunk_by(|one, next| one + 1 == *next);
    rows.flat_map(|row| match row {
        [first, _, .., last] => vec![format!("{first}{to}{last}")],
        few => few.iter().map(u8::to_string).collect(),
    })
    .collect()
}

/// A count with its noun, whose plural ends with an s.
pub fn counted(count: u64, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// A length in m, written in mm with its unit: with the decimals that the format asks for, or else as people read
/// it, with two below 10 mm and one beyond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Millimetres(pub f64);

impl Millimetres {
    /// What somebody has chosen, to a hundredth and without idle zeros: 0.5 mm.
    pub fn chosen(self) -> String {
        format!("{} mm", libm::round(self.0 * 1e5) / 100.0)
    }
}

impl fmt::Display for Millimetres {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0 * 1e3;
        match f.precision() {
            Some(_) => fmt::Display::fmt(&size, f)?,
            None if size.abs() < 10.0 => write!(f, "{size:.2}")?,
            None => write!(f, "{size:.1}")?,
        }
        f.write_str(" mm")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_has_one_and() {
        let of = |names: &[&str]| listed(names);
        assert_eq!([of(&[]), of(&["a"]), of(&["a", "b"])], ["", "a", "a and b"]);
        assert_eq!(listed(&ranges(&[1, 2, 3, 5, 6], " to ")), "1 to 3, 5 and 6");
        assert_eq!([0, 1].map(|it| counted(it, "frame")), ["0 frames", "1 frame"]);
    }

    #[test]
    fn decimals_are_those_asked_for_or_those_that_people_read() {
        let of = |metres| Millimetres(metres);
        assert_eq!([of(1.2345e-3), of(0.0123)].map(|it| format!("{it}")), ["1.23 mm", "12.3 mm"]);
        assert_eq!(format!("{:.4}", of(1.23456e-3)), "1.2346 mm");
        assert_eq!(format!("{:+.1}", of(1e-3)), "+1.0 mm");
        assert_eq!([of(5e-4), of(1.234e-3)].map(Millimetres::chosen), ["0.5 mm", "1.23 mm"]);
    }
}
