//! Time in the monitor: integers of nanoseconds, taken from frames, never from a clock.
//!
//! `Display` writes both types in seconds with all their digits, without a conversion to floating
//! point, so that a time stamp can be searched for in its recording.

use crate::state::{StateError, StateReader, StateWriter, Stateful, Whole, shape_of_name};
use core::fmt;

/// An instant in nanoseconds since the Unix epoch (or since whatever a recording counts from).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Timestamp(i64);

/// A signed distance between two [`Timestamp`]s, in nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Span(i64);

/// The farthest times that are taken up: a century and a half from the epoch, so that the distance between two of
/// them does not overflow.
const FARTHEST: i64 = 1 << 62;

impl Stateful for Timestamp {
    const SHAPE: u64 = shape_of_name("Timestamp");

    fn save(&self, into: &mut StateWriter) {
        self.0.save(into);
    }

    fn resume(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        *self = Self::read(from)?;
        Ok(())
    }
}

impl Whole for Timestamp {
    fn read(from: &mut StateReader<'_>) -> Result<Self, StateError> {
        let nanos = i64::read(from)?;
        let is_near = (-FARTHEST..=FARTHEST).contains(&nanos);
        if is_near { Ok(Self(nanos)) } else { Err(StateError::Unsound { what: "time stamp" }) }
    }
}

impl Stateful for Span {
    const SHAPE: u64 = shape_of_name("Span");

    fn save(&self, into: &mut StateWriter) {
        self.0.save(into);
    }

    fn resume(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        self.0.resume(from)
    }
}

const NANOS_PER_SECOND: f64 = 1e9;

impl Timestamp {
    pub const fn from_nanos(nanos: i64) -> Self {
        Self(nanos)
    }

    pub const fn as_nanos(self) -> i64 {
        self.0
    }

    /// The signed distance from `earlier` to `self`; saturates instead of overflowing.
    pub const fn since(self, earlier: Self) -> Span {
        Span(self.0.saturating_sub(earlier.0))
    }

    /// `self + span`; saturates instead of overflowing.
    pub const fn after(self, span: Span) -> Self {
        Self(self.0.saturating_add(span.0))
    }

    /// Seconds as a float, for calculation; its resolution is 0.24 µs at today's epoch. For people
    /// and files use `Display`.
    pub fn as_seconds(self) -> f64 {
        self.0 as f64 / NANOS_PER_SECOND
    }
}

impl Span {
    pub const ZERO: Self = Self(0);

    pub const fn from_nanos(nanos: i64) -> Self {
        Self(nanos)
    }

    /// The nearest whole number of nanoseconds; saturates, and maps NaN to zero.
    pub fn from_seconds(seconds: f64) -> Self {
        Self(libm::round(seconds * NANOS_PER_SECOND) as i64)
    }

    pub const fn as_nanos(self) -> i64 {
        self.0
    }

    pub fn as_seconds(self) -> f64 {
        self.0 as f64 / NANOS_PER_SECOND
    }
}

impl fmt::Display for Timestamp {
    /// Writes seconds with all digits, `1700000066.062416`: at least one decimal, without trailing
    /// zeros.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_seconds(f, self.0)
    }
}

impl fmt::Display for Span {
    /// Writes seconds as [`Timestamp`] does: `-0.02`, `300.0`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_seconds(f, self.0)
    }
}

fn write_seconds(f: &mut fmt::Formatter<'_>, nanos: i64) -> fmt::Result {
    let sign = if nanos < 0 { "-" } else { "" };
    let size = nanos.unsigned_abs();
    let (seconds, mut fraction, mut digits) = (size / 1_000_000_000, size % 1_000_000_000, 9);
    while digits > 1 && fraction.is_multiple_of(10) {
        fraction /= 10;
        digits -= 1;
    }
    write!(f, "{sign}{seconds}.{fraction:0digits$}")
}

/// Whole cycles nearest to `seconds`, of cycles that follow each other every `sample_time` seconds.
pub fn cycles(seconds: f64, sample_time: f64) -> u32 {
    libm::round(seconds / sample_time) as u32
}

/// The least rate at which a time is as many cycles as it takes, as a sample time, s.
const SLOWEST_BY_TIME: f64 = 0.02;

/// The same of what is told from samples, and by time only where these come fast enough: below 50 Hz it
/// takes as many of them as at 50 Hz.
pub fn samples(seconds: f64, sample_time: f64) -> u32 {
    cycles(seconds, sample_time.min(SLOWEST_BY_TIME))
}

/// What is left of something after a time, as one number of it fades from cycle to cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decay {
    /// The part that is left, 0 to 1, …
    pub left: f64,
    /// … after so long, s.
    pub after: f64,
}

impl Decay {
    /// What is left after a cycle of `sample_time` seconds.
    pub fn per_cycle(&self, sample_time: f64) -> f64 {
        libm::pow(self.left, sample_time / self.after)
    }
}

/// Hours of a mean year.
pub const HOURS_PER_YEAR: f64 = 8766.0;

/// A rate in events a year as events a second.
pub const fn per_second(per_year: f64) -> f64 {
    per_year / (HOURS_PER_YEAR * 3600.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_told_from_samples_takes_as_many_of_them_below_50_hz() {
        let of = |rate: f64| (cycles(0.5, 1.0 / rate), samples(0.5, 1.0 / rate));
        assert_eq!([10.0, 50.0, 100.0].map(of), [(5, 25), (25, 25), (50, 50)]);
    }

    #[test]
    fn a_decay_is_one_of_time() {
        let decay = Decay { left: 0.9, after: 0.02 };
        assert_eq!(decay.per_cycle(0.02), 0.9);
        assert!((decay.per_cycle(0.1) - 0.9_f64.powi(5)).abs() < 1e-15);
    }

    #[test]
    fn seconds_are_written_digit_by_digit() {
        for (nanos, text) in [
            (1_700_000_066_062_416_000, "1700000066.062416"),
            (1_700_000_066_062_415_823, "1700000066.062415823"),
            (1_700_000_060_002_280_000, "1700000060.00228"),
            (300_000_000_000, "300.0"),
            (0, "0.0"),
            (1, "0.000000001"),
            (-20_000_000, "-0.02"),
            (i64::MIN, "-9223372036.854775808"),
            (i64::MAX, "9223372036.854775807"),
        ] {
            assert_eq!(Timestamp::from_nanos(nanos).to_string(), text);
            assert_eq!(Span::from_nanos(nanos).to_string(), text);
        }
    }
}
