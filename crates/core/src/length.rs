//! Lengths as text, in millimetres.

use alloc::format;
use alloc::string::String;
use core::fmt;

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
    fn decimals_are_those_asked_for_or_those_that_people_read() {
        let of = |metres| Millimetres(metres);
        assert_eq!([of(1.2345e-3), of(0.0123)].map(|it| format!("{it}")), ["1.23 mm", "12.3 mm"]);
        assert_eq!(format!("{:.4}", of(1.23456e-3)), "1.2346 mm");
        assert_eq!(format!("{:+.1}", of(1e-3)), "+1.0 mm");
        assert_eq!([of(5e-4), of(1.234e-3)].map(Millimetres::chosen), ["0.5 mm", "1.23 mm"]);
    }
}
